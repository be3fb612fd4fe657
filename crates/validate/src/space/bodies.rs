//! Meshes of tetrahedra, and steps that several cases use.
//!
//! The meshes are lattices of cells that are cut into five tetrahedra each. [`jittered`] moves the nodes, so
//! that no direction is special.

use fdem_simulation::{Boundary, Load, Mesh, Model, Schedule, Simulation, Target};

use crate::models::worse;

/// A mesh of tetrahedra.
pub(crate) type Body = Mesh<3, 4>;

/// A run of tetrahedra.
pub(crate) type Run = Simulation<3, 4>;

/// A point or a vector.
pub(crate) type Point = [f64; 3];

/// Faces of a tetrahedron, counter-clockwise seen from outside.
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

/// Corners of a cell by their bits: 1 for x, 2 for y, 4 for z. The tetrahedra of cells that are odd are those
/// of even ones, mirrored, so that faces match.
const EVEN: [[usize; 4]; 5] = [[0, 1, 2, 4], [3, 2, 1, 7], [5, 1, 4, 7], [6, 4, 2, 7], [1, 2, 4, 7]];

/// A box of `cells` cells along each axis, each of five tetrahedra.
pub(crate) fn cuboid(min: Point, max: Point, cells: [usize; 3]) -> Body {
    let along = |axis: usize, k: usize| min[axis] + (max[axis] - min[axis]) * k as f64 / cells[axis] as f64;
    let places: [Vec<f64>; 3] =
        std::array::from_fn(|axis| (0..=cells[axis]).map(|k| along(axis, k)).collect());
    lattice(&places)
}

/// A box of cells between these coordinates, ascending along each axis.
pub(crate) fn lattice(places: &[Vec<f64>; 3]) -> Body {
    let [nx, ny, nz] = places.each_ref().map(|places| places.len() - 1);
    let number = |i: usize, j: usize, k: usize| ((k * (ny + 1) + j) * (nx + 1) + i) as u32;
    let mut nodes = Vec::new();
    for z in &places[2] {
        for y in &places[1] {
            nodes.extend(places[0].iter().map(|x| [*x, *y, *z]));
        }
    }
    let mut elements = Vec::new();
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                // Odd cells are mirrored along x, which also turns their tetrahedra inside out.
                let odd = (i + j + k) % 2;
                for tetrahedron in EVEN {
                    let mut element = tetrahedron.map(|corner| {
                        let corner = corner ^ odd;
                        number(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2))
                    });
                    if odd == 1 {
                        element.swap(0, 1);
                    }
                    elements.push(element);
                }
            }
        }
    }
    one_body(nodes, elements)
}

/// A mesh of one body and one material. Tetrahedra that are inside out are turned.
pub(super) fn one_body(nodes: Vec<Point>, mut elements: Vec<[u32; 4]>) -> Body {
    for element in &mut elements {
        if volume(element.map(|node| nodes[node as usize])) < 0.0 {
            element.swap(0, 1);
        }
    }
    let count = elements.len();
    Mesh { nodes, elements, bodies: vec![0; count], materials: vec![0; count] }
}

/// Volume of a tetrahedron.
pub(super) fn volume([a, b, c, d]: [Point; 4]) -> f64 {
    dot(minus(b, a), cross(minus(c, a), minus(d, a))) / 6.0
}

/// Volume of a mesh.
pub(super) fn volume_of(mesh: &Body) -> f64 {
    mesh.elements.iter().map(|nodes| volume(nodes.map(|node| mesh.nodes[node as usize]))).sum()
}

/// The mesh with its nodes moved by `by` at most along each axis, except along the axes that `fixed` names
/// for a place.
pub(super) fn jittered(mesh: &Body, by: f64, seed: u64, fixed: impl Fn(Point) -> [bool; 3]) -> Body {
    let mut random = Random(seed);
    mapped(mesh, |place| {
        let held = fixed(place);
        std::array::from_fn(|axis| {
            let shift = by * random.between(-1.0, 1.0);
            if held[axis] { place[axis] } else { place[axis] + shift }
        })
    })
}

/// Axes across the sides of a box on which a place lies.
pub(super) fn on_box(min: Point, max: Point) -> impl Fn(Point) -> [bool; 3] {
    move |place| {
        std::array::from_fn(|axis| {
            let near = 1e-9 * (max[axis] - min[axis]);
            (place[axis] - min[axis]).abs() < near || (place[axis] - max[axis]).abs() < near
        })
    }
}

/// The mesh with its nodes at other places.
pub(super) fn mapped(mesh: &Body, map: impl FnMut(Point) -> Point) -> Body {
    Mesh { nodes: mesh.nodes.iter().copied().map(map).collect(), ..mesh.clone() }
}

/// Centroid of an undeformed element.
pub(super) fn centroid(mesh: &Body, element: usize) -> Point {
    let corners = mesh.elements[element].map(|node| mesh.nodes[node as usize]);
    std::array::from_fn(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 4.0)
}

