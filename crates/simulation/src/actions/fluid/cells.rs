//! Cells of the fluid: joints that it can enter, their shapes, and how soft the fluid in them has to be.

use fdem_distributed::wire;
use fdem_fluid::{ApertureLaw, Scheme, Shape};

use crate::action::Scene;
use crate::joints::{Joint, JointAxes};
use crate::model::{FluidOptions, Insertion, WetFrom};
use crate::simplex::Simplex;
use crate::topology::{NONE, Topology, corners_of_facet};
use crate::vector::{Matrix, Point, dot, minus};

/// A joint that fluid can enter, with the names that are the same on all ranks.
#[derive(Clone, Copy, Debug)]
pub(super) struct FluidCell<const D: usize> {
    /// Codes of its two sides. The first is that of its facet.
    pub(super) sides: [u32; 2],
    /// Numbers of its vertices in the whole mesh, as they go around side 0.
    pub(super) vertices: [u32; D],
    /// The joint set, or [`NONE`].
    set: u32,
    /// Undeformed length, m, or area, m².
    measure: f64,
    /// Growth of its aperture with the pressure, m/Pa: see the front page of the module.
    softness: f64,
    /// The gap at each end from which on the joint has no compression, m: gaps count from the beginning of
    /// the run, when initial stress presses the joint together.
    pub(super) slack: [f64; D],
}

wire!([const D: usize] FluidCell<D> { sides, vertices, set, measure, softness, slack });

/// Corners of both sides of a cell, as they go around side 0; `None` of a side whose element is not here.
pub(super) type Located<const D: usize> = [Option<[u32; D]>; 2];

/// The motion of a side of a cell, from the rank that counts its element.
#[derive(Clone, Copy, Debug)]
pub(super) struct SideMotion<const D: usize> {
    /// Place of the cell, and side.
    cell: u32,
    side: u32,
    /// Positions, m, and velocities, m/s, of its corners.
    places: [Point<D>; D],
    velocities: [Point<D>; D],
    /// Stress of its element, Pa.
    stress: Matrix<D>,
}

wire!([const D: usize] SideMotion<D> { cell, side, places, velocities, stress });

impl<const D: usize> FluidCell<D> {
    pub(super) fn key(&self) -> u64 {
        u64::from(self.sides[0])
    }

    /// The law of its aperture.
    pub(super) fn law(&self, options: &FluidOptions<D>) -> ApertureLaw {
        options.set_apertures.get(self.set as usize).copied().unwrap_or(options.aperture)
    }

    /// The corners of its sides.
    pub(super) fn located<const N: usize>(&self, topology: &Topology<D, N>) -> Located<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        self.sides.map(|code| {
            let element = topology.element(code / N as u32)?;
            let corners = corners_of_facet::<D, N>(element as usize, code as usize % N);
            let number = |corner: &u32| topology.vertex(topology.vertices[*corner as usize]);
            Some(self.vertices.map(|vertex| {
                corners.into_iter().find(|corner| number(corner) == vertex).unwrap_or(corners[0])
            }))
        })
    }

    /// Its shape. `pressure`: that of its fluid, Pa; `step`: of the solid, s.
    pub(super) fn shape<const N: usize>(
        &self,
        sides: &[SideMotion<D>; 2],
        pressure: f64,
        options: &FluidOptions<D>,
        step: f64,
    ) -> Shape<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let both = |of: &dyn Fn(&SideMotion<D>) -> [Point<D>; D], end: usize| {
            sides.each_ref().map(|side| of(side)[end])
        };
        let axes = JointAxes::of::<N>(std::array::from_fn(|end| both(&|side| side.places, end)));
        // In the middle of the time in which the pressure will be constant.
        let ahead = 0.5 * f64::from(options.steps - 1) * step;
        let mut opening = 0.0;
        for end in 0..D {
            let [gap, rate] = [both(&|side| side.places, end), both(&|side| side.velocities, end)]
                .map(|[a, b]| dot(minus(b, a), axes.axes[0]));
            opening += (gap - self.slack[end] + ahead * rate).max(0.0) / D as f64;
        }
        let effective = if opening == 0.0 { compression_of::<D, N>(sides) - pressure } else { 0.0 };
        let corners = std::array::from_fn(|end| {
            let [a, b] = both(&|side| side.places, end);
            std::array::from_fn(|axis| f64::midpoint(a[axis], b[axis]))
        });
        let law = self.law(options);
        let shape = Shape {
            corners,
            opening,
            compression: effective.max(0.0),
            compliance: self.softness,
            is_wet: true,
        };
        if effective > 0.0 && law.reference_stress.is_some() {
            // The aperture is a function of the pressure: the flow may count on its growth.
            return Shape { compliance: law.compliance(effective), ..shape };
        }
        let above = pressure - options.flow.fluid.state.lowest_pressure();
        Shape { opening: opening + self.softness * above, ..shape }
    }
}

