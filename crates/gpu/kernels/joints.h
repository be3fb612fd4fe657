// Joints between elements: their law, and the phase of a step that computes them. The functions are twins of
// those in Rust, whose names they have and whose operations they do in the same order:
//
// - `exp_down`, `softening`: `crates/simulation/src/cohesive/curve.rs`
// - `least` to `energy_towards`: `cohesive/law.rs`
// - functions of a `Memory`: `cohesive/memory.rs`
// - `unit_axes`: `simplex/triangle.rs` and `simplex/tetrahedron.rs`
// - `pull_joint`: `joints/batch.rs`
#pragma once
#include "laws.h"

// As in `lanes.rs`: no number is neither smaller nor larger.
INLINE double smaller(double a, double b) { return a < b ? a : b; }
INLINE double larger(double a, double b) { return a > b ? a : b; }

template <int D> INLINE double length(const double *a) { return square_root(dot<D>(a, a)); }

// exp(x) for x from -3.8 to 0, with the bits of `libm::exp`: see the twin.
INLINE double exp_down(double x) {
    const double high_part = 6.931471803691238e-1, low_part = 1.9082149292705877e-10;
    double k = 0.0, power = 1.0;
    const double turns = 1.4426950408889634 * x - 0.5;
    for (int n = 1; n < 6; ++n) {
        const bool passed = n == 1 ? x <= -of_bits(0x3fd62e4300000000ull) : turns <= -(double)n;
        k -= passed ? 1.0 : 0.0;
        power *= passed ? 0.5 : 1.0;
    }
    const double high = x - k * high_part, low = k * low_part;
    const double r = high - low;
    const double square = r * r;
    const double series =
        6.6137563214379340e-5 + square * (-1.6533902205465252e-6 + square * 4.1381367970572385e-8);
    const double c = r - square * (1.6666666666666602e-1 + square * (-2.7777777777015593e-3 + square * series));
    const double value = 1.0 + (r * c / (2.0 - c) - low + high);
    return power * (x > -of_bits(0x3e30000100000000ull) ? 1.0 + x : value);
}

INLINE double softening(double d) {
    const double a = 0.63, b = 1.8;
    const double rest = 1.0 - d;
    const double rate = (a + 6.0 * b) / ((a + b) * (1.0 - a - b));
    const double factor = 1.0 - (a + b - 1.0) / (a + b) * exp_down(d * rate);
    const double sixth = (rest * rest * rest) * (rest * rest * rest);
    double left = factor * (a * rest + b * sixth);
    left = rest <= 0.0 ? 0.0 : left;
    return d == 0.0 ? 1.0 : left;
}

// A joint whose law is common: `JointLaw` with one stiffness.
template <int D> struct JointLaw {
    double normal[D];
    double penalty, tensile, cohesion, friction;
    double critical[2];
};

// The history of an end of a joint.
template <int D> struct Memory {
    double damages[2];
    double stiffness;
    double origin[D];
    double rubbed[D];
};

template <int D> INLINE double least_pressed(const JointLaw<D> &law) {
    const bool opens = law.normal[0] != 1.0 && law.tensile < law.cohesion;
    return opens ? law.tensile : law.cohesion;
}

template <int D> INLINE double least(const JointLaw<D> &law, double friction) {
    const double lower = law.tensile < law.cohesion ? law.tensile : law.cohesion;
    return friction > 0.0 ? least_pressed(law) + friction : lower;
}

// Traction of a whole joint, and whether it stays whole.
template <int D> INLINE bool of_whole(const JointLaw<D> &law, const double *gap, const double *origin, double *traction) {
    double bond[D];
    for (int axis = 0; axis < D; ++axis) bond[axis] = gap[axis] - origin[axis];
    const double opening = bond[0];
    const double pressure = law.penalty * (opening < 0.0 ? -opening : 0.0);
    bond[0] = opening > 0.0 ? opening : 0.0;
    const double most = least(law, law.friction * pressure);
    const bool holds = law.penalty * law.penalty * dot<D>(bond, bond) <= most * most;
    for (int axis = 0; axis < D; ++axis) traction[axis] = law.penalty * bond[axis];
    traction[0] = pressure == 0.0 ? traction[0] : -pressure;
    return holds;
}

