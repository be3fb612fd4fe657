// Sums of all numbers before each.
#pragma once
#include "platform.h"

// Numbers that a thread adds up.
const u32 SCANNED = 16;

struct Scan {
    const u32 *numbers;
    // Sum of the numbers of each block; `scan_sums` turns it into the sum of those before the block, and
    // appends the sum of all.
    u64 *sums;
    // For each number the sum of those before it.
    u64 *before;
    u64 count;
    u64 blocks;
};

// Turns a number of each thread into the sum of it and those before it. `numbers` has two of each thread,
// the first ones are the numbers.
INLINE void scan_block(u64 *numbers) {
    u64 *from = numbers, *to = numbers + THREADS;
    for (u32 step = 1; step < THREADS; step *= 2) {
        EACH_THREAD(t) {
            to[t] = from[t] + (t >= step ? from[t - step] : 0);
        }
        u64 *other = from;
        from = to;
        to = other;
    }
    // The number of steps is even, so the result is in the first half again.
}

// The first number of a thread.
INLINE u64 begin_of(u32 block, u32 t) { return ((u64)block * THREADS + t) * SCANNED; }

// Adds up the numbers of each thread and those of the threads before it.
INLINE void scan_threads(const Scan &a, u32 block, u64 *sums) {
    EACH_THREAD(t) {
        u64 sum = 0;
        const u64 begin = begin_of(block, t);
        for (u64 k = begin; k < begin + SCANNED && k < a.count; ++k) sum += a.numbers[k];
        sums[t] = sum;
    }
    scan_block(sums);
}

KERNEL(scan_blocks, Scan) {
    SHARED u64 numbers[2 * THREADS];
    scan_threads(a, block, numbers);
    EACH_THREAD(t) {
        if (t == 0) a.sums[block] = numbers[THREADS - 1];
    }
}

// One block.
KERNEL(scan_sums, Scan) {
    SHARED u64 numbers[2 * THREADS];
    SHARED u64 before;
    EACH_THREAD(t) {
        if (t == 0) before = 0;
    }
    for (u64 first = 0; first < a.blocks; first += THREADS) {
        EACH_THREAD(t) {
            numbers[t] = first + t < a.blocks ? a.sums[first + t] : 0;
        }
        scan_block(numbers);
        EACH_THREAD(t) {
            if (first + t < a.blocks) a.sums[first + t] = before + (t > 0 ? numbers[t - 1] : 0);
        }
        EACH_THREAD(t) {
            if (t == 0) before += numbers[THREADS - 1];
        }
    }
    EACH_THREAD(t) {
        if (t == 0) a.sums[a.blocks] = before;
    }
}

KERNEL(scan, Scan) {
    SHARED u64 numbers[2 * THREADS];
    scan_threads(a, block, numbers);
    EACH_THREAD(t) {
        u64 sum = a.sums[block] + (t > 0 ? numbers[t - 1] : 0);
        const u64 begin = begin_of(block, t);
        for (u64 k = begin; k < begin + SCANNED && k < a.count; ++k) {
            a.before[k] = sum;
            sum += a.numbers[k];
        }
    }
}
