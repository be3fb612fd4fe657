// One pass of a stable sort by the digits of keys, from the lowest on.
#pragma once
#include "scan.h"

const u32 DIGIT_BITS = 4;
const u32 DIGITS = 1u << DIGIT_BITS;
// Keys that a thread moves.
const u32 SORTED = 8;

struct Sort {
    const u64 *keys;
    const u32 *ids;
    u64 *sorted_keys;
    u32 *sorted_ids;
    // For each digit and each block how many keys of the block have it.
    u32 *counts;
    // The sum of all counts before.
    const u64 *before;
    u64 count;
    u32 blocks;
    u32 shift;
};

INLINE u32 digit_of(u64 key, u32 shift) { return (u32)(key >> shift) & (DIGITS - 1); }

// Counts the digits of each thread, by digit, then by thread.
INLINE void count_digits(const Sort &a, u32 block, u32 *counts) {
    EACH_THREAD(t) {
        for (u32 digit = 0; digit < DIGITS; ++digit) counts[digit * THREADS + t] = 0;
        const u64 begin = ((u64)block * THREADS + t) * SORTED;
        for (u64 k = begin; k < begin + SORTED && k < a.count; ++k) {
            counts[digit_of(a.keys[k], a.shift) * THREADS + t] += 1;
        }
    }
}

KERNEL(sort_count, Sort) {
    SHARED u32 counts[DIGITS * THREADS];
    count_digits(a, block, counts);
    EACH_THREAD(t) {
        if (t < DIGITS) {
            u32 sum = 0;
            for (u32 k = 0; k < THREADS; ++k) sum += counts[t * THREADS + k];
            a.counts[(u64)t * a.blocks + block] = sum;
        }
    }
}

KERNEL(sort_move, Sort) {
    SHARED u32 counts[DIGITS * THREADS];
    SHARED u64 sums[2 * THREADS];
    SHARED u32 starts[DIGITS];
    count_digits(a, block, counts);
    // Each thread adds up DIGITS counts that follow each other.
    EACH_THREAD(t) {
        u64 sum = 0;
        for (u32 k = 0; k < DIGITS; ++k) sum += counts[t * DIGITS + k];
        sums[t] = sum;
    }
    scan_block(sums);
    EACH_THREAD(t) {
        u32 sum = (u32)(t > 0 ? sums[t - 1] : 0);
        for (u32 k = 0; k < DIGITS; ++k) {
            const u32 count = counts[t * DIGITS + k];
            counts[t * DIGITS + k] = sum;
            sum += count;
        }
    }
    EACH_THREAD(t) {
        if (t < DIGITS) starts[t] = counts[t * THREADS];
    }
    EACH_THREAD(t) {
        const u64 begin = ((u64)block * THREADS + t) * SORTED;
        for (u64 k = begin; k < begin + SORTED && k < a.count; ++k) {
            const u32 digit = digit_of(a.keys[k], a.shift);
            const u32 place = counts[digit * THREADS + t]++ - starts[digit];
            const u64 to = a.before[(u64)digit * a.blocks + block] + place;
            a.sorted_keys[to] = a.keys[k];
            a.sorted_ids[to] = a.ids[k];
        }
    }
}
