// Contacts between elements: their laws, and the phase of a step that computes them. The functions are twins
// of those in Rust, whose names they have and whose operations they do in the same order:
//
// - `gap`, `furthest`, `parted`, `apart`: `crates/simulation/src/simplex.rs`
// - `chord`, `add_edge`: `simplex/triangle/potential.rs`
// - `word`, `code`, `add_face`: `simplex/tetrahedron/potential.rs`
// - functions of a `Part`: `simplex/tetrahedron/part.rs`
// - `between`: `simplex/tetrahedron/distance.rs`
// - `energy_of`, `interactions`: `simplex/interactions.rs`
// - `grip_one`, `count_from`, `count_beyond`: `contacts/elements/grips.rs`
// - `press_couple`: `contacts/chunk.rs`
#pragma once
#include "joints.h"

// As in `simplex.rs` and `interactions.rs`.
const double NEAR = 1e-5, ASIDE = 3e-5;

template <int D> INLINE void minus(const double *a, const double *b, double *c) {
    for (int axis = 0; axis < D; ++axis) c[axis] = a[axis] - b[axis];
}

template <int D> INLINE void unit(double *a) {
    const double size = length<D>(a);
    for (int axis = 0; axis < D; ++axis) a[axis] = a[axis] / size;
}

INLINE double cross(const double *a, const double *b) { return a[0] * b[1] - a[1] * b[0]; }

// Corners of a facet: `FACETS`.
template <int D> INLINE int facet_corner(int facet, int k) {
    const unsigned char edges[3][2] = {{0, 1}, {1, 2}, {2, 0}};
    const unsigned char faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    return D == 2 ? edges[facet % 3][k % 2] : faces[facet][k];
}

// Barycentric coordinates: `AreaCoordinates`, `VolumeCoordinates`. `size`: twice the area, six times the volume.
template <int D> struct Coordinates {
    double origin[D];
    double gradients[D + 1][D];
    double size;
};

INLINE void coordinates_of(const double (*corners)[2], Coordinates<2> &to) {
    double one[2], two[2];
    minus<2>(corners[1], corners[0], one);
    minus<2>(corners[2], corners[0], two);
    to.size = cross(one, two);
    const double over = 1.0 / to.size;
    for (int k = 0; k < 3; ++k) {
        double edge[2];
        minus<2>(corners[(k + 2) % 3], corners[(k + 1) % 3], edge);
        to.gradients[k][0] = -edge[1] * over;
        to.gradients[k][1] = edge[0] * over;
    }
    for (int axis = 0; axis < 2; ++axis) to.origin[axis] = corners[0][axis];
}

INLINE void coordinates_of(const double (*corners)[3], Coordinates<3> &to) {
    double e[3], f[3], g[3];
    minus<3>(corners[1], corners[0], e);
    minus<3>(corners[2], corners[0], f);
    minus<3>(corners[3], corners[0], g);
    cross3(f, g, to.gradients[1]);
    cross3(g, e, to.gradients[2]);
    cross3(e, f, to.gradients[3]);
    to.size = dot<3>(e, to.gradients[1]);
    const double over = 1.0 / to.size;
    for (int axis = 0; axis < 3; ++axis) {
        for (int k = 1; k < 4; ++k) to.gradients[k][axis] = to.gradients[k][axis] * over;
        to.gradients[0][axis] = -to.gradients[1][axis] - to.gradients[2][axis] - to.gradients[3][axis];
        to.origin[axis] = corners[0][axis];
    }
}

template <int D> INLINE void coordinates_at(const Coordinates<D> &of, const double *point, double *at) {
    double from[D];
    minus<D>(point, of.origin, from);
    at[0] = 1.0;
    for (int k = 1; k <= D; ++k) {
        at[k] = dot<D>(of.gradients[k], from);
        at[0] -= at[k];
    }
}

template <int D> INLINE double gap(const double (*a)[D], const double (*b)[D]) {
    double most = of_bits(0xfff0000000000000ull);
    for (int axis = 0; axis < D; ++axis) {
        double low[2] = {a[0][axis], b[0][axis]}, high[2] = {a[0][axis], b[0][axis]};
        for (int corner = 1; corner <= D; ++corner) {
            const double at[2] = {a[corner][axis], b[corner][axis]};
            for (int side = 0; side < 2; ++side) {
                low[side] = smaller(low[side], at[side]);
                high[side] = larger(high[side], at[side]);
            }
        }
        most = larger(most, larger(low[0] - high[1], low[1] - high[0]));
    }
    return most;
}

template <int D> INLINE double furthest(const double (*gradients)[D], const double (*at)[D + 1]) {
    double furthest = -1.0;
    for (int k = 0; k <= D; ++k) {
        double most = at[0][k];
        for (int corner = 1; corner <= D; ++corner) most = larger(most, at[corner][k]);
        const double squared = most * most / dot<D>(gradients[k], gradients[k]);
        furthest = larger(furthest, most <= 0.0 ? squared : -1.0);
    }
    return furthest;
}

template <int D> INLINE double parted(const double (*contactor)[D], const double (*target)[D]) {
    Coordinates<D> coordinates;
    double at[D + 1][D + 1];
    coordinates_of(target, coordinates);
    for (int corner = 0; corner <= D; ++corner) coordinates_at(coordinates, contactor[corner], at[corner]);
    const double squared = furthest<D>(coordinates.gradients, at);
    return squared < 0.0 ? -1.0 : square_root(squared);
}

template <int D> FUNCTION double apart(const double (*a)[D], const double (*b)[D]) {
    const double boxes = larger(gap<D>(a, b), parted<D>(a, b));
    return larger(boxes, parted<D>(b, a));
}

// Forces and energies of two elements: `Interactions`.
template <int D> struct Interactions {
    double forces[2][D + 1][D];
    double energies[2];
    u32 passing[2];
    double point[D];
    double deep;
};

// One of two elements acts with its potential on the facets of the other: `LoopValues`, `TriangleScratch`.
template <int D> struct Side {
    Coordinates<D> coordinates;
    double centroid[D];
    // Barycentric coordinates of the corners of the contactor in the target.
    double at[D + 1][D + 1];
    double outside, inside;
    u32 passing;
};

