// The comparison of elements in rows: of one set in the order of `RowsInput`, of two in that of `CrossInput`.
#pragma once
#include "rows.h"

// Elements in their order.
struct Set {
    const void *coordinates;
    // Null for one radius.
    const void *radii;
    const u32 *ids;
    // The numbers of a filter: bodies, then categories and masks, or groups. Null for kinds that it lacks.
    const u32 *bodies;
    const u32 *firsts;
    const u32 *seconds;
    u64 count;
};

// The comparison of two sets, or of one set with itself.
struct Pairs {
    Set own;
    Set other;
    // Which groups see each other, in rows of whole words; null for categories and masks.
    const u32 *matrix;
    u64 words;
    // How many couples each element has.
    u32 *counts;
    // Couples of the elements before.
    const u64 *before;
    // Two numbers of each couple.
    u32 *couples;
    double reach;
    double reach_squared;
    double tolerance;
    // The axis along the rows.
    u64 axis;
};

// The closed comparison of `Elements`, in the type of the coordinates.
template <typename T, int D> INLINE bool touch(const Pairs &a, u64 p, u64 q) {
    const T *own = (const T *)a.own.coordinates, *other = (const T *)a.other.coordinates;
    T sum = 0;
    for (int axis = 0; axis < D; ++axis) {
        const T difference = own[axis * a.own.count + p] - other[axis * a.other.count + q];
        sum = sum + difference * difference;
    }
    if (!a.own.radii) return sum <= (T)a.reach_squared;
    const T reach = (((const T *)a.own.radii)[p] + ((const T *)a.other.radii)[q]) + (T)a.tolerance;
    return sum <= reach * reach;
}

// Twin of `Filter::admits`.
INLINE bool admits(const Pairs &a, u64 p, u64 q) {
    if (a.own.bodies && a.own.bodies[p] == a.other.bodies[q]) return false;
    if (a.matrix) {
        const u32 group = a.other.firsts[q];
        return a.matrix[a.own.firsts[p] * a.words + group / 32] >> (group % 32) & 1;
    }
    if (!a.own.firsts) return true;
    return (a.own.firsts[p] & a.other.seconds[q]) != 0 && (a.other.firsts[q] & a.own.seconds[p]) != 0;
}

// The first place from `from` up to `end` that is not more than the reach before `x`.
template <typename T> INLINE u64 first_near(const T *along, u64 from, u64 end, T x, T reach) {
    while (from < end) {
        const u64 middle = from + (end - from) / 2;
        if (x - along[middle] > reach) {
            from = middle + 1;
        } else {
            end = middle;
        }
    }
    return from;
}

// The couples of an element with those of a row from `q` on: adds how many there are, and writes them if
// there is a list. Of one set, the smaller number comes first.
template <typename T, int D, bool ONE_SET>
INLINE void window(const Pairs &a, u64 p, u64 q, u64 end, u32 *found, u32 *couples) {
    const T *along = (const T *)a.other.coordinates + a.axis * a.other.count;
    const T x = ((const T *)a.own.coordinates)[a.axis * a.own.count + p], reach = (T)a.reach;
    for (; q < end && along[q] - x <= reach; ++q) {
        if (touch<T, D>(a, p, q) && admits(a, p, q)) {
            if (couples) {
                const u32 i = a.own.ids[p], j = a.other.ids[q];
                const bool swap = ONE_SET && j < i;
                couples[2 * (u64)*found] = swap ? j : i;
                couples[2 * (u64)*found + 1] = swap ? i : j;
            }
            ++*found;
        }
    }
}

// One set, compared with itself.
struct OneSet {
    Pairs pairs;
    const u32 *row_of;
    const u32 *starts;
    const u32 *neighbours;
    u64 mask;
};

template <typename T, int D> INLINE u32 partners(const OneSet &a, u64 p, u32 *couples) {
    const Set &set = a.pairs.own;
    const T *along = (const T *)set.coordinates + a.pairs.axis * set.count;
    const u32 row = a.row_of[p];
    u32 found = 0;
    window<T, D, true>(a.pairs, p, p + 1, a.starts[row + 1], &found, couples);
    for (u32 k = 0; k < a.mask; ++k) {
        const u32 other = a.neighbours[row * a.mask + k];
        if (other == NONE) continue;
        const u64 end = a.starts[other + 1];
        const u64 from = first_near<T>(along, a.starts[other], end, along[p], (T)a.pairs.reach);
        window<T, D, true>(a.pairs, p, from, end, &found, couples);
    }
    return found;
}

// Two sets. The rows are those of the other set.
struct TwoSets {
    Pairs pairs;
    const u32 *starts;
    const u64 *rows;
    u64 row_count;
    Cells cells;
    // The last cell along each axis.
    double last[3];
};

