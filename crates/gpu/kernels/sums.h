// Sums that are exact in any order, and largest numbers.
#pragma once
#include "platform.h"

// Parts of a sum: part k counts 2^(32 k - 1074), the last one numbers that are infinite or none.
const u32 PARTS = 68;

struct ExactSums {
    // Rows of numbers, one after the other.
    const double *numbers;
    // PARTS of each of `pieces` blocks of each row.
    i64 *parts;
    // Numbers of a row.
    u64 count;
    u32 pieces;
    u32 unused;
};

// What a number adds to a part of a sum. Twin of `Sum::add` in `sum.rs`.
INLINE i64 part_of(double number, u32 part) {
    const u64 bits = bits_of(number);
    const u32 exponent = (u32)(bits >> 52) & 0x7ff;
    if (exponent == 0x7ff) return part == PARTS - 1;
    const u64 fraction = bits & ((1ull << 52) - 1);
    const u32 place = exponent ? exponent - 1 : 0;
    const u32 word = part - place / 32;
    if (part == PARTS - 1 || word > 2) return 0;
    // The word of the fraction, times 2^(place % 32), of 32 bits each.
    const u64 whole = exponent ? fraction | 1ull << 52 : fraction;
    const u32 shift = place % 32;
    const u64 low = whole << shift, high = shift ? whole >> (64 - shift) : 0;
    const i64 size = (i64)(word == 0 ? low & 0xffffffffu : word == 1 ? low >> 32 : high & 0xffffffffu);
    return bits >> 63 ? -size : size;
}

// A block adds up every `pieces`-th tile of a row; each thread has a part of the sum.
KERNEL(exact_sums, ExactSums) {
    SHARED double tile[THREADS];
    SHARED i64 sums[PARTS];
    const double *row = a.numbers + (u64)(block / a.pieces) * a.count;
    const u64 stride = (u64)a.pieces * THREADS;
    EACH_THREAD(t) {
        if (t < PARTS) sums[t] = 0;
    }
    for (u64 first = (u64)(block % a.pieces) * THREADS; first < a.count; first += stride) {
        EACH_THREAD(t) {
            tile[t] = first + t < a.count ? row[first + t] : 0.0;
        }
        EACH_THREAD(t) {
            if (t < PARTS) {
                for (u32 k = 0; k < THREADS; ++k) sums[t] += part_of(tile[k], t);
            }
        }
    }
    EACH_THREAD(t) {
        if (t < PARTS) a.parts[(u64)block * PARTS + t] = sums[t];
    }
}

struct LargestNumbers {
    // Rows of numbers from 0, one after the other.
    const double *numbers;
    double *largest;
    u64 count;
};

// The largest number of each row, each in one block.
KERNEL(largest_numbers, LargestNumbers) {
    SHARED double most[THREADS];
    EACH_THREAD(t) {
        most[t] = 0.0;
        for (u64 k = t; k < a.count; k += THREADS) {
            const double number = a.numbers[(u64)block * a.count + k];
            if (number > most[t]) most[t] = number;
        }
    }
    for (u32 half = THREADS / 2; half > 0; half /= 2) {
        EACH_THREAD(t) {
            if (t < half && most[t + half] > most[t]) most[t] = most[t + half];
        }
    }
    EACH_THREAD(t) {
        if (t == 0) a.largest[block] = most[0];
    }
}
