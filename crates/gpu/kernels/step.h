// The phases of a step: elements, then nodes.
#pragma once
#include "laws.h"
#include "watch.h"

struct SolidElements {
    // Relative to the origin, m, and half a step before, m/s; by node, then by axis.
    const double *positions;
    const double *velocities;
    // Nodes of each element.
    const u32 *corners;
    // Of each element the inverse of its undeformed edges, and its volume.
    const double *gradients;
    const double *volumes;
    // Of each element the number of its material, of each material the moduli of shear and bulk.
    const u32 *materials;
    const double *moduli;
    // Of each material its bedding, whose normal is 0 where it has none, and of each element the present normal,
    // which a step replaces; empty without bedding.
    const void *beddings;
    double *normals;
    // Initial stress of each element, and the energy that it has stored; empty without it.
    const double *initial;
    const double *stored;
    // Of each element; empty without viscosity.
    const double *viscosities;
    // Viscous stress of each element, which a step replaces, and the energy that it has dissipated.
    double *viscous;
    double *dissipated;
    // Of each element the force on each corner, the stress, and the strain energy.
    double *forces;
    double *stresses;
    double *energies;
    // Set if an element has no volume any more.
    u32 *inverted;
    double step;
    u64 count;
    Watched watched;
};

template <int D> INLINE Matrix<D> edges_of(const double *values, const u32 *corners) {
    Matrix<D> edges;
    for (int axis = 0; axis < D; ++axis)
        for (int k = 0; k < D; ++k)
            edges.a[axis][k] = values[(u64)corners[k + 1] * D + axis] - values[(u64)corners[0] * D + axis];
    return edges;
}

template <int D> INLINE void set_tensor(double *values, u64 number, const Matrix<D> &tensor) {
    for (int k = 0; k < D * D; ++k) values[number * D * D + k] = tensor.a[k / D][k % D];
}

template <int D> INLINE Matrix<D> tensor_of(const double *values, u64 number) {
    Matrix<D> tensor;
    for (int k = 0; k < D * D; ++k) tensor.a[k / D][k % D] = values[number * D * D + k];
    return tensor;
}

// Twin of `Solid::deform` in `solid.rs`.
template <int D> INLINE void deform_element(const SolidElements &a, u64 element) {
    const u32 *corners = a.corners + element * (D + 1);
    double *forces = a.forces + element * (D + 1) * D;
    ElementState<D> state;
    ElementForces<D> found;
    state.volume = a.volumes[element];
    // It belongs to a rigid body.
    if (state.volume == 0.0) {
        for (int k = 0; k < (D + 1) * D; ++k) forces[k] = 0.0;
        if (a.watched.noted) rest(a.watched, element);
        return;
    }
    state.gradients = tensor_of<D>(a.gradients, element);
    state.edges = edges_of<D>(a.positions, corners);
    state.shear = a.moduli[2 * (u64)a.materials[element]];
    state.bulk = a.moduli[2 * (u64)a.materials[element] + 1];
    if (a.initial) {
        state.initial = tensor_of<D>(a.initial, element);
        state.stored = a.stored[element];
    }
    if (a.viscosities) {
        state.rates = edges_of<D>(a.velocities, corners);
        state.viscosity = a.viscosities[element];
        state.viscous = tensor_of<D>(a.viscous, element);
    }
    LawParts parts = {a.initial != 0, a.viscosities != 0, false};
    if (a.beddings) {
        state.bedding = ((const Bedding<D> *)a.beddings)[a.materials[element]];
        parts.bedded = dot<D>(state.bedding.normal, state.bedding.normal) > 0.0;
    }
    deform(state, parts, found);
    if (parts.bedded) {
        for (int axis = 0; axis < D; ++axis) a.normals[element * D + axis] = found.normal[axis];
    }
    if (a.viscosities) {
        set_tensor(a.viscous, element, found.viscous);
        if (state.viscosity > 0.0) a.dissipated[element] += 0.5 * a.step * found.power * state.volume;
    }
    set_tensor(a.stresses, element, found.stress);
    a.energies[element] = found.energy;
    if (a.watched.noted) find_moved(a.watched, element, state.edges, found.stress);
    const bool is_sound = found.ratio > 0.0;
    if (!is_sound) set_flag(a.inverted);
    for (int k = 0; k < (D + 1) * D; ++k) forces[k] = is_sound ? found.forces[k / D][k % D] : 0.0;
}

