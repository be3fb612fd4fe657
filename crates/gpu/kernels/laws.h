// The laws of elements: functions of a few numbers. Each is the twin of a function in Rust, whose name it has
// and whose operations it does in the same order, so that both give the same bits:
//
// - vectors and tensors: `crates/simulation/src/vector.rs`
// - `stress`: `simplex/triangle/elastic.rs` and `simplex/tetrahedron/elastic.rs`
// - `stress_of_rest`, `add_bedding`: `laws/transversely_isotropic.rs`, `Stiffness::stress` and `with_bedding`
// - `viscous_stress`: `solid/viscous.rs`
// - `deform`, `forces_of`: `solid/batch.rs`, `strain_one`
//
// `crates/gpu/tests/laws.rs` compares them.
#pragma once
#include "platform.h"

template <int D> struct Matrix {
    double a[D][D];
};

template <int D> INLINE double dot(const double *a, const double *b) {
    double sum = a[0] * b[0];
    for (int axis = 1; axis < D; ++axis) sum += a[axis] * b[axis];
    return sum;
}

template <int D> INLINE Matrix<D> transposed(const Matrix<D> &a) {
    Matrix<D> b;
    for (int i = 0; i < D; ++i)
        for (int k = 0; k < D; ++k) b.a[i][k] = a.a[k][i];
    return b;
}

template <int D> INLINE Matrix<D> product_transposed(const Matrix<D> &a, const Matrix<D> &b) {
    Matrix<D> c;
    for (int i = 0; i < D; ++i)
        for (int k = 0; k < D; ++k) c.a[i][k] = dot<D>(a.a[i], b.a[k]);
    return c;
}

template <int D> INLINE Matrix<D> product(const Matrix<D> &a, const Matrix<D> &b) {
    return product_transposed(a, transposed(b));
}

template <int D> INLINE Matrix<D> symmetric(const Matrix<D> &a) {
    Matrix<D> b;
    for (int i = 0; i < D; ++i)
        for (int k = 0; k < D; ++k) {
            const int low = i < k ? i : k, high = i < k ? k : i;
            b.a[i][k] = i == k ? a.a[i][i] : 0.5 * (a.a[low][high] + a.a[high][low]);
        }
    return b;
}

template <int D> INLINE double contraction(const Matrix<D> &a, const Matrix<D> &b) {
    double sum = a.a[0][0] * b.a[0][0];
    for (int k = 1; k < D * D; ++k) sum = sum + a.a[k / D][k % D] * b.a[k / D][k % D];
    return sum;
}

INLINE void cross3(const double *a, const double *b, double *c) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

template <int D> INLINE void applied(const Matrix<D> &a, const double *v, double *to) {
    for (int i = 0; i < D; ++i) to[i] = dot<D>(a.a[i], v);
}

INLINE double determinant(const Matrix<2> &f) { return f.a[0][0] * f.a[1][1] - f.a[0][1] * f.a[1][0]; }

INLINE double determinant(const Matrix<3> &f) {
    double normal[3];
    cross3(f.a[1], f.a[2], normal);
    return dot<3>(f.a[0], normal);
}

INLINE Matrix<2> cofactor(const Matrix<2> &f) {
    return {{{f.a[1][1], -f.a[1][0]}, {-f.a[0][1], f.a[0][0]}}};
}

INLINE Matrix<3> cofactor(const Matrix<3> &f) {
    Matrix<3> c;
    cross3(f.a[1], f.a[2], c.a[0]);
    cross3(f.a[2], f.a[0], c.a[1]);
    cross3(f.a[0], f.a[1], c.a[2]);
    return c;
}

// A whole number of three words, the lowest first.
struct Words {
    u64 w[3];
};

// The cube of a number below 2^54.
INLINE Words cube(u64 x) {
    const u64 low = x * x, high = high_product(x, x);
    const u64 carried = high_product(low, x);
    const u64 middle = high * x + carried;
    // `high` is below 2^44.
    return {{low * x, middle, high_product(high, x) + (middle < carried)}};
}