// The first row from `row` on whose cells are not before these.
INLINE u64 row_from(const u64 *rows, u64 row, u64 end, u64 third, u64 second) {
    while (row < end) {
        const u64 middle = row + (end - row) / 2;
        const u64 one = rows[2 * middle], two = rows[2 * middle + 1];
        if (one < third || (one == third && two < second)) {
            row = middle + 1;
        } else {
            end = middle;
        }
    }
    return row;
}

// The first and the last cell along an axis that have points within the reach of `x`; false if there are
// none. The quotient ascends with the coordinate, whatever the rounding, so no cell is missed.
INLINE bool cells_near(const TwoSets &a, u32 axis, double x, u64 *first, u64 *last) {
    const double origin = a.cells.origin[axis], inverse = a.cells.inverse, end = a.last[axis];
    const double low = ((x - a.pairs.reach) - origin) * inverse, high = ((x + a.pairs.reach) - origin) * inverse;
    if (!(low <= end + 1.0 && high >= -1.0)) return false;
    const u64 integer = (1ull << 52) - 1;
    *first = bits_of((low < 0.0 ? 0.0 : low > end ? end : low) + NO_FRACTION) & integer;
    *last = bits_of((high < 0.0 ? 0.0 : high > end ? end : high) + NO_FRACTION) & integer;
    return true;
}

template <typename T, int D> INLINE u32 partners(const TwoSets &a, u64 p, u32 *couples) {
    const Set &own = a.pairs.own, &other = a.pairs.other;
    const T *coordinates = (const T *)own.coordinates;
    const T *along = (const T *)other.coordinates + a.pairs.axis * other.count;
    const T x = coordinates[a.pairs.axis * own.count + p];
    const u32 *axes = a.cells.axes;
    u64 third[2] = {0, 0}, second[2];
    if (!cells_near(a, axes[1], (double)coordinates[axes[1] * own.count + p], second, second + 1)) return 0;
    if (D == 3 && !cells_near(a, axes[2], (double)coordinates[axes[2] * own.count + p], third, third + 1)) return 0;
    u32 found = 0;
    u64 row = row_from(a.rows, 0, a.row_count, third[0], second[0]);
    while (row < a.row_count && a.rows[2 * row] <= third[1]) {
        const u64 one = a.rows[2 * row], two = a.rows[2 * row + 1];
        if (two < second[0]) {
            row = row_from(a.rows, row, a.row_count, one, second[0]);
        } else if (two > second[1]) {
            row = row_from(a.rows, row, a.row_count, one + 1, second[0]);
        } else {
            const u64 end = a.starts[row + 1];
            const u64 from = first_near<T>(along, a.starts[row], end, x, (T)a.pairs.reach);
            window<T, D, false>(a.pairs, p, from, end, &found, couples);
            ++row;
        }
    }
    return found;
}

template <typename T, int D, typename Sets> INLINE void count_pairs(const Sets &a, u32 block) {
    EACH(place, a.pairs.own.count) {
        a.pairs.counts[place] = partners<T, D>(a, place, 0);
    }
}

template <typename T, int D, typename Sets> INLINE void list_pairs(const Sets &a, u32 block) {
    EACH(place, a.pairs.own.count) {
        if (a.pairs.counts[place] > 0) partners<T, D>(a, place, a.pairs.couples + 2 * a.pairs.before[place]);
    }
}

KERNEL(count_pairs_2, OneSet) { count_pairs<double, 2>(a, block); }
KERNEL(count_pairs_3, OneSet) { count_pairs<double, 3>(a, block); }
KERNEL(list_pairs_2, OneSet) { list_pairs<double, 2>(a, block); }
KERNEL(list_pairs_3, OneSet) { list_pairs<double, 3>(a, block); }
KERNEL(count_pairs_2_single, OneSet) { count_pairs<f32, 2>(a, block); }
KERNEL(count_pairs_3_single, OneSet) { count_pairs<f32, 3>(a, block); }
KERNEL(list_pairs_2_single, OneSet) { list_pairs<f32, 2>(a, block); }
KERNEL(list_pairs_3_single, OneSet) { list_pairs<f32, 3>(a, block); }
KERNEL(count_crosses_2, TwoSets) { count_pairs<double, 2>(a, block); }
KERNEL(count_crosses_3, TwoSets) { count_pairs<double, 3>(a, block); }
KERNEL(list_crosses_2, TwoSets) { list_pairs<double, 2>(a, block); }
KERNEL(list_crosses_3, TwoSets) { list_pairs<double, 3>(a, block); }
KERNEL(count_crosses_2_single, TwoSets) { count_pairs<f32, 2>(a, block); }
KERNEL(count_crosses_3_single, TwoSets) { count_pairs<f32, 3>(a, block); }
KERNEL(list_crosses_2_single, TwoSets) { list_pairs<f32, 2>(a, block); }
KERNEL(list_crosses_3_single, TwoSets) { list_pairs<f32, 3>(a, block); }