template <int D> INLINE void solid_deform(const SolidElements &a, u32 block) {
    EACH(element, a.count) { deform_element<D>(a, element); }
}

struct CornerForces {
    // Corners, each once, and where the forces on each begin and end among the forces.
    const u32 *corners;
    const u32 *starts;
    const double *added;
    double *forces;
    u64 count;
};

// Twin of `add_forces` in `machine/threads.rs`: the forces on a corner are added in their order.
template <int D> INLINE void add_forces(const CornerForces &a, u32 block) {
    EACH(k, a.count) {
        double *force = a.forces + (u64)a.corners[k] * D;
        for (u32 place = a.starts[k]; place < a.starts[k + 1]; ++place) {
            for (int axis = 0; axis < D; ++axis) force[axis] += a.added[(u64)place * D + axis];
        }
    }
}

struct GatheredRows {
    // Rows of D values, the numbers of some of them, and these.
    const double *values;
    const u32 *numbers;
    double *gathered;
    u64 count;
};

template <int D> INLINE void gather_rows(const GatheredRows &a, u32 block) {
    EACH(k, a.count) {
        for (int axis = 0; axis < D; ++axis) a.gathered[k * D + axis] = a.values[(u64)a.numbers[k] * D + axis];
    }
}

// A node that boundaries hold, by axes: `HeldNode`.
template <int D> struct HeldNode {
    u32 kinds[D];
    u32 boundaries[D];
    double values[D];
    double start[D];
};

// The motion of a boundary in a step: `Drive`.
struct Drive {
    double factors[2];
    double turn[3][3];
    double through[3];
};

// Rows of sums over the nodes, each with both parts of the rounded numbers.
const u32 KINETIC = 0, EXTERNAL = 1, DAMPING = 3, TAKEN = 5, SUMS = 7;
// Rows of largest numbers.
const u32 FASTEST = 0, LARGEST = 1, MOSTS = 3;

struct SolidNodes {
    double *positions;
    double *velocities;
    // In motion, and in the weight; the latter is empty where they are the same.
    const double *masses;
    const double *true_masses;
    // Of each node where its corners begin and end, and the corners.
    const u32 *ranges;
    const u32 *corners;
    const double *forces;
    // Of each corner the ends of joints there, and the forces of joints; empty without joints.
    const u32 *ends;
    const double *of_joints;
    // Of each node its place among those that are held, or NO_NUMBER.
    const u32 *places;
    const void *held;
    const Drive *drives;
    // Of each node that is held the force of the supports, and the position before the step.
    double *reactions;
    // Sums over the nodes of each block: SUMS times two rows of a number for each block.
    double *sums;
    // Largest numbers of each block: MOSTS rows.
    double *mosts;
    // Set if a node is too fast.
    u32 *runaway;
    double gravity[3];
    double origin[3];
    // To round to the large grain, and the rest to the small one.
    double grains[2];
    double step;
    double local_damping;
    double relaxation;
    double speed_limit;
    u64 count;
    // Which sums are computed.
    u32 energy;
    u32 taken_after;
    u32 taken_before;
    u32 blocks;
};

// Numbers that stand for none, and for the place of a node that the host moves.
const u32 NO_NUMBER = 0xffffffffu, BY_HOST = 0xfffffffeu;

// Twin of `local_damping` in `motion/nodes.rs`.
INLINE double local_damping(double damping, double force, double velocity) {
    if (damping == 0.0 || velocity == 0.0) return 0.0;
    const double against = damping * (force < 0.0 ? -force : force);
    return velocity < 0.0 ? -against : against;
}