INLINE bool is_less(const Words &a, const Words &b) {
    for (int k = 2; k > 0; --k)
        if (a.w[k] != b.w[k]) return a.w[k] < b.w[k];
    return a.w[0] < b.w[0];
}

// The cube root of a normal positive number, rounded to nearest: that of `libm`, which rounds it correctly.
INLINE double cube_root_of_any(double x) {
    const i64 field = (i64)(bits_of(x) >> 52);
    // Divided by a power of 8, x is from 1 to 8, and its root from 1 to 2.
    const i64 thirds = field / 3 - 341;
    const u64 digits = bits_of(x) & ((1ull << 52) - 1);
    const u32 rest = (u32)(field - 3 * (thirds + 341));
    const double scaled = of_bits(digits | (u64)(1023 + rest) << 52);
    // By Newton's method, to some units in the last place.
    double root = 1.0 + (scaled - 1.0) * (1.0 / 7.0);
    for (int k = 0; k < 6; ++k) root = root - (root * root * root - scaled) / (3.0 * (root * root));
    // In units of 2^-52: the root is between those halfway to its neighbours, whose cubes are compared as
    // whole numbers. They cannot be equal, because a cube of an odd number is odd.
    u64 number = (bits_of(root) & ((1ull << 52) - 1)) | 1ull << 52;
    // scaled * 2^159 = digits * 2^(107 + rest).
    const u64 whole = digits | 1ull << 52;
    const u32 shift = 107 + rest - 64;
    const Words target = {{0, whole << shift, whole >> (64 - shift)}};
    while (is_less(cube(2 * number + 1), target)) ++number;
    while (is_less(target, cube(2 * number - 1))) --number;
    const u64 power = (u64)(thirds + 1023) << 52;
    // The root is below 2, but it may round to it.
    return of_bits(number >> 53 ? power + (1ull << 52) : power | (number & ((1ull << 52) - 1)));
}

const double SMALL = 1e-3;

INLINE double cube_root_of_small(double z) {
    double series = 22.0 / 729.0 * z - 10.0 / 243.0;
    series = (series * z + 5.0 / 81.0) * z - 1.0 / 9.0;
    return 1.0 + z * (1.0 / 3.0 + z * series);
}

INLINE double cube_root(double z) {
    const double size = z < 0.0 ? -z : z;
    return size >= SMALL ? cube_root_of_any(1.0 + z) : cube_root_of_small(z);
}

INLINE Matrix<2> stress(double shear, double bulk, const Matrix<2> &f, double j, double *energy) {
    const double a = f.a[0][0], b = f.a[0][1], c = f.a[1][0], d = f.a[1][1];
    const double difference = a - d, sum = b + c;
    const double inverse = 1.0 / j;
    const double shape = (difference * difference + sum * sum) * inverse;
    const double volume = j - 1.0;
    const double g = shear * inverse;
    const double k = bulk * volume - 0.5 * g * shape;
    *energy = 0.5 * (shear * shape + bulk * volume * volume);
    return {{{g * difference + k * d, g * sum + k * -c}, {g * sum + k * -b, g * -difference + k * a}}};
}

INLINE double strain(const Matrix<3> &f, int i, int k) {
    const double sum = f.a[0][i] * f.a[0][k] + f.a[1][i] * f.a[1][k] + f.a[2][i] * f.a[2][k];
    return 0.5 * (i == k ? sum - 1.0 : sum);
}

INLINE double deviation(double xx, double yy, double zz, double xy, double yz, double xz) {
    const double one = xx - yy, two = yy - zz, three = zz - xx;
    return 0.5 * (one * one + two * two + three * three) + 3.0 * (xy * xy + yz * yz + xz * xz);
}