// Pressure, and pressure times position.
template <int D> struct Moment {
    double weight;
    double moment[D];
};

INLINE double mean_of(const double (*corners)[2], int axis) {
    return 1.0 / 3.0 * (corners[0][axis] + corners[1][axis] + corners[2][axis]);
}

INLINE double mean_of(const double (*corners)[3], int axis) {
    return 0.25 * (corners[0][axis] + corners[1][axis] + corners[2][axis] + corners[3][axis]);
}

template <int D> INLINE void begin_side(const double (*contactor)[D], const double (*target)[D], Side<D> &side) {
    coordinates_of(target, side.coordinates);
    for (int axis = 0; axis < D; ++axis) side.centroid[axis] = mean_of(target, axis);
    for (int corner = 0; corner <= D; ++corner) coordinates_at(side.coordinates, contactor[corner], side.at[corner]);
    side.outside = 0.0;
    side.inside = 1.0;
    side.passing = 0;
}

template <int D>
INLINE void set_energy(Interactions<D> &found, int side, const double (*gradients)[D], double energy) {
    for (int corner = 0; corner <= D; ++corner) {
        for (int axis = 0; axis < D; ++axis) {
            found.forces[side][corner][axis] = found.forces[side][corner][axis] - gradients[corner][axis] * energy;
        }
    }
    found.energies[side] = energy;
}

// Adds the energy of the potential of a target, unless a facet passes near its centroid: `all_energies`.
template <int D> INLINE void end_side(const Side<D> &side, int of, Interactions<D> &found) {
    const double size = side.coordinates.size;
    const double part = D == 2 ? 1.0 / 3.0 * (0.5 * size) : 0.25 * (size * (1.0 / 6.0));
    const double energy = side.outside + side.inside * part;
    set_energy<D>(found, 1 - of, side.coordinates.gradients, side.passing ? 0.0 : energy);
    found.passing[1 - of] = side.passing;
    found.deep = larger(found.deep, side.inside);
}

// The part of an edge that lies in another triangle.
struct Chord {
    double at_start, at_end, outside, least;
};

INLINE double chord_cut(const double *start, const double *end, int k, int l, double from, double to) {
    const double x = start[k] - start[l], y = end[k] - end[l];
    const double cut = x / (x - y);
    return cut > from && cut < to ? cut : to;
}

FUNCTION Chord chord(const double *start, const double *end) {
    double back[3], from = 0.0, to = 1.0;
    bool beyond = false;
    for (int k = 0; k < 3; ++k) {
        back[k] = start[k] - end[k];
        const double x = start[k], y = end[k], crossing = x / back[k];
        from = x < 0.0 ? larger(from, crossing) : from;
        to = y < 0.0 ? smaller(to, crossing) : to;
        beyond = beyond || (x < 0.0 && y < 0.0);
    }
    to = beyond ? from : larger(to, from);
    const double one = chord_cut(start, end, 0, 1, from, to), two = chord_cut(start, end, 1, 2, from, to);
    const double three = chord_cut(start, end, 2, 0, from, to);
    const double low = smaller(one, two), high = larger(two, one);
    const double middle = smaller(high, three), last = larger(three, high);
    const double at[5] = {from, smaller(low, middle), larger(middle, low), last, to};
    double phi[5], w[5], pieces[4][3], sums[2];
    for (int k = 0; k < 5; ++k) {
        const double x = start[0] - at[k] * back[0], y = start[1] - at[k] * back[1], z = start[2] - at[k] * back[2];
        phi[k] = larger(3.0 * smaller(smaller(x, y), z), 0.0);
        w[k] = 1.0 - phi[k];
    }
    for (int k = 0; k < 4; ++k) {
        const double s = at[k], t = at[k + 1], a = phi[k], b = phi[k + 1];
        const double size = t - s, both = a + b;
        pieces[k][0] = size * both;
        pieces[k][1] = size * (both * (s + t) + (a * s + b * t));
        pieces[k][2] = size * (both * both - a * b * (1.0 + both));
    }
    for (int k = 0; k < 2; ++k) sums[k] = (pieces[0][k] + pieces[1][k]) + (pieces[2][k] + pieces[3][k]);
    const double total = sums[0], at_end = 1.0 / 6.0 * sums[1];
    const double first = pieces[0][2] * w[2] + pieces[1][2] * w[0], second = pieces[2][2] * w[4] + pieces[3][2] * w[2];
    const double before = w[0] * w[1], after = w[3] * w[4];
    const double outside = (first * after + second * before) / (before * w[2] * after);
    const double least = smaller(smaller(w[0], w[1]), smaller(smaller(w[2], w[3]), w[4]));
    return {0.5 * total - at_end, at_end, -(1.0 / 6.0) * outside, least};
}

// Adds the forces on an edge of the contactor, and their reaction: `all_edges`.
FUNCTION void add_edge(const double (*contactor)[2], int of, int k, Side<2> &side, Moment<2> &moment,
                     Interactions<2> &found) {
    const int next = (k + 1) % 3;
    const double *start = side.at[k], *end = side.at[next], *here = contactor[k], *there = contactor[next];
    const Chord part = chord(start, end);
    double along[2], from[2];
    minus<2>(there, here, along);
    minus<2>(here, side.centroid, from);
    const double normal[2] = {along[1], -along[0]};
    const double beyond = dot<2>(from, normal);
    const double pressure = part.at_start + part.at_end;
    const bool presses = pressure != 0.0;
    side.outside += presses ? beyond * part.outside : 0.0;
    side.inside = beyond >= 0.0 ? side.inside : 0.0;
    if (presses && part.least < NEAR) side.passing |= 1u << k;
    double(*own)[2] = found.forces[of], (*other)[2] = found.forces[1 - of];
    for (int axis = 0; axis < 2; ++axis) {
        own[k][axis] += normal[axis] * -part.at_start;
        own[next][axis] += normal[axis] * -part.at_end;
    }
    for (int corner = 0; corner < 3; ++corner) {
        const double share = start[corner] * part.at_start + end[corner] * part.at_end;
        for (int axis = 0; axis < 2; ++axis) other[corner][axis] += normal[axis] * share;
    }
    const double size = square_root(dot<2>(normal, normal));
    moment.weight += size * pressure;
    for (int axis = 0; axis < 2; ++axis) {
        const double on = here[axis] * part.at_start + there[axis] * part.at_end;
        moment.moment[axis] += size * on;
    }
}