template <int D> INLINE void shares(const JointLaw<D> &law, const double *bond, double squared, double *squares) {
    const double across = dot<D>(bond, law.normal);
    double aside[D];
    for (int axis = 0; axis < D; ++axis) aside[axis] = bond[axis] - across * law.normal[axis];
    squares[0] = across * across / squared;
    squares[1] = dot<D>(aside, aside) / squared;
}

template <int D> INLINE double energy_towards(const JointLaw<D> &law, const double *squares) {
    const double fourth = squares[1] * squares[1];
    return law.tensile * law.critical[0] * square_root(squares[0]) + law.cohesion * law.critical[1] * (fourth * fourth);
}

// Strength, and critical length.
template <int D> INLINE void in_direction(const JointLaw<D> &law, const double *squares, double *found) {
    const double cosine = squares[0], sine = squares[1], tensile = law.tensile, cohesion = law.cohesion;
    const double strength =
        tensile * cohesion / square_root(cosine * cohesion * cohesion + sine * tensile * tensile);
    const double energy = energy_towards(law, squares);
    found[0] = sine == 0.0 ? tensile : cosine == 0.0 ? cohesion : strength;
    found[1] = sine == 0.0 ? law.critical[0] : cosine == 0.0 ? law.critical[1] : energy / strength;
}

template <int D> INLINE double damage_of(const Memory<D> &memory) {
    return memory.stiffness == 0.0 ? 1.0 : memory.damages[0] + memory.damages[1];
}

// The part of opening and sliding that the bond holds. Returns the pressure.
template <int D> INLINE double bond_of(const JointLaw<D> &law, const Memory<D> &memory, const double *gap, double *bond) {
    for (int axis = 0; axis < D; ++axis) bond[axis] = gap[axis] - memory.origin[axis];
    const double opening = bond[0];
    bond[0] = larger(opening, 0.0);
    return law.penalty * larger(-opening, 0.0);
}

template <int D>
INLINE void soften(const JointLaw<D> &law, Memory<D> &memory, bool loads, double damage, const double *squares,
                   const double *found) {
    const double before = damage_of(memory);
    damage = smaller(damage, 1.0);
    const bool grows = loads && damage > before;
    for (int part = 0; part < 2; ++part) {
        memory.damages[part] += grows ? (damage - before) * squares[part] : 0.0;
    }
    damage = larger(damage, before);
    const double strength = found[0], critical = found[1];
    double secant = strength * softening(damage) / (strength + law.penalty * damage * critical);
    secant = loads && damage > 0.0 ? secant : 1.0;
    memory.stiffness = smaller(secant, memory.stiffness);
}

// Loads the bond. Returns whether it begins to soften.
template <int D> INLINE bool load(const JointLaw<D> &law, Memory<D> &memory, const double *gap) {
    double bond[D], squares[2], found[2];
    const double pressure = bond_of(law, memory, gap, bond);
    const double friction = law.friction * pressure;
    const double squared = dot<D>(bond, bond);
    const bool whole = memory.stiffness == 1.0;
    const double elastic = law.penalty * law.penalty * squared;
    const double most = least(law, friction);
    shares(law, bond, squared, squares);
    in_direction(law, squares, found);
    const double held = found[0] + friction;
    const bool rests = squared == 0.0 || memory.stiffness == 0.0 || (whole && elastic <= most * most) ||
                       (whole && friction > 0.0 && elastic <= held * held);
    const double damage = (square_root(squared) - found[0] / law.penalty) / found[1];
    soften(law, memory, !rests, damage, squares, found);
    return whole && memory.stiffness < 1.0;
}