INLINE Matrix<3> stress(double shear, double bulk, const Matrix<3> &f, double j, double *energy) {
    const double xx = strain(f, 0, 0), yy = strain(f, 1, 1), zz = strain(f, 2, 2);
    const double xy = strain(f, 0, 1), yz = strain(f, 1, 2), xz = strain(f, 0, 2);
    const double u = 2.0 / 3.0 * (xx + yy + zz);
    const double determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    const double inverse = 1.0 / j;
    const double z =
        (4.0 / 3.0 * deviation(xx, yy, zz, xy, yz, xz) + u * u * u - 8.0 * determinant) * (inverse * inverse);
    const double c = cube_root(z);
    const double third = 1.0 + u, sum = c * c + c + 1.0;
    const double both = 1.0 / (third * sum);
    const double shape = z * (third * both);
    const double volume = j - 1.0;
    const double g = shear * c * (sum * both);
    const double k = bulk * volume - g * third * inverse;
    const Matrix<3> across = cofactor(f);
    Matrix<3> stress;
    for (int i = 0; i < 3; ++i)
        for (int l = 0; l < 3; ++l) stress.a[i][l] = g * f.a[i][l] + k * across.a[i][l];
    *energy = 1.5 * shear * shape + 0.5 * bulk * volume * volume;
    return stress;
}

template <int D>
INLINE Matrix<D> viscous_stress(double viscosity, const Matrix<D> &f, double j, const Matrix<D> &rate) {
    const Matrix<D> across = cofactor(f);
    const double over = 1.0 / j;
    Matrix<D> inverse;
    for (int i = 0; i < D; ++i)
        for (int k = 0; k < D; ++k) inverse.a[i][k] = across.a[k][i] * over;
    Matrix<D> stretching = symmetric(product(rate, inverse));
    for (int i = 0; i < D; ++i)
        for (int k = 0; k < D; ++k) stretching.a[i][k] = 2.0 * viscosity * stretching.a[i][k];
    return product(stretching, across);
}

// The bedding of a material: the stiffness that its neo-Hookean part lacks, and the normal in the undeformed body;
// `FlatBedding` of fdem-simulation.
template <int D> struct Bedding {
    double lame, shear, coupling, excess, along;
    double normal[D];
};

// The stress of a strain with this stiffness, and its energy.
template <int D> INLINE Matrix<D> stress_of_rest(const Bedding<D> &of, const Matrix<D> &strain, double *energy) {
    double across[D];
    applied(strain, of.normal, across);
    double sum = strain.a[0][0];
    const double stretch = dot<D>(of.normal, across);
    for (int axis = 1; axis < D; ++axis) sum += strain.a[axis][axis];
    const double mean = of.lame * sum + of.coupling * stretch, own = of.coupling * sum + of.along * stretch;
    Matrix<D> stress;
    for (int i = 0; i < D; ++i)
        for (int k = 0; k < D; ++k) {
            const double both = of.normal[i] * across[k] + across[i] * of.normal[k];
            const double part =
                2.0 * of.shear * strain.a[i][k] + of.excess * both + own * (of.normal[i] * of.normal[k]);
            stress.a[i][k] = i == k ? part + mean : part;
        }
    *energy = 0.5 * contraction(stress, strain);
    return stress;
}

// Adds the part of the bedding to the stress and the energy of the isotropic part, and finds the present normal.
template <int D>
INLINE void add_bedding(const Bedding<D> &of, const Matrix<D> &f, Matrix<D> &stress, double *energy, double *normal) {
    const Matrix<D> turned = transposed(f);
    const Matrix<D> squared = product_transposed(turned, turned);
    Matrix<D> strain;
    for (int i = 0; i < D; ++i)
        for (int k = 0; k < D; ++k) strain.a[i][k] = 0.5 * (i == k ? squared.a[i][k] - 1.0 : squared.a[i][k]);
    double more;
    const Matrix<D> first = product(f, stress_of_rest(of, strain, &more));
    double now[D];
    applied(cofactor(f), of.normal, now);
    const double over = 1.0 / square_root(dot<D>(now, now));
    for (int axis = 0; axis < D; ++axis) normal[axis] = over * now[axis];
    for (int i = 0; i < D; ++i)
        for (int k = 0; k < D; ++k) stress.a[i][k] = stress.a[i][k] + first.a[i][k];
    *energy = *energy + more;
}

