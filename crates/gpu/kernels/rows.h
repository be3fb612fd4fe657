// Elements sorted into rows, in the order of `RowCells` of fdem-contact.
#pragma once
#include "platform.h"

// The numbers of `RowCells`.
struct Cells {
    double origin[3];
    double inverse;
    // The axes by their number of cells, largest first.
    u32 axes[3];
    u32 unused;
};

// 2^52: a number from here on is an integer.
const double NO_FRACTION = 4503599627370496.0;

// The cell of a coordinate along an axis; twin of `Grid::wide_cell`.
INLINE u64 cell_of(const Cells &cells, u32 axis, double x) {
    const double quotient = (x - cells.origin[axis]) * cells.inverse;
    return bits_of(quotient + NO_FRACTION) & ((1ull << 52) - 1);
}

// Coordinates and radii of elements are in `f32` or in `double`, which `single` says. Cells and keys are
// computed from them in `double`, and only the comparison is in their own type.
INLINE double number_at(const void *numbers, u32 single, u64 index) {
    return single ? (double)((const f32 *)numbers)[index] : ((const double *)numbers)[index];
}

// Copies a number.
INLINE void copy_number(void *to, u64 place, const void *from, u64 index, u32 single) {
    if (single) {
        ((f32 *)to)[place] = ((const f32 *)from)[index];
    } else {
        ((double *)to)[place] = ((const double *)from)[index];
    }
}

struct Keys {
    const void *points;
    u64 *keys;
    u32 *ids;
    Cells cells;
    // Which key: 0 for the row and the place in it together, 1 for the coordinate along the row, 2 and 3 for
    // the cell along the second and the third axis.
    u32 kind;
    // Whether elements are still in the order of their numbers, and `ids` is empty.
    u32 first;
    u32 place_bits;
    u32 dimensions;
    // Number of cells along the second axis.
    u64 second;
    u64 count;
    u32 single;
    u32 unused;
};

// An integer that ascends with the coordinate.
INLINE u64 ascending(double x) {
    const u64 bits = bits_of(x + 0.0);
    return bits >> 63 ? ~bits : bits | 1ull << 63;
}

// The coordinate of an element along the k-th of the axes, largest number of cells first, and its cell.
INLINE double coordinate(const Keys &a, u32 id, u32 k) {
    return number_at(a.points, a.single, (u64)id * a.dimensions + a.cells.axes[k]);
}

INLINE u64 cell_along(const Keys &a, u32 id, u32 k) {
    return cell_of(a.cells, a.cells.axes[k], coordinate(a, id, k));
}

// The key of each element.
KERNEL(row_keys, Keys) {
    EACH(place, a.count) {
        const u32 id = a.first ? (u32)place : a.ids[place];
        u64 key;
        if (a.kind == 0) {
            key = cell_along(a, id, 1);
            if (a.dimensions == 3) key += cell_along(a, id, 2) * a.second;
            // Quarters of a cell.
            const double along = (coordinate(a, id, 0) - a.cells.origin[a.cells.axes[0]]) * a.cells.inverse * 4.0;
            key = key << a.place_bits | (u64)along;
        } else if (a.kind == 1) {
            key = ascending(coordinate(a, id, 0));
        } else {
            key = cell_along(a, id, a.kind - 1);
        }
        a.keys[place] = key;
        if (a.first) a.ids[place] = id;
    }
}

struct Ranks {
    const void *points;
    const u64 *keys;
    const u32 *ids;
    u32 *ranked;
    // Set if many elements have one key.
    u32 *crowded;
    u64 count;
    u32 dimensions;
    u32 axis;
    u32 single;
    u32 unused;
};

// Elements that have one key, beyond which they are sorted by their coordinates instead.
const u64 FEW = 64;

// Sorts elements with one key along the row, then by number, in which order they already are.
KERNEL(row_ranks, Ranks) {
    EACH(place, a.count) {
        const u64 key = a.keys[place];
        u64 from = place, to = place + 1;
        while (from > 0 && place - from < FEW && a.keys[from - 1] == key) --from;
        while (to < a.count && to - place < FEW && a.keys[to] == key) ++to;
        if (to - from > FEW) {
            set_flag(a.crowded);
        } else {
            const double x = number_at(a.points, a.single, (u64)a.ids[place] * a.dimensions + a.axis);
            u64 rank = from;
            for (u64 k = from; k < to; ++k) {
                const double other = number_at(a.points, a.single, (u64)a.ids[k] * a.dimensions + a.axis);
                rank += other < x || (other == x && k < place);
            }
            a.ranked[rank] = a.ids[place];
        }
    }
}