INLINE void add_facets(const double (*contactor)[2], int of, Side<2> &side, Moment<2> &moment, Interactions<2> &found) {
    for (int k = 0; k < 3; ++k) add_edge(contactor, of, k, side, moment, found);
}

// Most corners of a part of a face: each of four lines adds one to a triangle. Numbers of a part: `NUMBERS`.
const int MOST_CORNERS = 7, PART_NUMBERS = 5;

// A triangle that is cut by lines, by the last two barycentric coordinates of its corners.
struct Part {
    double places[MOST_CORNERS][2];
    int corners;
    bool left;
};

// The point of an edge where a line is zero: `Edge::crossing`.
INLINE void crossing(const double *from, const double *to, double a, double b, double *point) {
    const double share = a / (a - b);
    for (int axis = 0; axis < 2; ++axis) point[axis] = from[axis] + share * (to[axis] - from[axis]);
}

// Keeps only the longest run, around the polygon, of the corners that are kept.
INLINE void keep_longest_run(bool *kept, int count) {
    int first = 0, longest = -1;
    for (int begin = 0; begin < count; ++begin) {
        int run = 0;
        while (run < count && kept[(begin + run) % count]) ++run;
        if (run > longest) {
            first = begin;
            longest = run;
        }
    }
    for (int k = 0; k < count; ++k) kept[k] = (k + count - first) % count < longest;
}

// Cuts a part by the next line, given at the corners of the face.
FUNCTION void cut(Part &part, const double *line) {
    const int corners = part.corners;
    const double zero = line[0], one = line[1] - zero, two = line[2] - zero;
    double at[MOST_CORNERS], leaving[2], entering[2];
    bool kept[MOST_CORNERS], some = false;
    int exits = 0;
    for (int k = 0; k < corners; ++k) {
        at[k] = zero + part.places[k][0] * one + part.places[k][1] * two;
        kept[k] = at[k] >= 0.0;
        some = some || kept[k];
        if (k > 0 && kept[k - 1] && !kept[k]) ++exits;
    }
    if (kept[corners - 1] && !kept[0]) ++exits;
    part.left = part.left && some;
    if (exits > 1) keep_longest_run(kept, corners);
    // Where all or none are kept, both points are a corner.
    const double *end = part.places[corners - 1];
    crossing(end, end, 1.0, 0.0, leaving);
    crossing(end, end, 1.0, 0.0, entering);
    for (int k = 0; k < corners; ++k) {
        const int next = (k + 1) % corners;
        if (kept[k] && !kept[next]) crossing(part.places[k], part.places[next], at[k], at[next], leaving);
        if (!kept[k] && kept[next]) crossing(part.places[k], part.places[next], at[k], at[next], entering);
    }
    // From the last corner on, whose places are not needed any more: a corner moves by at most one place.
    bool all[MOST_CORNERS + 1], any[MOST_CORNERS + 1];
    all[0] = true;
    any[0] = false;
    for (int k = 0; k < corners; ++k) {
        all[k + 1] = all[k] && kept[k];
        any[k + 1] = any[k] || kept[k];
    }
    for (int k = corners; k >= 0; --k) {
        const bool own = k < corners && kept[k], before = k > 0 && kept[k - 1], turns = kept[0];
        const bool keeps = own && (all[k] || !turns);
        const bool leaves = !own && ((turns && all[k]) || (!turns && any[k]));
        const bool moves = turns && !all[k] && before;
        for (int axis = 0; axis < 2; ++axis) {
            const double moved = k > 0 ? part.places[k - 1][axis] : 0.0;
            double place = moves ? moved : entering[axis];
            place = leaves ? leaving[axis] : place;
            if (!keeps) part.places[k][axis] = place;
        }
    }
    part.corners = corners + 1;
}

// Integrals over a part, on which a potential is linear, a quarter of which is given at the corners of the
// face: `all_integrals`. Adds them to sums, of which the last is the largest.
FUNCTION void add_integrals(const Part &part, const double *potential, double *sums) {
    const double zero = potential[0], one = potential[1] - zero, two = potential[2] - zero;
    double phi[MOST_CORNERS], numbers[PART_NUMBERS] = {0.0, 0.0, 0.0, 0.0, 0.0};
    for (int k = 0; k < part.corners; ++k) {
        phi[k] = larger(4.0 * (zero + part.places[k][0] * one + part.places[k][1] * two), 0.0);
        numbers[4] = larger(numbers[4], phi[k]);
    }
    const double *first = part.places[0];
    for (int k = 2; k < part.corners; ++k) {
        const double *second = part.places[k - 1], *third = part.places[k];
        const double a = phi[0], b = phi[k - 1], c = phi[k];
        double from[2], to[2];
        minus<2>(second, first, from);
        minus<2>(third, first, to);
        const double area = cross(from, to), sum = a + b + c;
        numbers[0] += area * sum;
        for (int axis = 0; axis < 2; ++axis) {
            const double own = a * first[axis] + b * second[axis] + c * third[axis];
            numbers[1 + axis] += area * (sum * (first[axis] + second[axis] + third[axis]) + own);
        }
        const double pairs = a * b + b * c + c * a, three = a * b * c;
        const double w = (1.0 - a) * (1.0 - b) * (1.0 - c);
        numbers[3] += -(area * (sum * sum - pairs - sum * pairs + three + sum * three) / w);
    }
    sums[0] += part.left ? 1.0 / 3.0 * numbers[0] : 0.0;
    for (int k = 1; k < 4; ++k) sums[k] += part.left ? 1.0 / 12.0 * numbers[k] : 0.0;
    sums[4] = larger(sums[4], part.left ? 1.0 * numbers[4] : 0.0);
}