// An element in a step; `ElementState` of fdem-simulation.
template <int D> struct ElementState {
    Matrix<D> gradients, edges, rates, initial, viscous;
    double volume, viscosity, stored, shear, bulk;
    Bedding<D> bedding;
};

// Its results; `ElementForces` of fdem-simulation.
template <int D> struct ElementForces {
    double forces[D + 1][D];
    Matrix<D> stress, viscous;
    double energy, ratio, power;
    double normal[D];
};

// Parts of the law that an element may have besides the neo-Hookean one.
struct LawParts {
    bool initial, viscous, bedded;
};

template <int D>
INLINE void forces_of(const Matrix<D> &stress, const Matrix<D> &gradients, double volume, double forces[D + 1][D]) {
    const Matrix<D> on = product_transposed(stress, gradients);
    for (int axis = 0; axis < D; ++axis) {
        const double first = -volume * on.a[axis][0];
        forces[0][axis] = -first;
        forces[1][axis] = first;
        for (int k = 1; k < D; ++k) {
            const double force = -volume * on.a[axis][k];
            forces[0][axis] -= force;
            forces[k + 1][axis] = force;
        }
    }
}

// Deforms an element with the neo-Hookean law, with bedding, initial stress and viscosity if it has them.
template <int D> INLINE void deform(const ElementState<D> &of, LawParts parts, ElementForces<D> &to) {
    const Matrix<D> gradient = product(of.edges, of.gradients);
    const double j = determinant(gradient);
    double energy;
    Matrix<D> all = stress(of.shear, of.bulk, gradient, j, &energy);
    if (parts.bedded) add_bedding(of.bedding, gradient, all, &energy, to.normal);
    if (parts.initial) {
        const Matrix<D> first = product(gradient, of.initial);
        for (int i = 0; i < D; ++i)
            for (int k = 0; k < D; ++k) all.a[i][k] = all.a[i][k] + first.a[i][k];
        const Matrix<D> across = transposed(gradient);
        Matrix<D> strain = product_transposed(across, across);
        for (int axis = 0; axis < D; ++axis) strain.a[axis][axis] -= 1.0;
        energy += of.stored + 0.5 * contraction(of.initial, strain);
    }
    if (parts.viscous) {
        const Matrix<D> rate = product(of.rates, of.gradients);
        to.viscous = viscous_stress(of.viscosity, gradient, j, rate);
        to.power = contraction(of.viscous, rate) + contraction(to.viscous, rate);
        for (int i = 0; i < D; ++i)
            for (int k = 0; k < D; ++k) all.a[i][k] = all.a[i][k] + to.viscous.a[i][k];
    }
    to.ratio = j;
    to.energy = energy * of.volume;
    const Matrix<D> cauchy = symmetric(product_transposed(all, gradient));
    const double over = 1.0 / j;
    for (int i = 0; i < D; ++i)
        for (int k = 0; k < D; ++k) to.stress.a[i][k] = cauchy.a[i][k] * over;
    forces_of(all, of.gradients, of.volume, to.forces);
}

struct Deform {
    // An ElementState and an ElementForces of each element.
    const void *states;
    void *forces;
    u64 count;
    u32 has_initial;
    u32 is_viscous;
    u32 is_bedded;
    u32 unused;
};

template <int D> INLINE void deform_block(const Deform &a, u32 block) {
    EACH(element, a.count) {
        const LawParts parts = {a.has_initial != 0, a.is_viscous != 0, a.is_bedded != 0};
        deform(((const ElementState<D> *)a.states)[element], parts, ((ElementForces<D> *)a.forces)[element]);
    }
}

KERNEL(deform_triangles, Deform) { deform_block<2>(a, block); }
KERNEL(deform_tetrahedra, Deform) { deform_block<3>(a, block); }