/// Total compression across a cell, Pa, negative in tension: the mean of the two elements beside it.
fn compression_of<const D: usize, const N: usize>(sides: &[SideMotion<D>; 2]) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let across = <[[f64; D]; N]>::facet_normal(&sides[0].places);
    let square = dot(across, across);
    let tension = |side: &SideMotion<D>| dot(side.stress.map(|row| dot(row, across)), across) / square;
    let [a, b] = sides.each_ref().map(tension);
    -f64::midpoint(a, b)
}

/// Cells of the joints here that fluid can enter, besides the known ones, by their keys.
pub(super) fn new_cells<const D: usize, const N: usize>(
    known: &[FluidCell<D>],
    options: &FluidOptions<D>,
    scene: &Scene<'_, D, N>,
) -> Vec<FluidCell<D>>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let (joints, topology) = (scene.joints(), scene.topology);
    let adaptive = scene.model.fracture.insertion == Insertion::Adaptive;
    let conducts = |set: u32| options.set_apertures.get(set as usize).is_some_and(|law| law.initial > 0.0);
    let is_wet = |joint: &&Joint<D>| {
        let set = joints.set(joint.facet);
        let softens = joint.softens < f64::INFINITY || adaptive && set.is_none();
        set.is_some_and(conducts)
            || joint.open_from_start
            || !joint.holds()
            || options.wet_from == WetFrom::Insertion && softens
    };
    let cell = |joint: &Joint<D>| {
        let sides = topology.facets[joint.facet as usize].corners;
        FluidCell {
            sides: sides.map(|side| topology.code_of_side(&side)),
            vertices: sides[0].map(|corner| topology.vertex(topology.vertices[corner as usize])),
            set: joints.set(joint.facet).unwrap_or(NONE),
            measure: joint.measure,
            softness: 0.0,
            slack: joint.ends.map(|end| if joint.holds() { end.origin[0].max(0.0) } else { 0.0 }),
        }
    };
    let is_new = |cell: &FluidCell<D>| known.binary_search_by_key(&cell.key(), FluidCell::key).is_err();
    let mut cells: Vec<_> = joints.all.iter().filter(is_wet).map(cell).filter(is_new).collect();
    cells.sort_unstable_by_key(FluidCell::key);
    cells
}

/// The motion of the sides whose elements are counted here. `push`: `α p` of the liquid in the pores of an
/// element, Pa, which its effective stress is without.
pub(super) fn motion_of<const D: usize, const N: usize>(
    located: &[Located<D>],
    scene: &Scene<'_, D, N>,
    push: &dyn Fn(u32) -> f64,
) -> Vec<SideMotion<D>>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let solid = scene.solid();
    let mut motion = Vec::with_capacity(2 * located.len());
    for (cell, sides) in (0..).zip(located) {
        for (side, corners) in (0..).zip(sides) {
            let Some(corners) = corners else { continue };
            let element = corners[0] / N as u32;
            if solid.share().element(element) {
                let places = corners.map(|corner| solid.position_at(corner));
                let velocities = corners.map(|corner| solid.velocity_at(corner));
                let (mut stress, push) = (solid.stress(element as usize), push(element));
                for (axis, row) in stress.iter_mut().enumerate() {
                    row[axis] -= push;
                }
                motion.push(SideMotion { cell, side, places, velocities, stress });
            }
        }
    }
    motion
}