// Bits of the word of a corner: as in the twin.
const u32 NEGATIVE = 4, MORE = 8, LESS = 24;

INLINE u64 word(const double *at) {
    u64 word = 0;
    for (u32 k = 0; k < 4; ++k) {
        word |= (u64)(at[k] > 0.0) << k;
        word |= (u64)(at[k] < 0.0) << (NEGATIVE + k);
        for (u32 j = 0; j < 4; ++j) {
            if (j == k) continue;
            word |= (u64)(at[k] > at[j]) << (MORE + 4 * k + j);
            word |= (u64)(at[k] < at[j]) << (LESS + 4 * k + j);
        }
    }
    return word;
}

// Whether there is a part of a face on which a coordinate is the least, and the lines that cut it, as bits.
INLINE bool code(u64 word, u32 least, u32 *lines) {
    const u32 more = (u32)(word >> (MORE + 4 * least)) & 15u, less = (u32)(word >> (LESS + 4 * least)) & 15u;
    const bool beyond = (word & 15u) != 15u;
    const bool none = (~less & (more | ((1u << least) - 1u)) & (15u ^ (1u << least))) != 0;
    *lines = more | (((u32)(word >> (NEGATIVE + least)) & 1u) << least);
    return !(beyond || none);
}

INLINE u32 count_bits(u32 lines) { return (lines & 1u) + (lines >> 1 & 1u) + (lines >> 2 & 1u) + (lines >> 3 & 1u); }

// Adds the numbers of the part of a face on which a coordinate is the least: `Task::give`, `PartBatch::compute`.
FUNCTION void add_part(const Side<3> &side, int face, int least, u32 lines, double *sums) {
    Part part = {{{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}}, 3, true};
    double potential[3];
    for (int k = 0; k < 3; ++k) potential[k] = side.at[facet_corner<3>(face, k)][least];
    for (int j = 0; j < 4; ++j) {
        if (!(lines >> j & 1u)) continue;
        double line[3];
        for (int k = 0; k < 3; ++k) {
            line[k] = j == least ? potential[k] : side.at[facet_corner<3>(face, k)][j] - potential[k];
        }
        cut(part, line);
    }
    add_integrals(part, potential, sums);
}

// Adds the forces on a face of the contactor, and their reaction: `all_faces`.
FUNCTION void add_face(const double (*contactor)[3], int of, int face, const double *covered, Side<3> &side,
                     Moment<3> &moment, Interactions<3> &found) {
    const int corners[3] = {facet_corner<3>(face, 0), facet_corner<3>(face, 1), facet_corner<3>(face, 2)};
    const double *p = contactor[corners[0]];
    double edge[3], other_edge[3], normal[3], from[3];
    minus<3>(contactor[corners[1]], p, edge);
    minus<3>(contactor[corners[2]], p, other_edge);
    cross3(edge, other_edge, normal);
    minus<3>(p, side.centroid, from);
    const double potential = covered[0], beyond = 0.5 * dot<3>(from, normal);
    const bool presses = potential != 0.0;
    side.outside += presses ? beyond * covered[3] : 0.0;
    side.inside = beyond >= 0.0 ? side.inside : 0.0;
    if (presses && 1.0 - covered[4] < NEAR) side.passing |= 1u << face;
    const double shares[3] = {potential - covered[1] - covered[2], covered[1], covered[2]};
    for (int k = 0; k < 3; ++k) {
        for (int axis = 0; axis < 3; ++axis) found.forces[of][corners[k]][axis] += normal[axis] * (-0.5 * shares[k]);
    }
    const double *one = side.at[corners[0]], *two = side.at[corners[1]], *three = side.at[corners[2]];
    for (int node = 0; node < 4; ++node) {
        const double share = shares[0] * one[node] + shares[1] * two[node] + shares[2] * three[node];
        for (int axis = 0; axis < 3; ++axis) found.forces[1 - of][node][axis] += normal[axis] * (0.5 * share);
    }
    const double size = 0.5 * square_root(dot<3>(normal, normal));
    moment.weight += size * potential;
    for (int axis = 0; axis < 3; ++axis) {
        const double on = shares[0] * p[axis] + shares[1] * contactor[corners[1]][axis] +
                          shares[2] * contactor[corners[2]][axis];
        moment.moment[axis] += size * on;
    }
}

INLINE void add_facets(const double (*contactor)[3], int of, Side<3> &side, Moment<3> &moment, Interactions<3> &found) {
    double covered[4][PART_NUMBERS];
    u32 parts = 0, lines[16];
    u64 words[4];
    for (int corner = 0; corner < 4; ++corner) words[corner] = word(side.at[corner]);
    for (int face = 0; face < 4; ++face) {
        u64 all = 0;
        for (int k = 0; k < 3; ++k) all |= words[facet_corner<3>(face, k)];
        for (int least = 0; least < 4; ++least) {
            if (code(all, (u32)least, &lines[4 * face + least])) parts |= 1u << (4 * face + least);
        }
        for (int k = 0; k < PART_NUMBERS; ++k) covered[face][k] = 0.0;
    }
    // Parts with fewer cuts come first, as in the twin.
    for (u32 cuts = 0; parts && cuts <= 4; ++cuts) {
        for (int part = 0; part < 16; ++part) {
            if (!(parts >> part & 1u) || count_bits(lines[part]) != cuts) continue;
            add_part(side, part / 4, part % 4, lines[part], covered[part / 4]);
        }
    }
    for (int face = 0; face < 4; ++face) add_face(contactor, of, face, covered[face], side, moment, found);
}

// The interactions of two elements without the energies of potentials where a facet passes near the centroid.
template <int D> FUNCTION void usual_interactions(const double (*shapes)[D + 1][D], Interactions<D> &found) {
    Moment<D> moment = {};
    found = {};
    for (int of = 0; of < 2; ++of) {
        Side<D> side;
        begin_side<D>(shapes[of], shapes[1 - of], side);
        add_facets(shapes[of], of, side, moment, found);
        end_side(side, of, found);
    }
    for (int axis = 0; axis < D; ++axis) {
        found.point[axis] = moment.weight > 0.0 ? moment.moment[axis] / moment.weight : shapes[0][0][axis];
    }
}