struct Gather {
    const void *points;
    // Empty for one radius.
    const void *radii;
    const u32 *ids;
    // Coordinates axis by axis.
    void *coordinates;
    void *sorted_radii;
    // 1 for the first element of a row.
    u32 *heads;
    Cells cells;
    u64 count;
    u32 dimensions;
    u32 single;
};

// Copies the elements in their order, and finds those that begin a row.
KERNEL(row_gather, Gather) {
    EACH(place, a.count) {
        const u64 first = (u64)a.ids[place] * a.dimensions;
        const u64 last = place > 0 ? (u64)a.ids[place - 1] * a.dimensions : first;
        u32 head = place == 0;
        for (u32 axis = 0; axis < a.dimensions; ++axis) {
            copy_number(a.coordinates, (u64)axis * a.count + place, a.points, first + axis, a.single);
            if (axis != a.cells.axes[0]) {
                head |= cell_of(a.cells, axis, number_at(a.points, a.single, first + axis)) !=
                    cell_of(a.cells, axis, number_at(a.points, a.single, last + axis));
            }
        }
        if (a.radii) copy_number(a.sorted_radii, place, a.radii, a.ids[place], a.single);
        a.heads[place] = head;
    }
}

struct Starts {
    const void *coordinates;
    const u32 *heads;
    const u64 *before;
    u32 *row_of;
    u32 *starts;
    // Two cells of each row, along the third and the second axis; the first is 0 in two dimensions.
    u64 *rows;
    Cells cells;
    u64 count;
    u32 dimensions;
    u32 single;
};

INLINE u64 sorted_cell(const Starts &a, u32 axis, u64 place) {
    return cell_of(a.cells, axis, number_at(a.coordinates, a.single, (u64)axis * a.count + place));
}

// The rows: where each begins, and its cells.
KERNEL(row_starts, Starts) {
    EACH(place, a.count) {
        const u32 head = a.heads[place];
        const u32 row = (u32)a.before[place] + head - 1;
        a.row_of[place] = row;
        if (head) {
            const u32 *axes = a.cells.axes;
            a.starts[row] = (u32)place;
            a.rows[2 * (u64)row] = a.dimensions == 3 ? sorted_cell(a, axes[2], place) : 0;
            a.rows[2 * (u64)row + 1] = sorted_cell(a, axes[1], place);
        }
        if (place + 1 == a.count) a.starts[row + 1] = (u32)a.count;
    }
}

struct CellHeads {
    const void *coordinates;
    // 1 for the first element of a row.
    const u32 *heads;
    u32 *cell_heads;
    Cells cells;
    u64 count;
    u32 single;
    u32 unused;
};

// 1 for each element that is in another cell than the one before it.
KERNEL(cell_heads, CellHeads) {
    EACH(place, a.count) {
        const u32 axis = a.cells.axes[0];
        const u64 index = (u64)axis * a.count + place;
        u32 head = a.heads[place];
        if (!head) {
            head = cell_of(a.cells, axis, number_at(a.coordinates, a.single, index)) !=
                cell_of(a.cells, axis, number_at(a.coordinates, a.single, index - 1));
        }
        a.cell_heads[place] = head;
    }
}

struct GatherWords {
    const u32 *words;
    const u32 *ids;
    u32 *sorted;
    u64 count;
};

// Copies a number of each element in their order.
KERNEL(gather_words, GatherWords) {
    EACH(place, a.count) {
        a.sorted[place] = a.words[a.ids[place]];
    }
}

struct Neighbours {
    const u64 *rows;
    // For each row and each offset of the mask a row, or NONE.
    u32 *neighbours;
    u64 count;
    // Number of offsets.
    u32 mask;
    u32 unused;
};

const u32 NONE = 0xffffffffu;

// Rows of the mask by their offsets along the third and the second axis: in space all four, in the plane the
// last one.
INLINE void offset_of(u32 mask, u32 k, i64 *third, i64 *second) {
    const u32 number = mask == 1 ? 3 : k;
    *third = number == 3 ? 0 : -1;
    *second = number == 3 ? -1 : (i64)number - 1;
}

// Finds the rows of the mask around each row.
KERNEL(row_neighbours, Neighbours) {
    EACH(index, a.count * a.mask) {
        const u64 row = index / a.mask;
        i64 third, second;
        offset_of(a.mask, (u32)(index % a.mask), &third, &second);
        third += (i64)a.rows[2 * row];
        second += (i64)a.rows[2 * row + 1];
        u64 low = 0, high = row;
        while (low < high) {
            const u64 middle = low + (high - low) / 2;
            const i64 one = (i64)a.rows[2 * middle], two = (i64)a.rows[2 * middle + 1];
            if (one < third || (one == third && two < second)) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        const bool found = low < row && (i64)a.rows[2 * low] == third && (i64)a.rows[2 * low + 1] == second;
        a.neighbours[index] = found ? (u32)low : NONE;
    }
}