// Traction of the bond, of pressure and of the spring of friction.
template <int D>
INLINE void of_bond_and_friction(const JointLaw<D> &law, Memory<D> &memory, const double *gap, bool begins,
                                 double *traction) {
    double bond[D], trial[D], held[D];
    const double pressure = bond_of(law, memory, gap, bond);
    const double friction = law.friction * pressure;
    const double stiffness = law.penalty * memory.stiffness;
    const double lost = law.cohesion == 0.0 ? law.penalty : law.penalty - law.penalty * memory.stiffness;
    for (int axis = 0; axis < D; ++axis) {
        memory.rubbed[axis] = begins ? memory.origin[axis] : memory.rubbed[axis];
        traction[axis] = stiffness * bond[axis];
        trial[axis] = axis == 0 ? 0.0 : gap[axis] - memory.rubbed[axis];
        trial[axis] = lost * trial[axis];
    }
    const double size = length<D>(trial);
    bool slips = false;
    for (int axis = 0; axis < D; ++axis) {
        held[axis] = size > friction ? friction * (trial[axis] / size) : trial[axis];
        if (axis > 0 && held[axis] != trial[axis]) slips = true;
    }
    const bool open = pressure == 0.0;
    slips = slips && pressure != 0.0;
    for (int axis = 0; axis < D; ++axis) {
        const double slid = gap[axis] - held[axis] / lost;
        memory.rubbed[axis] = open ? gap[axis] : slips ? slid : memory.rubbed[axis];
        if (axis > 0) traction[axis] = open ? traction[axis] : traction[axis] + held[axis];
    }
    traction[0] = open ? traction[0] : -pressure;
}

// Elastic energy of an end, over its area.
template <int D> INLINE double elastic_of(const JointLaw<D> &law, const Memory<D> &memory, const double *gap) {
    double bond[D], rubbing[D];
    for (int axis = 0; axis < D; ++axis) bond[axis] = gap[axis] - memory.origin[axis];
    const double opening = bond[0];
    if (memory.stiffness == 1.0 && law.tensile != 0.0 && law.cohesion != 0.0)
        return 0.5 * law.penalty * dot<D>(bond, bond);
    if (law.tensile == 0.0 && opening > 0.0) return 0.0;
    bond[0] = larger(opening, 0.0);
    const double stiffness = law.penalty * memory.stiffness;
    const double of_bond = 0.5 * stiffness * dot<D>(bond, bond);
    if (opening >= 0.0) return of_bond;
    const double lost = law.cohesion == 0.0 ? law.penalty : law.penalty - law.penalty * memory.stiffness;
    for (int axis = 0; axis < D; ++axis) rubbing[axis] = axis == 0 ? 0.0 : gap[axis] - memory.rubbed[axis];
    return of_bond + 0.5 * law.penalty * opening * opening + 0.5 * lost * dot<D>(rubbing, rubbing);
}

template <int D> INLINE void of_common(const JointLaw<D> &law, Memory<D> &memory, const double *gap, double *traction) {
    double whole[D], rubbed[D];
    const bool holds = of_whole(law, gap, memory.origin, whole) && memory.stiffness == 1.0;
    for (int axis = 0; axis < D; ++axis) rubbed[axis] = memory.rubbed[axis];
    const bool begins = load(law, memory, gap);
    of_bond_and_friction(law, memory, gap, begins, traction);
    for (int axis = 0; axis < D; ++axis) {
        memory.rubbed[axis] = holds ? rubbed[axis] : memory.rubbed[axis];
        traction[axis] = holds ? whole[axis] : traction[axis];
    }
}

// An end of a joint with a common law: what the law has and finds.
template <int D> struct JointEnd {
    JointLaw<D> law;
    Memory<D> memory;
    double gap[D];
    double traction[D];
};

struct JointEnds {
    // A JointEnd each.
    void *ends;
    u64 count;
};

template <int D> INLINE void soften_ends(const JointEnds &a, u32 block) {
    EACH(k, a.count) {
        JointEnd<D> &end = ((JointEnd<D> *)a.ends)[k];
        of_common(end.law, end.memory, end.gap, end.traction);
    }
}

struct Exponentials {
    double *numbers;
    u64 count;
};

KERNEL(exponentials, Exponentials) {
    EACH(k, a.count) { a.numbers[k] = exp_down(a.numbers[k]); }
}

INLINE void normalise(double *axis, int dimensions) {
    double squared = axis[0] * axis[0];
    for (int k = 1; k < dimensions; ++k) squared += axis[k] * axis[k];
    const double over = 1.0 / square_root(squared);
    for (int k = 0; k < dimensions; ++k) axis[k] = axis[k] * over;
}

