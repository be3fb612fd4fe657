// Neighbour lists in compressed sparse rows, from a list of couples.
#pragma once
#include "pairs.h"

struct ListKeys {
    // Two numbers of each couple.
    const u32 *couples;
    u64 *keys;
    u32 *ids;
    u64 couple_count;
    // Entries: one of each couple, or two.
    u64 count;
    // Bits of a number.
    u32 bits;
    u32 unused;
};

// The row and the neighbour of each entry as one key. Entries beyond the couples are those of the larger
// number.
KERNEL(list_keys, ListKeys) {
    EACH(entry, a.count) {
        const bool is_larger = entry >= a.couple_count;
        const u64 couple = is_larger ? entry - a.couple_count : entry;
        const u64 i = a.couples[2 * couple], j = a.couples[2 * couple + 1];
        a.keys[entry] = is_larger ? j << a.bits | i : i << a.bits | j;
        a.ids[entry] = 0;
    }
}

struct ListStarts {
    // Sorted.
    const u64 *keys;
    u64 *starts;
    u64 entries;
    // Rows, and one for the end of the last.
    u64 count;
    u32 bits;
    u32 unused;
};

// Where each row begins: the number of entries of the rows before.
KERNEL(list_starts, ListStarts) {
    EACH(row, a.count) {
        u64 low = 0, high = a.entries;
        while (low < high) {
            const u64 middle = low + (high - low) / 2;
            if (a.keys[middle] >> a.bits < row) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        a.starts[row] = low;
    }
}

struct ListEntries {
    const u64 *keys;
    const void *points;
    u32 *neighbours;
    void *distances;
    u64 count;
    u32 bits;
    u32 dimensions;
    u32 single;
    u32 unused;
};

// The root of the sum of `Elements::distance_squared`.
template <typename T> INLINE T distance(const T *x, const T *y, u32 dimensions) {
    T sum = 0;
    for (u32 axis = 0; axis < dimensions; ++axis) {
        const T difference = x[axis] - y[axis];
        sum = sum + difference * difference;
    }
    return square_root(sum);
}

// The neighbour of each entry and its distance.
KERNEL(list_entries, ListEntries) {
    EACH(entry, a.count) {
        const u64 key = a.keys[entry], j = key & ((1ull << a.bits) - 1);
        const u64 x = (key >> a.bits) * a.dimensions, y = j * a.dimensions;
        a.neighbours[entry] = (u32)j;
        if (a.single) {
            const f32 *points = (const f32 *)a.points;
            ((f32 *)a.distances)[entry] = distance(points + x, points + y, a.dimensions);
        } else {
            const double *points = (const double *)a.points;
            ((double *)a.distances)[entry] = distance(points + x, points + y, a.dimensions);
        }
    }
}