INLINE void facet_normal(const double (*corners)[2], int facet, double *normal) {
    double edge[2];
    minus<2>(corners[facet_corner<2>(facet, 1)], corners[facet_corner<2>(facet, 0)], edge);
    normal[0] = edge[1];
    normal[1] = -edge[0];
}

INLINE void facet_normal(const double (*corners)[3], int facet, double *normal) {
    double edge[3], other[3];
    minus<3>(corners[facet_corner<3>(facet, 1)], corners[facet_corner<3>(facet, 0)], edge);
    minus<3>(corners[facet_corner<3>(facet, 2)], corners[facet_corner<3>(facet, 0)], other);
    cross3(edge, other, normal);
    for (int axis = 0; axis < 3; ++axis) normal[axis] = 0.5 * normal[axis];
}

// The direction in which the other element is moved aside: the mean normal of its facets near the centroid.
template <int D> INLINE void aside_of(const double (*other)[D], u32 facets, double *normal) {
    for (int axis = 0; axis < D; ++axis) normal[axis] = 0.0;
    for (int facet = 0; facet <= D; ++facet) {
        if (!(facets >> facet & 1u)) continue;
        double one[D];
        facet_normal(other, facet, one);
        unit<D>(one);
        const double size = length<D>(normal);
        const double factor = size > 0.0 && dot<D>(normal, one) < -0.99 * size ? 0.0 : 1.0;
        for (int axis = 0; axis < D; ++axis) normal[axis] += one[axis] * factor;
    }
    unit<D>(normal);
}

// The energy of the potential of an element on a side, near whose centroid these facets of the other pass.
template <int D>
FUNCTION double energy_of(int side, const double (*own)[D], const double (*other)[D], u32 facets) {
    double normal[D], centroid[D], far = 0.0, aside = ASIDE;
    aside_of<D>(other, facets, normal);
    for (int axis = 0; axis < D; ++axis) centroid[axis] = 0.0;
    for (int corner = 0; corner <= D; ++corner) {
        for (int axis = 0; axis < D; ++axis) centroid[axis] += own[corner][axis] * (1.0 / (D + 1));
    }
    for (int corner = 0; corner <= D; ++corner) {
        double from[D];
        minus<D>(own[corner], centroid, from);
        const double on = dot<D>(from, normal);
        far = larger(on < 0.0 ? -on : on, far);
    }
    for (;;) {
        double energies[2];
        u32 passing = 0;
        for (int lane = 0; lane < 2; ++lane) {
            const double way = aside * far * (lane == 0 ? 1.0 : -1.0);
            double shapes[2][D + 1][D];
            Interactions<D> beside;
            for (int corner = 0; corner <= D; ++corner) {
                for (int axis = 0; axis < D; ++axis) {
                    shapes[side][corner][axis] = own[corner][axis];
                    shapes[1 - side][corner][axis] = other[corner][axis] + way * normal[axis];
                }
            }
            usual_interactions<D>(shapes, beside);
            energies[lane] = beside.energies[side];
            passing |= beside.passing[side];
        }
        if (passing == 0 || aside > 0.1) return 0.5 * (energies[0] + energies[1]);
        aside *= 2.0;
    }
}

template <int D> FUNCTION void interactions(const double (*shapes)[D + 1][D], Interactions<D> &found) {
    usual_interactions<D>(shapes, found);
    for (int side = 0; side < 2; ++side) {
        const u32 facets = found.passing[side];
        if (facets == 0) continue;
        const double(*own)[D] = shapes[side];
        const double energy = energy_of<D>(side, own, shapes[1 - side], facets);
        Matrix<D> edges;
        for (int axis = 0; axis < D; ++axis) {
            for (int k = 0; k < D; ++k) edges.a[axis][k] = own[k + 1][axis] - own[0][axis];
        }
        const Matrix<D> across = cofactor(edges);
        const double size = determinant(edges);
        double gradients[D + 1][D];
        for (int axis = 0; axis < D; ++axis) {
            for (int k = 0; k < D; ++k) gradients[k + 1][axis] = across.a[axis][k] / size;
            double sum = gradients[1][axis];
            for (int k = 1; k < D; ++k) sum += gradients[k + 1][axis];
            gradients[0][axis] = -sum;
        }
        set_energy<D>(found, side, gradients, energy);
    }
}

INLINE double clamp(double x) { return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x; }

// Square of the distance of two edges, each given by its beginning and its direction.
INLINE double between_edges(const double *p, const double *u, const double *q, const double *v) {
    double from[3], apart[3];
    minus<3>(p, q, from);
    const double uu = dot<3>(u, u), vv = dot<3>(v, v), uv = dot<3>(u, v);
    const double along_u = dot<3>(u, from), along_v = dot<3>(v, from);
    const double squared = uu * vv - uv * uv;
    const double first = squared > 1e-12 * uu * vv ? (uv * along_v - vv * along_u) / squared : 0.0;
    const double t = clamp((uv * clamp(first) + along_v) / vv);
    const double s = clamp((uv * t - along_u) / uu);
    for (int axis = 0; axis < 3; ++axis) apart[axis] = from[axis] + s * u[axis] - t * v[axis];
    return dot<3>(apart, apart);
}

// Square of the least distance of a corner from a face inside of which it has its foot; infinite without one.
FUNCTION double above_faces(const double (*corners)[3], const double (*faces)[3]) {
    double least = of_bits(0x7ff0000000000000ull);
    for (int face = 0; face < 4; ++face) {
        const double *a = faces[facet_corner<3>(face, 0)];
        double ab[3], ac[3], normal[3], from[3], one[3], two[3];
        minus<3>(faces[facet_corner<3>(face, 1)], a, ab);
        minus<3>(faces[facet_corner<3>(face, 2)], a, ac);
        cross3(ab, ac, normal);
        const double squared = dot<3>(normal, normal);
        for (int corner = 0; corner < 4; ++corner) {
            minus<3>(corners[corner], a, from);
            const double height = dot<3>(from, normal);
            if (height * height >= least * squared) continue;
            cross3(from, ac, one);
            cross3(ab, from, two);
            const double second = dot<3>(one, normal), third = dot<3>(two, normal);
            if (second >= 0.0 && third >= 0.0 && second + third <= squared) least = height * height / squared;
        }
    }
    return least;
}