/// Faces of elements, all of whose nodes are where `at` holds.
pub(crate) fn faces_where(mesh: &Body, at: impl Fn(Point) -> bool) -> Vec<[u32; 3]> {
    let all = mesh.elements.iter().flat_map(|nodes| FACES.map(|face| face.map(|corner| nodes[corner])));
    all.filter(|face| face.iter().all(|&node| at(mesh.nodes[node as usize]))).collect()
}

/// A rotation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn([Point; 3]);

impl Turn {
    /// The rotation about an axis, by an angle.
    pub(super) fn about(axis: Point, angle: f64) -> Self {
        let long = length(axis);
        let n = axis.map(|x| x / long);
        let (sin, cos) = angle.sin_cos();
        let across = [[0.0, -n[2], n[1]], [n[2], 0.0, -n[0]], [-n[1], n[0], 0.0]];
        Self(std::array::from_fn(|i| {
            std::array::from_fn(|k| {
                let one = if i == k { cos } else { 0.0 };
                one + sin * across[i][k] + (1.0 - cos) * n[i] * n[k]
            })
        }))
    }

    /// A rotation at random: about any axis, by any angle.
    pub(super) fn any(random: &mut Random) -> Self {
        loop {
            let axis: Point = std::array::from_fn(|_| random.between(-1.0, 1.0));
            if (0.1..1.0).contains(&length(axis)) {
                return Self::about(axis, random.between(0.0, std::f64::consts::TAU));
            }
        }
    }

    /// The vector, turned.
    pub(super) fn of(&self, vector: Point) -> Point {
        self.0.map(|row| dot(row, vector))
    }
}

/// The mesh turned about the origin, then moved.
pub(super) fn turned(mesh: &Body, turn: &Turn, shift: Point) -> Body {
    mapped(mesh, |place| plus(turn.of(place), shift))
}

/// Numbers from a fixed pseudo-random sequence (`SplitMix64`).
#[derive(Clone, Debug)]
pub(super) struct Random(pub(super) u64);

impl Random {
    /// The next number between two others.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        low + (high - low) * (bits >> 11) as f64 / (1_u64 << 53) as f64
    }
}

pub(super) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn plus(a: Point, b: Point) -> Point {
    std::array::from_fn(|axis| a[axis] + b[axis])
}

pub(super) fn minus(a: Point, b: Point) -> Point {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

pub(super) fn length(vector: Point) -> f64 {
    dot(vector, vector).sqrt()
}

/// A pressure or traction on faces.
pub(super) fn loaded(name: &str, faces: Vec<[u32; 3]>, load: Load<3>, schedule: Schedule) -> Boundary<3> {
    Boundary { name: name.to_owned(), target: Target::Facets(faces), load, schedule }
}

/// A run on one thread, at its beginning.
pub(crate) fn start(model: Model<3, 4>) -> Result<Run, String> {
    Simulation::new(model, 1).map_err(|error| error.to_string())
}

/// Advances a run by `steps` steps.
pub(super) fn advance(run: &mut Run, steps: u64) -> Result<(), String> {
    run.advance(steps).map_err(|error| error.to_string())
}

/// Advances a run to a time, s.
pub(crate) fn advance_to(run: &mut Run, time: f64) -> Result<(), String> {
    let steps = ((time - run.time()) / run.time_step()).ceil().max(0.0) as u64;
    advance(run, steps)
}

/// Force of a boundary on the bodies, N.
pub(super) fn force(run: &Run, boundary: usize) -> Result<Point, String> {
    run.force(boundary).ok_or_else(|| format!("there is no boundary {boundary}"))
}

/// Mean displacement, m, and mean velocity, m/s, of nodes of the mesh.
pub(super) fn mean_motion(run: &Run, nodes: &[u32]) -> [Point; 2] {
    let mut sum = [[0.0; 3]; 2];
    for (moved, velocity) in nodes.iter().filter_map(|&node| run.node(node)) {
        sum = [plus(sum[0], moved), plus(sum[1], velocity)];
    }
    sum.map(|vector| vector.map(|x| x / nodes.len() as f64))
}

/// Linear momentum, and angular momentum about the origin.
pub(super) fn momentum(run: &Run) -> [Point; 2] {
    let snapshot = run.snapshot();
    let model = run.model();
    let mesh = &model.mesh;
    let mut sum = [[0.0; 3]; 2];
    for (element, nodes) in snapshot.elements.iter().enumerate() {
        let size = volume(mesh.elements[element].map(|node| mesh.nodes[node as usize]));
        let mass = model.materials[mesh.materials[element] as usize].density * size / 4.0;
        for &node in nodes {
            let (place, velocity) = (snapshot.positions[node as usize], snapshot.velocities[node as usize]);
            let own = velocity.map(|v| mass * v);
            sum = [plus(sum[0], own), plus(sum[1], cross(place, own))];
        }
    }
    sum
}

/// Largest change of a component of the linear momentum over `scale`, and of the angular momentum over
/// `scale` times `arm`, m.
pub(super) fn change(before: &[Point; 2], after: &[Point; 2], scale: f64, arm: f64) -> f64 {
    let mut most = 0.0;
    for axis in 0..3 {
        most = worse((after[0][axis] - before[0][axis]) / scale, most);
        most = worse((after[1][axis] - before[1][axis]) / (scale * arm), most);
    }
    most
}
