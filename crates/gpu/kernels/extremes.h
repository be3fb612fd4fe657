// The extremes of elements that are on the device, and the first number that is refused.
#pragma once
#include "rows.h"

// Numbers do not depend on the order in which they are joined: zeros have no sign, and NaN is no extreme.
struct Extremes {
    double min[3];
    double max[3];
    double smallest_radius;
    double largest_radius;
    // Place of the first coordinate and of the first radius that are refused, or the largest number.
    u64 wrong_number;
    u64 wrong_radius;
};

struct ExtremesOf {
    const void *points;
    // Null for one radius.
    const void *radii;
    // Of each block, then of all.
    Extremes *extremes;
    u64 count;
    u64 blocks;
    // Largest magnitude of a number.
    double limit;
    u32 dimensions;
    u32 single;
};

const double ENDLESS = 1.7976931348623157e308;

INLINE Extremes nothing() {
    Extremes none;
    for (int axis = 0; axis < 3; ++axis) {
        none.min[axis] = ENDLESS;
        none.max[axis] = -ENDLESS;
    }
    none.smallest_radius = ENDLESS;
    none.largest_radius = -ENDLESS;
    none.wrong_number = none.wrong_radius = ~0ull;
    return none;
}

INLINE void join(Extremes *a, const Extremes &b) {
    for (int axis = 0; axis < 3; ++axis) {
        if (b.min[axis] < a->min[axis]) a->min[axis] = b.min[axis];
        if (b.max[axis] > a->max[axis]) a->max[axis] = b.max[axis];
    }
    if (b.smallest_radius < a->smallest_radius) a->smallest_radius = b.smallest_radius;
    if (b.largest_radius > a->largest_radius) a->largest_radius = b.largest_radius;
    if (b.wrong_number < a->wrong_number) a->wrong_number = b.wrong_number;
    if (b.wrong_radius < a->wrong_radius) a->wrong_radius = b.wrong_radius;
}

// Joins those of all threads of a block into the first.
INLINE void join_threads(Extremes *extremes) {
    for (u32 step = THREADS / 2; step > 0; step /= 2) {
        EACH_THREAD(t) {
            if (t < step) join(&extremes[t], extremes[t + step]);
        }
    }
}

INLINE Extremes of_element(const ExtremesOf &a, u64 element) {
    Extremes one = nothing();
    for (u32 axis = 0; axis < a.dimensions; ++axis) {
        const u64 place = element * a.dimensions + axis;
        const double x = number_at(a.points, a.single, place) + 0.0;
        // The condition is negated so that NaN counts too.
        if (!(x <= a.limit && x >= -a.limit) && place < one.wrong_number) one.wrong_number = place;
        if (x < one.min[axis]) one.min[axis] = x;
        if (x > one.max[axis]) one.max[axis] = x;
    }
    if (a.radii) {
        const double radius = number_at(a.radii, a.single, element) + 0.0;
        if (!(radius >= 0.0 && radius <= a.limit)) one.wrong_radius = element;
        if (radius < one.smallest_radius) one.smallest_radius = radius;
        if (radius > one.largest_radius) one.largest_radius = radius;
    }
    return one;
}

KERNEL(extremes_of_blocks, ExtremesOf) {
    SHARED Extremes extremes[THREADS];
    EACH_THREAD(t) {
        Extremes of_thread = nothing();
        for (u32 k = 0; k < SCANNED; ++k) {
            const u64 element = ((u64)block * SCANNED + k) * THREADS + t;
            if (element < a.count) join(&of_thread, of_element(a, element));
        }
        extremes[t] = of_thread;
    }
    join_threads(extremes);
    EACH_THREAD(t) {
        if (t == 0) a.extremes[block] = extremes[0];
    }
}

// One block.
KERNEL(extremes_of_all, ExtremesOf) {
    SHARED Extremes extremes[THREADS];
    EACH_THREAD(t) {
        Extremes of_thread = nothing();
        for (u64 other = t; other < a.blocks; other += THREADS) join(&of_thread, a.extremes[other]);
        extremes[t] = of_thread;
    }
    join_threads(extremes);
    EACH_THREAD(t) {
        if (t == 0) a.extremes[a.blocks] = extremes[0];
    }
}

struct Sample {
    const void *points;
    void *sample;
    // Points of the sample, and how many elements it takes one of.
    u64 count;
    u64 step;
    u32 dimensions;
    u32 single;
};

KERNEL(sample_points, Sample) {
    EACH(number, a.count * a.dimensions) {
        const u64 point = number / a.dimensions * a.step;
        copy_number(a.sample, number, a.points, point * a.dimensions + number % a.dimensions, a.single);
    }
}
