// The phases of a step of bodies whose elements hang together: elements, then nodes.
#pragma once
#include "laws.h"

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
    // Of each element; empty without viscosity.
    const double *viscosities;
    // Viscous stress of each element, which a step replaces.
    double *viscous;
    // Of each element the force on each corner.
    double *forces;
    // Set if an element has no volume any more.
    u32 *inverted;
    u64 count;
};

template <int D> INLINE Matrix<D> edges_of(const double *values, const u32 *corners) {
    Matrix<D> edges;
    for (int axis = 0; axis < D; ++axis)
        for (int k = 0; k < D; ++k)
            edges.a[axis][k] = values[(u64)corners[k + 1] * D + axis] - values[(u64)corners[0] * D + axis];
    return edges;
}

template <int D> INLINE Matrix<D> tensor_of(const double *values, u64 number) {
    Matrix<D> tensor;
    for (int k = 0; k < D * D; ++k) tensor.a[k / D][k % D] = values[number * D * D + k];
    return tensor;
}

// Twin of `Solid::deform` in `solid.rs`.
template <int D> INLINE void solid_deform(const SolidElements &a, u32 block) {
    EACH(element, a.count) {
        const u32 *corners = a.corners + element * (D + 1);
        ElementState<D> state;
        ElementForces<D> found;
        state.gradients = tensor_of<D>(a.gradients, element);
        state.edges = edges_of<D>(a.positions, corners);
        state.volume = a.volumes[element];
        state.shear = a.moduli[2 * (u64)a.materials[element]];
        state.bulk = a.moduli[2 * (u64)a.materials[element] + 1];
        if (a.viscosities) {
            state.rates = edges_of<D>(a.velocities, corners);
            state.viscosity = a.viscosities[element];
            state.viscous = tensor_of<D>(a.viscous, element);
        }
        deform(state, false, a.viscosities != 0, found);
        if (a.viscosities) {
            for (int k = 0; k < D * D; ++k) a.viscous[element * D * D + k] = found.viscous.a[k / D][k % D];
        }
        const bool is_sound = found.ratio > 0.0;
        if (!is_sound) set_flag(a.inverted);
        for (int k = 0; k < (D + 1) * D; ++k) {
            a.forces[element * (D + 1) * D + k] = is_sound ? found.forces[k / D][k % D] : 0.0;
        }
    }
}

struct SolidNodes {
    double *positions;
    double *velocities;
    const double *masses;
    // Of each node where its corners begin, and the corners.
    const u32 *starts;
    const u32 *corners;
    const double *forces;
    double gravity[3];
    double step;
    double local_damping;
    u64 count;
};

// Twin of `local_damping` in `motion/nodes.rs`.
INLINE double local_damping(double damping, double force, double velocity) {
    if (damping == 0.0 || velocity == 0.0) return 0.0;
    const double against = damping * (force < 0.0 ? -force : force);
    return velocity < 0.0 ? -against : against;
}

// Twin of `force_on` and `move_node` in `motion/nodes.rs`, for nodes that nothing holds.
template <int D> INLINE void solid_move(const SolidNodes &a, u32 block) {
    EACH(node, a.count) {
        double force[D];
        for (int axis = 0; axis < D; ++axis) force[axis] = 0.0;
        for (u32 k = a.starts[node]; k < a.starts[node + 1]; ++k) {
            for (int axis = 0; axis < D; ++axis) force[axis] += a.forces[(u64)a.corners[k] * D + axis];
        }
        const double mass = a.masses[node], over = a.step / mass;
        for (int axis = 0; axis < D; ++axis) {
            const double before = a.velocities[node * D + axis];
            const double all = force[axis] + mass * a.gravity[axis];
            const double after = before + over * (all - local_damping(a.local_damping, all, before));
            a.velocities[node * D + axis] = after;
            a.positions[node * D + axis] = a.positions[node * D + axis] + a.step * after;
        }
    }
}

KERNEL(solid_deform_2, SolidElements) { solid_deform<2>(a, block); }
KERNEL(solid_deform_3, SolidElements) { solid_deform<3>(a, block); }
KERNEL(solid_move_2, SolidNodes) { solid_move<2>(a, block); }
KERNEL(solid_move_3, SolidNodes) { solid_move<3>(a, block); }