// The distance of two elements that do not overlap, or a lower bound of it: `Simplex::distance` without one.
INLINE double between(const double (*)[2], const double (*)[2]) { return 0.0; }

FUNCTION double between(const double (*a)[3], const double (*b)[3]) {
    const unsigned char edges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
    double least = of_bits(0x7ff0000000000000ull);
    for (int one = 0; one < 6; ++one) {
        for (int other = 0; other < 6; ++other) {
            double u[3], v[3];
            const double *p = a[edges[one][0]], *q = b[edges[other][0]];
            minus<3>(a[edges[one][1]], p, u);
            minus<3>(b[edges[other][1]], q, v);
            least = smaller(between_edges(p, u, q, v), least);
        }
    }
    least = smaller(above_faces(a, b), least);
    least = smaller(above_faces(b, a), least);
    return larger(square_root(least), 0.0);
}

// The history of friction and damping of a contact: `Grip`.
template <int D> struct Grip {
    double friction[D];
    double damping[D];
    double shares[2][D];
    double credited_energy;
    double way;
    double push[D];
};

// Two elements that may touch, but for their history: `ContactInputs`.
template <int D> struct Contact {
    double shapes[2][D + 1][D];
    double velocities[2][D + 1][D];
    double penalty, friction, tangential, damping;
    double masses[2];
    double length, weight, fading, initial;
};

// Their forces. Works: energy, friction, damping, energy that was handed over, and energy that has relaxed.
template <int D> struct Pressed {
    double forces[2][D + 1][D];
    double energy, deep;
    double works[5];
};

template <int D> INLINE void completed(const double *rest, double *shares) {
    shares[0] = 1.0;
    for (int k = 0; k < D; ++k) {
        shares[0] -= rest[k];
        shares[k + 1] = rest[k];
    }
}

template <int D> INLINE void velocity_at(const double (*velocities)[D], const double *shares, double *velocity) {
    for (int axis = 0; axis < D; ++axis) velocity[axis] = 0.0;
    for (int corner = 0; corner <= D; ++corner) {
        for (int axis = 0; axis < D; ++axis) velocity[axis] += shares[corner] * velocities[corner][axis];
    }
}

// Works against the friction and the damping of the last step, in its second half: `Grip::second_half`.
template <int D>
INLINE void last_works(const double (*velocities)[D + 1][D], const Grip<D> &grip, double step, double *works) {
    double shares[D + 1], one[D], other[D], rate[D];
    completed<D>(grip.shares[0], shares);
    velocity_at<D>(velocities[0], shares, one);
    completed<D>(grip.shares[1], shares);
    velocity_at<D>(velocities[1], shares, other);
    minus<D>(one, other, rate);
    works[0] = -0.5 * step * dot<D>(grip.friction, rate);
    works[1] = -0.5 * step * dot<D>(grip.damping, rate);
}

// Counted part of a potential energy, and its derivative.
INLINE double count_from(double credited, double potential, double *slope) {
    const double share = credited / potential;
    const double counted = potential * (1.0 - share) * (1.0 - share), rate = 1.0 - share * share;
    const bool counts = potential > credited;
    *slope = counts ? rate : 0.0;
    return counts ? counted : 0.0;
}

INLINE double count_beyond(double credited, double potential, double *slope) {
    const double rest = 1.0 - square_root(credited / potential);
    const bool counts = potential > credited;
    *slope = counts ? rest : 0.0;
    return counts ? potential * rest * rest : 0.0;
}

// Unit vectors at right angles, of which the first is given.
INLINE void axes_around(double (*axes)[2]) {
    axes[1][0] = -axes[0][1];
    axes[1][1] = axes[0][0];
}

INLINE void axes_around(double (*axes)[3]) {
    double size[3];
    for (int axis = 0; axis < 3; ++axis) size[axis] = axes[0][axis] < 0.0 ? -axes[0][axis] : axes[0][axis];
    const bool last = size[2] < size[0] && size[2] < size[1];
    const bool middle = size[1] < size[0] && !last;
    const double from[3] = {last || middle ? 0.0 : 1.0, middle ? 1.0 : 0.0, last ? 1.0 : 0.0};
    cross3(axes[0], from, axes[1]);
    unit<3>(axes[1]);
    cross3(axes[0], axes[1], axes[2]);
}

// The energies of a contact: those that count, the slope, and the energy that is ignored from now on.
struct Counted {
    double energy, slope, relaxed, credited_energy;
};

INLINE Counted counted_of(double credited, double way, double initial, double potential, double still_ignored) {
    const bool relaxes = way >= 3.0, is_initial = way >= 2.0;
    const double ignored = smaller(credited, potential);
    const double still = relaxes ? still_ignored * credited : ignored;
    const double credited_energy = initial > 0.0 ? potential : smaller(still, potential);
    double slope, slope_before, slope_of_joint;
    const double of_bodies = count_beyond(credited_energy, potential, &slope);
    const bool goes_on = relaxes && initial == 0.0;
    const double before = count_beyond(ignored, potential, &slope_before);
    const double relaxed = goes_on ? of_bodies - before : 0.0;
    slope_before = goes_on ? slope_before : slope;
    const double of_joint = count_from(credited_energy, potential, &slope_of_joint);
    return {is_initial ? of_bodies : of_joint, is_initial ? 0.5 * (slope_before + slope) : slope_of_joint, relaxed,
            credited_energy};
}