/// The motion of both sides of all cells. `parts`: of all ranks.
pub(super) fn sides_of<const D: usize>(
    cells: usize,
    parts: Vec<Vec<SideMotion<D>>>,
) -> Vec<[SideMotion<D>; 2]> {
    let still = SideMotion {
        cell: 0,
        side: 0,
        places: [[0.0; D]; D],
        velocities: [[0.0; D]; D],
        stress: [[0.0; D]; D],
    };
    let mut sides = vec![[still; 2]; cells];
    for motion in parts.into_iter().flatten() {
        sides[motion.cell as usize][motion.side as usize] = motion;
    }
    sides
}

/// For corners of cells that have parted and that this rank owns: their number, as 2 D × cell + 2 × end +
/// side, and the area on which fluid acts around the node, over its mass, m²/kg. `walls`: corners of the
/// walls of holes.
pub(super) fn yields<'a, const D: usize, const N: usize>(
    cells: &[FluidCell<D>],
    located: &[Located<D>],
    walls: impl Iterator<Item = &'a [u32; D]>,
    scene: &Scene<'_, D, N>,
) -> Vec<(u32, f64)>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let solid = scene.solid();
    // The node of a side that has parted from the other one at this end.
    let node = |sides: &Located<D>, side: usize, end: usize| {
        let [this, other] = [side, 1 - side].map(|side| sides[side].map(|of| solid.node_at(of[end])));
        this.filter(|_| this != other)
    };
    let each = || (0..D).flat_map(|end| [(0, end), (1, end)]);
    let mut areas = vec![0.0; solid.node_count()];
    for (cell, sides) in cells.iter().zip(located) {
        for node in each().filter_map(|(side, end)| node(sides, side, end)) {
            areas[node as usize] += cell.measure * solid.thickness / D as f64;
        }
    }
    for corners in walls {
        // Undeformed, so that it does not depend on the step in which it is computed.
        let vertices = corners.map(|corner| scene.topology.vertices[corner as usize]);
        let places = vertices.map(|vertex| scene.model.mesh.nodes[vertex as usize]);
        let part = <[[f64; D]; N]>::facet_measure(&places) * solid.thickness / D as f64;
        for corner in corners {
            areas[solid.node_at(*corner) as usize] += part;
        }
    }
    let mut yields = Vec::new();
    for (cell, sides) in (0..).zip(located) {
        for (side, end) in each() {
            let owned = sides[side].is_some_and(|corners| solid.share().corner(corners[end]));
            if let Some(node) = node(sides, side, end).filter(|_| owned) {
                let number = 2 * (D as u32 * cell + end as u32) + side as u32;
                yields.push((number, areas[node as usize] / solid.constants(node as usize).mass));
            }
        }
    }
    yields
}

/// Sets the softness of cells. `yields`: those of all ranks; `step`: of the fluid, s.
pub(super) fn soften<const D: usize>(
    cells: &mut [FluidCell<D>],
    options: &FluidOptions<D>,
    yields: impl Iterator<Item = (u32, f64)>,
    step: f64,
) {
    if options.flow.scheme == Scheme::Explicit {
        return;
    }
    let mut all = vec![0.0; 2 * D * cells.len()];
    for (number, value) in yields {
        all[number as usize] = value;
    }
    for (cell, yields) in cells.iter_mut().zip(all.chunks(2 * D)) {
        cell.softness = step * step * yields.iter().sum::<f64>() / D as f64;
    }
}
