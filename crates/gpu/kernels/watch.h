// Elements whose state has changed so much that their facets may fail. Twin of `solid/watch.rs`.
#pragma once
#include "laws.h"

struct Watched {
    // Of each element the stress that was noted, its upper half row by row, and then the edges; empty if
    // nothing is watched.
    const f32 *noted;
    // Of each element the square of the change of its edges up to which its shape counts as the noted one,
    // and the change of its stress up to which it sleeps.
    const double *limits;
    // Of each element the square of the present change of its stress, and whether it is awake.
    double *moved;
    u32 *awake;
    // Set if any is.
    u32 *any_awake;
};

template <int D> INLINE double square_of_difference(const Matrix<D> &one, const Matrix<D> &other) {
    Matrix<D> difference;
    for (int k = 0; k < D * D; ++k) difference.a[k / D][k % D] = one.a[k / D][k % D] - other.a[k / D][k % D];
    return contraction(difference, difference);
}

// An element that is never awake.
INLINE void rest(const Watched &a, u64 element) {
    a.moved[element] = 0.0;
    a.awake[element] = 0;
}

// Compares the present state of an element with the noted one: `all_moved`.
template <int D>
INLINE void find_moved(const Watched &a, u64 element, const Matrix<D> &edges, const Matrix<D> &stress) {
    const f32 *noted = a.noted + element * (D * (D + 1) / 2 + D * D);
    Matrix<D> present, before, shape;
    for (int i = 0; i < D; ++i) {
        for (int k = i; k < D; ++k) {
            present.a[i][k] = present.a[k][i] = stress.a[i][k];
            before.a[i][k] = before.a[k][i] = (double)*noted++;
        }
    }
    for (int k = 0; k < D * D; ++k) shape.a[k / D][k % D] = (double)*noted++;
    const double moved = square_of_difference(present, before);
    const bool is_near = square_of_difference(edges, shape) < a.limits[2 * element];
    const double allowed = is_near ? moved : of_bits(0x7ff0000000000000ull);
    const double reach = a.limits[2 * element + 1];
    const bool is_awake = !(allowed < reach * reach);
    a.moved[element] = allowed;
    a.awake[element] = is_awake;
    if (is_awake) set_flag(a.any_awake);
}