// Twin of `damping` in `motion/nodes.rs`.
INLINE double damping(const SolidNodes &a, double mass, double force, double before) {
    const double local = local_damping(a.local_damping, force, before);
    if (a.relaxation == 0.0) return local;
    const double half = 0.5 * a.relaxation * a.step;
    const double speed = before + 0.5 * a.step / mass * (force - local);
    return local + a.relaxation * mass * speed / (1.0 + half);
}

// Twin of `Hold::velocity` in `actions/prescribed.rs`.
template <int D>
INLINE double held_velocity(const SolidNodes &a, const HeldNode<D> &held, int axis, const double *position) {
    const Drive &drive = a.drives[held.boundaries[axis]];
    if (held.kinds[axis] == 1) return held.values[axis] * drive.factors[0];
    if (held.kinds[axis] == 2) {
        const double moved = position[axis] - held.start[axis];
        return (held.values[axis] * drive.factors[1] - moved) / a.step;
    }
    double arm[3];
    for (int k = 0; k < 3; ++k) arm[k] = (k < D ? position[k] + a.origin[k] : 0.0) - drive.through[k];
    return (dot<3>(drive.turn[axis], arm) - arm[axis]) / a.step;
}

// Adds a number to a sum, rounded to the grains: `Grains::parts`.
INLINE void add_parts(const SolidNodes &a, double (*sums)[THREADS], u32 t, u32 row, double number) {
    const double large = (number + a.grains[0]) - a.grains[0];
    sums[2 * row][t] += large;
    sums[2 * row + 1][t] += ((number - large) + a.grains[1]) - a.grains[1];
}

// The larger of a number and one that may be none.
INLINE double larger_of(double most, double number) { return number > most ? number : most; }

// Moves a node, and adds to the sums of its thread. Twin of `force_on`, `move_node` and `hold_node` in
// `motion/nodes.rs`.
template <int D>
INLINE void move_node(const SolidNodes &a, u64 node, u32 t, double (*sums)[THREADS], double (*mosts)[THREADS]) {
    double force[D], weight[D], free[D], before[D], after[D], damped[D], outer[D], position[D];
    const u32 place = a.places[node];
    if (place == BY_HOST) return;
    for (int axis = 0; axis < D; ++axis) force[axis] = 0.0;
    for (u32 corner = a.ranges[2 * node]; corner < a.ranges[2 * node + 1]; ++corner) {
        const double *of_corner = a.forces + (u64)a.corners[corner] * D;
        for (int axis = 0; axis < D; ++axis) force[axis] += of_corner[axis];
        for (int k = 0; a.ends && k < D; ++k) {
            const u32 code = a.ends[(u64)a.corners[corner] * D + k];
            if (code == NO_NUMBER) continue;
            const double *pull = a.of_joints + (u64)(code / 2) * D;
            for (int axis = 0; axis < D; ++axis) force[axis] += code % 2 ? -pull[axis] : pull[axis];
        }
        if (a.energy) mosts[LARGEST + 1][t] = larger_of(mosts[LARGEST + 1][t], dot<D>(of_corner, of_corner));
    }
    const double mass = a.masses[node], over = a.step / mass;
    const double true_mass = a.true_masses ? a.true_masses[node] : mass;
    const HeldNode<D> *held = place == NO_NUMBER ? 0 : (const HeldNode<D> *)a.held + place;
    for (int axis = 0; axis < D; ++axis) position[axis] = a.positions[node * D + axis];
    for (int axis = 0; axis < D; ++axis) {
        before[axis] = a.velocities[node * D + axis];
        weight[axis] = true_mass * a.gravity[axis];
        force[axis] = force[axis] + weight[axis];
        free[axis] = held ? 0.0 : force[axis];
        damped[axis] = damping(a, mass, force[axis], before[axis]);
        after[axis] = before[axis] + over * (force[axis] - damped[axis]);
        outer[axis] = weight[axis];
        if (held) {
            double reaction = 0.0;
            if (held->kinds[axis]) {
                after[axis] = held_velocity(a, *held, axis, position);
                damped[axis] = 0.0;
                reaction = mass * (after[axis] - before[axis]) / a.step - force[axis];
            }
            outer[axis] = weight[axis] + reaction;
            a.reactions[(u64)place * 2 * D + axis] = reaction;
        }
    }
    for (int axis = 0; axis < D; ++axis) {
        if (held) a.reactions[(u64)place * 2 * D + D + axis] = position[axis];
        a.velocities[node * D + axis] = after[axis];
        a.positions[node * D + axis] = position[axis] + a.step * after[axis];
        const bool is_free = !held || !held->kinds[axis];
        if (is_free && a.taken_after) add_parts(a, sums, t, TAKEN, a.step * force[axis] * after[axis]);
        if (is_free && a.taken_before) {
            add_parts(a, sums, t, TAKEN, a.step * force[axis] * before[axis]);
            add_parts(a, sums, t, TAKEN + 1, mass * before[axis] * before[axis]);
        }
    }
    const double half = 0.5 * a.step, squared = dot<D>(after, after);
    add_parts(a, sums, t, EXTERNAL, half * dot<D>(outer, before));
    add_parts(a, sums, t, EXTERNAL + 1, half * dot<D>(outer, after));
    add_parts(a, sums, t, DAMPING, half * dot<D>(damped, before));
    add_parts(a, sums, t, DAMPING + 1, half * dot<D>(damped, after));
    mosts[FASTEST][t] = larger_of(mosts[FASTEST][t], squared);
    if (a.energy) {
        add_parts(a, sums, t, KINETIC, 0.5 * mass * dot<D>(before, after));
        mosts[LARGEST][t] = larger_of(mosts[LARGEST][t], dot<D>(free, free));
    }
    if (!(squared <= a.speed_limit * a.speed_limit)) set_flag(a.runaway);
}