// Computes friction and damping of a couple, and adds them to the forces of its potentials.
template <int D>
FUNCTION void grip_one(const Contact<D> &given, const Interactions<D> &found, double step, double still_ignored,
                     Grip<D> &grip, Pressed<D> &to) {
    double works[2];
    last_works<D>(given.velocities, grip, step, works);
    to.energy = found.energies[0] + found.energies[1];
    const double potential = given.penalty * to.energy, way = given.initial > 0.0 ? given.initial : grip.way;
    const Counted counted = counted_of(grip.credited_energy, way, given.initial, potential, still_ignored);
    const double scale = given.penalty * given.weight * counted.slope;
    double push[D], shares[2][D + 1], rates[2][D], rate[D], axes[D][D];
    for (int axis = 0; axis < D; ++axis) push[axis] = 0.0;
    for (int corner = 0; corner <= D; ++corner) {
        for (int axis = 0; axis < D; ++axis) push[axis] += scale * found.forces[0][corner][axis];
    }
    for (int side = 0; side < 2; ++side) {
        Coordinates<D> coordinates;
        coordinates_of(given.shapes[side], coordinates);
        coordinates_at(coordinates, found.point, shares[side]);
        velocity_at<D>(given.velocities[side], shares[side], rates[side]);
    }
    minus<D>(rates[0], rates[1], rate);
    const double size = square_root(dot<D>(push, push));
    const bool touches = size > 0.0 && to.energy > 0.0;
    const double per_size = 1.0 / size;
    for (int axis = 0; axis < D; ++axis) axes[0][axis] = per_size * push[axis];
    axes_around(axes);
    const double m = given.masses[0], n = given.masses[1];
    const double critical = 2.0 * square_root(given.penalty * given.length * m * n / (m + n));
    const double against = -given.damping * given.weight * critical * dot<D>(rate, axes[0]);
    double damping = larger(smaller(against, size), -size);
    damping = touches && given.damping > 0.0 ? damping : 0.0;
    const double slip = given.weight * given.tangential * given.length * step;
    double trial[D], along[D], friction[D], damped[D];
    trial[0] = 0.0;
    for (int k = 1; k < D; ++k) trial[k] = dot<D>(grip.friction, axes[k]) - slip * dot<D>(rate, axes[k]);
    const double tried = square_root(dot<D>(trial, trial)), limit = given.friction * (size + damping);
    const double kept = limit / tried;
    for (int axis = 0; axis < D; ++axis) along[axis] = 0.0;
    for (int k = 1; k < D; ++k) {
        const double held = tried > limit ? kept * trial[k] : trial[k];
        for (int axis = 0; axis < D; ++axis) along[axis] += axes[k][axis] * held;
    }
    for (int axis = 0; axis < D; ++axis) {
        damped[axis] = touches ? damping * axes[0][axis] : 0.0;
        friction[axis] = touches && given.friction > 0.0 ? along[axis] : 0.0;
    }
    to.works[0] = given.weight * counted.energy;
    to.works[1] = works[0] - 0.5 * step * dot<D>(friction, rate);
    to.works[2] = works[1] - 0.5 * step * dot<D>(damped, rate);
    to.works[3] = given.fading * counted.energy;
    to.works[4] = given.weight * counted.relaxed;
    to.deep = counted.slope > 0.5 ? found.deep : 0.0;
    for (int axis = 0; axis < D; ++axis) {
        const double both = friction[axis] + damped[axis];
        grip.friction[axis] = friction[axis];
        grip.damping[axis] = damped[axis];
        grip.push[axis] = push[axis] + both;
        for (int side = 0; side < 2; ++side) grip.shares[side][axis] = shares[side][axis + 1];
        for (int corner = 0; corner <= D; ++corner) {
            to.forces[0][corner][axis] = scale * found.forces[0][corner][axis] + shares[0][corner] * both;
            to.forces[1][corner][axis] = scale * found.forces[1][corner][axis] - shares[1][corner] * both;
        }
    }
    grip.credited_energy = counted.credited_energy;
    grip.way = way;
}

// Two elements that may touch, and all that their laws find. `distances`: the lower bound of their distance,
// and that of elements that do not overlap.
template <int D> struct ContactCase {
    Contact<D> given;
    Grip<D> grip;
    Pressed<D> pressed;
    double distances[2];
};

struct ContactCases {
    // A ContactCase each.
    void *cases;
    u64 count;
    double step;
    double still_ignored;
};

template <int D> INLINE void press_cases(const ContactCases &a, u32 block) {
    EACH(k, a.count) {
        ContactCase<D> &one = ((ContactCase<D> *)a.cases)[k];
        Interactions<D> found;
        one.distances[0] = apart<D>(one.given.shapes[0], one.given.shapes[1]);
        one.distances[1] = between(one.given.shapes[0], one.given.shapes[1]);
        interactions<D>(one.given.shapes, found);
        grip_one(one.given, found, a.step, a.still_ignored, one.grip, one.pressed);
    }
}

KERNEL(press_cases_2, ContactCases) { press_cases<2>(a, block); }
KERNEL(press_cases_3, ContactCases) { press_cases<3>(a, block); }

// Bits of the marks of a couple: whether it may begin to touch, and whether forces begin at zero with its
// present overlap.
const u32 MAY_BEGIN = 1, CREDITS = 2;
// A bit of the state of a couple: whether it touches. Above it is the way in which it begins.
const u32 TOUCHES = 1;
// `Overlap::Credited`.
const u32 CREDITED = 1;
// Rows of sums over couples: both parts of four works, then the number that touch and nothing.
const u32 PRESS_ROWS = 10;

struct Couples {
    const double *positions;
    const double *velocities;
    // Nodes of the corners of each element.
    const u32 *corners;
    // Elements of each couple, and its marks.
    const u32 *elements;
    const u32 *marks;
    // Columns of a number of each couple: penalty, friction, tangential stiffness, damping, two masses, length,
    // weight, fading.
    const double *laws;
    u32 *states;
    double *apart_until;
    // Columns of the numbers of a Grip.
    double *grips;
    // Forces on the corners of both elements of couples that touch.
    double *forces;
    // Of each couple.
    double *energies;
    // PRESS_ROWS of a number of each block, and the largest of `count` less the place of a deep couple.
    double *sums;
    double *mosts;
    double grains[2];
    double step;
    double travel;
    double still_ignored;
    u64 count;
    u64 blocks;
};