INLINE void unit_axes(const double (*facet)[2], double (*axes)[2]) {
    const double x = facet[1][0] - facet[0][0], y = facet[1][1] - facet[0][1];
    axes[0][0] = y;
    axes[0][1] = -x;
    axes[1][0] = x;
    axes[1][1] = y;
    normalise(axes[0], 2);
    normalise(axes[1], 2);
}

INLINE void unit_axes(const double (*facet)[3], double (*axes)[3]) {
    double other[3];
    for (int k = 0; k < 3; ++k) {
        axes[1][k] = facet[1][k] - facet[0][k];
        other[k] = facet[2][k] - facet[0][k];
    }
    cross3(axes[1], other, axes[0]);
    normalise(axes[0], 3);
    normalise(axes[1], 3);
    cross3(axes[0], axes[1], axes[2]);
}

// The kinds of joints: `JointKind`.
const u32 WHOLE = 1, SOFTENS = 2, ALONE = 3;
// Bits of the marks of a joint: the kind, whether it is counted, and broken, and whether each end is open.
const u32 COUNTED = 4, BROKEN = 8, OPEN = 16;

struct Joints {
    const double *positions;
    const double *velocities;
    // Of each joint, end and side.
    const u32 *nodes;
    const u32 *marks;
    // Columns of a number of each joint: penalty, tensile strength, cohesion, friction, two critical lengths,
    // share, length, faded share, normal.
    const double *laws;
    // Columns: of each end the damages, stiffness, origin, and rubbed sliding.
    double *memories;
    // Of each joint and end on side 0.
    double *forces;
    // Joints that the host is to compute, and whether there are any.
    u32 *left;
    u32 *any_left;
    // Of each joint the elastic energy, 0 if it is not counted or left; empty if it is not asked for.
    double *elastic;
    // Rows of the work of each block, in both parts of the rounded numbers.
    double *sums;
    double grains[2];
    double step;
    u64 count;
    u64 blocks;
    // Joints for which the columns have room.
    u64 stride;
};

// Twin of `faded_at` in `joints/joint.rs`.
template <int D> INLINE double faded_at(const double *slid, double of_joint) {
    return (length<D>(slid) / of_joint - 0.1) / (0.3 - 0.1);
}

