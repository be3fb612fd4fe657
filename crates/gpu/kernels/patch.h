// Some rows of arrays: rows that the host reads, rows that it changes, and all rows of an array that grows.
#pragma once
#include "platform.h"

// Columns of numbers of some words each. A row has a number in each column; columns begin `stride` numbers
// after each other.
struct MovedRows {
    const u32 *from;
    u32 *to;
    // The numbers of the rows in both arrays; those of an empty list are 0, 1, ...
    const u32 *from_rows;
    const u32 *to_rows;
    u64 from_stride;
    u64 to_stride;
    u64 rows;
    u64 columns;
    u64 words;
};

KERNEL(move_rows, MovedRows) {
    EACH(k, a.rows * a.columns * a.words) {
        const u64 word = k % a.words, row = k / a.words % a.rows, column = k / a.words / a.rows;
        const u64 from = column * a.from_stride + (a.from_rows ? a.from_rows[row] : row);
        const u64 to = column * a.to_stride + (a.to_rows ? a.to_rows[row] : row);
        a.to[to * a.words + word] = a.from[from * a.words + word];
    }
}

struct Marked {
    // 1 for the places that are listed, else 0, and the sum of the marks before each.
    const u32 *marks;
    const u64 *before;
    u32 *list;
    u64 count;
};

KERNEL(list_marked, Marked) {
    EACH(k, a.count) {
        if (a.marks[k]) a.list[a.before[k]] = (u32)k;
    }
}