template <int D> INLINE void read_contact(const Couples &a, u64 couple, u32 overlap, Contact<D> &to) {
    for (int side = 0; side < 2; ++side) {
        const u32 *nodes = a.corners + (u64)a.elements[2 * couple + side] * (D + 1);
        for (int corner = 0; corner <= D; ++corner) {
            for (int axis = 0; axis < D; ++axis) {
                to.shapes[side][corner][axis] = a.positions[(u64)nodes[corner] * D + axis];
                to.velocities[side][corner][axis] = a.velocities[(u64)nodes[corner] * D + axis];
            }
        }
    }
    const double *law = a.laws + couple;
    to.penalty = law[0];
    to.friction = law[a.count];
    to.tangential = law[2 * a.count];
    to.damping = law[3 * a.count];
    for (int side = 0; side < 2; ++side) to.masses[side] = law[(4 + side) * a.count];
    to.length = law[6 * a.count];
    to.weight = law[7 * a.count];
    to.fading = law[8 * a.count];
    to.initial = (double)overlap;
}

// Computes a couple. Returns whether it touches, and whether it is too deep.
template <int D> FUNCTION bool press_couple(const Couples &a, u64 couple, double *works, bool *deep) {
    const u32 marks = a.marks[couple], state = a.states[couple];
    u32 overlap = state >> 1;
    bool touches = state & TOUCHES;
    if (!touches && (a.apart_until[couple] > a.travel || !(marks & MAY_BEGIN))) return false;
    if (marks & CREDITS && overlap < CREDITED) overlap = CREDITED;
    const int numbers = 5 * D + 2;
    Contact<D> given;
    Grip<D> grip;
    double *history = (double *)&grip, distance = 0.0;
    read_contact(a, couple, overlap, given);
    for (int k = 0; k < numbers; ++k) history[k] = touches ? a.grips[k * a.count + couple] : 0.0;
    const bool acts = given.weight > 0.0;
    if (!acts && touches) {
        last_works<D>(given.velocities, grip, a.step, works + 1);
        touches = false;
    } else if (acts && !touches) {
        distance = apart<D>(given.shapes[0], given.shapes[1]);
        touches = !(distance >= 0.0);
    }
    if (touches) {
        Interactions<D> found;
        Pressed<D> pressed;
        interactions<D>(given.shapes, found);
        grip_one(given, found, a.step, a.still_ignored, grip, pressed);
        touches = pressed.energy > 0.0;
        for (int k = 1; k < 3; ++k) works[k] = pressed.works[k];
        if (touches) {
            works[0] = pressed.works[0];
            for (int k = 3; k < 5; ++k) works[k] = pressed.works[k];
            for (int k = 0; k < numbers; ++k) a.grips[k * a.count + couple] = history[k];
            const double *forces = &pressed.forces[0][0][0];
            const u64 all = 2 * (D + 1) * D;
            for (u64 k = 0; k < all; ++k) a.forces[couple * all + k] = forces[k];
            *deep = pressed.deep > 0.0;
        } else {
            distance = between(given.shapes[0], given.shapes[1]);
        }
    }
    a.states[couple] = touches ? TOUCHES : 0;
    if (!touches) a.apart_until[couple] = a.travel + 0.499 * distance;
    return touches;
}

// Computes the couples of a block, and adds up their works: plain sums of rounded numbers, exact in any order.
template <int D> INLINE void press_couples(const Couples &a, u32 block) {
    SHARED double sums[PRESS_ROWS][THREADS];
    SHARED double mosts[THREADS];
    EACH_THREAD(t) {
        const u64 couple = (u64)block * THREADS + t;
        double works[5] = {0.0, 0.0, 0.0, 0.0, 0.0};
        bool touches = false, deep = false;
        if (couple < a.count) {
            touches = press_couple<D>(a, couple, works, &deep);
            a.energies[couple] = works[0];
        }
        for (u32 k = 0; k < 4; ++k) {
            const double large = (works[k + 1] + a.grains[0]) - a.grains[0];
            sums[2 * k][t] = large;
            sums[2 * k + 1][t] = ((works[k + 1] - large) + a.grains[1]) - a.grains[1];
        }
        sums[8][t] = touches ? 1.0 : 0.0;
        sums[9][t] = 0.0;
        mosts[t] = deep ? (double)(a.count - couple) : 0.0;
    }
    for (u32 half = THREADS / 2; half > 0; half /= 2) {
        EACH_THREAD(t) {
            if (t < half) {
                for (u32 row = 0; row < PRESS_ROWS; ++row) sums[row][t] += sums[row][t + half];
                mosts[t] = larger(mosts[t], mosts[t + half]);
            }
        }
    }
    EACH_THREAD(t) {
        if (t < PRESS_ROWS) a.sums[t * a.blocks + block] = sums[t][0];
        if (t == 0) a.mosts[block] = mosts[0];
    }
}

struct CoupleForces {
    // Elements of couples, where the couples of each begin and end, and these, as 2 × couple + side.
    const u32 *elements;
    const u32 *starts;
    const u32 *sides;
    const u32 *states;
    const double *added;
    // On the corners of all elements.
    double *forces;
    u64 count;
};

// Adds the forces of couples to those on the corners of their elements, in the order of the couples: `Touching::take`.
template <int D> INLINE void gather_couples(const CoupleForces &a, u32 block) {
    EACH(k, a.count) {
        double *forces = a.forces + (u64)a.elements[k] * (D + 1) * D;
        for (u32 place = a.starts[k]; place < a.starts[k + 1]; ++place) {
            const u32 side = a.sides[place];
            if (!(a.states[side / 2] & TOUCHES)) continue;
            const double *added = a.added + (u64)side * (D + 1) * D;
            for (int number = 0; number < (D + 1) * D; ++number) forces[number] += added[number];
        }
    }
}

KERNEL(press_couples_2, Couples) { press_couples<2>(a, block); }
KERNEL(press_couples_3, Couples) { press_couples<3>(a, block); }
KERNEL(gather_couples_2, CoupleForces) { gather_couples<2>(a, block); }
KERNEL(gather_couples_3, CoupleForces) { gather_couples<3>(a, block); }