// Moves the nodes of a block, and adds up their sums: plain sums of rounded numbers, exact in any order.
template <int D> INLINE void solid_move(const SolidNodes &a, u32 block) {
    SHARED double sums[2 * SUMS][THREADS];
    SHARED double mosts[MOSTS][THREADS];
    EACH_THREAD(t) {
        for (u32 row = 0; row < 2 * SUMS; ++row) sums[row][t] = 0.0;
        for (u32 row = 0; row < MOSTS; ++row) mosts[row][t] = 0.0;
        const u64 node = (u64)block * THREADS + t;
        if (node < a.count) move_node<D>(a, node, t, sums, mosts);
    }
    for (u32 half = THREADS / 2; half > 0; half /= 2) {
        EACH_THREAD(t) {
            if (t < half) {
                for (u32 row = 0; row < 2 * SUMS; ++row) sums[row][t] += sums[row][t + half];
                for (u32 row = 0; row < MOSTS; ++row) mosts[row][t] = larger_of(mosts[row][t], mosts[row][t + half]);
            }
        }
    }
    EACH_THREAD(t) {
        if (t < 2 * SUMS) a.sums[t * a.blocks + block] = sums[t][0];
        if (t < MOSTS) a.mosts[t * a.blocks + block] = mosts[t][0];
    }
}

KERNEL(solid_deform_2, SolidElements) { solid_deform<2>(a, block); }
KERNEL(solid_deform_3, SolidElements) { solid_deform<3>(a, block); }
KERNEL(add_forces_2, CornerForces) { add_forces<2>(a, block); }
KERNEL(add_forces_3, CornerForces) { add_forces<3>(a, block); }
KERNEL(gather_rows_2, GatheredRows) { gather_rows<2>(a, block); }
KERNEL(gather_rows_3, GatheredRows) { gather_rows<3>(a, block); }
KERNEL(solid_move_2, SolidNodes) { solid_move<2>(a, block); }
KERNEL(solid_move_3, SolidNodes) { solid_move<3>(a, block); }