// Computes a joint, its work, and its elastic energy if it is asked for. Returns whether it stays of its kind;
// otherwise nothing is written.
template <int D> INLINE bool pull_joint(const Joints &a, u64 joint, u32 marks, double *work, double *elastic) {
    const u64 stride = a.stride;
    const double *numbers = a.laws + joint;
    JointLaw<D> law;
    law.penalty = numbers[0];
    law.tensile = numbers[stride];
    law.cohesion = numbers[2 * stride];
    law.friction = numbers[3 * stride];
    law.critical[0] = numbers[4 * stride];
    law.critical[1] = numbers[5 * stride];
    const double share = numbers[6 * stride], of_joint = numbers[7 * stride], faded = numbers[8 * stride];
    for (int axis = 0; axis < D; ++axis) law.normal[axis] = numbers[(9 + axis) * stride];
    double sums[D][D], apart[D][D], rates[D][D], axes[D][D], found[D][D], slid[D];
    Memory<D> memories[D];
    for (int end = 0; end < D; ++end) {
        const u32 *nodes = a.nodes + (joint * D + end) * 2;
        for (int axis = 0; axis < D; ++axis) {
            const double one = a.positions[(u64)nodes[0] * D + axis], two = a.positions[(u64)nodes[1] * D + axis];
            sums[end][axis] = one + two;
            apart[end][axis] = two - one;
            rates[end][axis] = a.velocities[(u64)nodes[1] * D + axis] - a.velocities[(u64)nodes[0] * D + axis];
        }
        double *memory = (double *)&memories[end];
        for (int k = 0; k < 3 + 2 * D; ++k) memory[k] = a.memories[(end * (3 + 2 * D) + k) * stride + joint];
        slid[end] = 0.0;
    }
    unit_axes(sums, axes);
    const bool is_whole = (marks & 3) == WHOLE;
    double least_gap = of_bits(0x7ff0000000000000ull);
    int broken_ends = 0;
    bool pressed = false, stays = true;
    *work = 0.0;
    *elastic = 0.0;
    for (int end = 0; end < D; ++end) {
        if (!(marks & OPEN << end)) continue;
        double gap[D], traction[D];
        for (int axis = 0; axis < D; ++axis) gap[axis] = dot<D>(apart[end], axes[axis]);
        if (is_whole) {
            stays = of_whole(law, gap, memories[end].origin, traction) && stays;
        } else {
            const double reach = 0.5 * of_joint;
            const bool far = damage_of(memories[end]) >= 1.0 && dot<D>(apart[end], apart[end]) > reach * reach;
            of_common(law, memories[end], gap, traction);
            if (damage_of(memories[end]) >= 1.0) ++broken_ends;
            for (int axis = 1; axis < D; ++axis) slid[axis] += gap[axis] / D;
            least_gap = smaller(least_gap, gap[0]);
            pressed = pressed || traction[0] < 0.0;
            stays = stays && !far;
        }
        for (int axis = 0; axis < D; ++axis) {
            double sum = traction[0] * axes[0][axis];
            for (int k = 1; k < D; ++k) sum += traction[k] * axes[k][axis];
            found[end][axis] = share * sum;
        }
        if (a.elastic) *elastic += share * elastic_of(law, memories[end], gap);
        const double *before = a.forces + (joint * D + end) * D;
        *work += 0.5 * a.step * (dot<D>(before, rates[end]) + dot<D>(found[end], rates[end]));
    }
    if (!is_whole) {
        const bool fades = faded_at<D>(slid, of_joint) > faded;
        const bool leaves = least_gap >= 0.0 && !pressed;
        const bool broken = marks & BROKEN;
        stays = stays && !(broken && (fades || leaves)) && (broken || broken_ends < D);
    }
    if (!stays) return false;
    for (int end = 0; end < D; ++end) {
        if (!(marks & OPEN << end)) continue;
        for (int axis = 0; axis < D; ++axis) a.forces[(joint * D + end) * D + axis] = found[end][axis];
        if (is_whole) continue;
        const double *memory = (const double *)&memories[end];
        for (int k = 0; k < 3 + 2 * D; ++k) a.memories[(end * (3 + 2 * D) + k) * stride + joint] = memory[k];
    }
    return true;
}

// Computes the joints of a block, and adds up their work: a plain sum of rounded numbers, exact in any order.
template <int D> INLINE void pull_joints(const Joints &a, u32 block) {
    SHARED double sums[2][THREADS];
    EACH_THREAD(t) {
        sums[0][t] = 0.0;
        sums[1][t] = 0.0;
        const u64 joint = (u64)block * THREADS + t;
        if (joint < a.count) {
            const u32 marks = a.marks[joint], kind = marks & 3;
            double work = 0.0, elastic = 0.0;
            bool is_left = kind == ALONE;
            if (kind == WHOLE || kind == SOFTENS) is_left = !pull_joint<D>(a, joint, marks, &work, &elastic);
            a.left[joint] = is_left;
            if (is_left) set_flag(a.any_left);
            if (a.elastic) a.elastic[joint] = !is_left && marks & COUNTED ? elastic : 0.0;
            if (!is_left && marks & COUNTED) {
                const double large = (work + a.grains[0]) - a.grains[0];
                sums[0][t] = large;
                sums[1][t] = ((work - large) + a.grains[1]) - a.grains[1];
            }
        }
    }
    for (u32 half = THREADS / 2; half > 0; half /= 2) {
        EACH_THREAD(t) {
            if (t < half) {
                sums[0][t] += sums[0][t + half];
                sums[1][t] += sums[1][t + half];
            }
        }
    }
    EACH_THREAD(t) {
        if (t < 2) a.sums[t * a.blocks + block] = sums[t][0];
    }
}

KERNEL(soften_ends_2, JointEnds) { soften_ends<2>(a, block); }
KERNEL(soften_ends_3, JointEnds) { soften_ends<3>(a, block); }
KERNEL(pull_joints_2, Joints) { pull_joints<2>(a, block); }
KERNEL(pull_joints_3, Joints) { pull_joints<3>(a, block); }
