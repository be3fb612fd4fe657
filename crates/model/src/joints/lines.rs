//! The lines and polygons of joint sets: those of a list or a file. The lines that statistics give, and
//! bodies in the plane with joints.

use fdem_mesh::triangles::{OutlineError, Triangles, add_lines, lengths_inside, triangles};
use fdem_mesh::{Corners, Grading};
use fdem_scenes::random::Random;

use crate::joints::off_body;
use crate::joints::polygons::{self, SpacePolygon};
use crate::joints::polylines;
use crate::shapes::outline::{Domain, Point};
use crate::shapes::piece::{JointFacet, LinesInBody, Piece};
use crate::shapes::placed::{fits, may_fit_body};
use crate::text::document::{Document, Table};
use crate::text::fault::{Fault, Problem, suggestion};
use crate::text::file::{Body, JointSet, ModelFile, Vector};
use crate::text::included::Load;

/// Lines of a statistical set in one body, at most.
const MOST: f64 = 1e5;

/// A line by its two ends, m.
type Line = [Point; 2];

/// The lines and polygons of all joint sets, in the order of the file; none for statistical sets, whose
/// joints follow from the place of a body.
pub(crate) struct JointLines<'f> {
    sets: Vec<(&'f JointSet, Vec<Line>)>,
    /// For each set, whether its joints are between groups of mesh files.
    between_groups: Vec<bool>,
    /// Length of the unit of the file of each set, m; `None` for sets that are not from files.
    scales: Vec<Option<f64>>,
    /// Polygons of each set.
    pub(crate) polygons: Vec<(&'f JointSet, Vec<SpacePolygon>)>,
    /// Notes on the files of all sets.
    pub(crate) notes: Vec<String>,
}

/// A line in a body.
struct Trace {
    set: u32,
    ends: Line,
}

impl<'f> JointLines<'f> {
    /// Reads the files that joint sets name: polygons in three dimensions, lines in two.
    pub(crate) fn of(
        dimensions: usize,
        file: &'f ModelFile,
        document: &Document<'_>,
        load: &mut Load<'_>,
        faults: &mut Vec<Fault>,
    ) -> Self {
        let (mut sets, mut in_space, mut notes) = (Vec::new(), Vec::new(), Vec::new());
        let mut scales = vec![None; file.joint_set.len()];
        for (index, set) in file.joint_set.iter().enumerate() {
            let given = set.lines.iter().flatten().filter_map(|numbers| polylines::points(numbers));
            let chains = given
                .flat_map(|chain| chain.windows(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<Line>>());
            let mut lines: Vec<Line> = chains.collect();
            let corners = set.polygons.iter().flatten().filter_map(|numbers| polygons::corners(numbers));
            let mut polygons: Vec<SpacePolygon> = corners.collect();
            if let Some(name) = &set.file {
                let read = load(name).map_err(|why| format!("cannot read {name}: {why}"));
                let read = read.and_then(|bytes| {
                    let notes_of_file = if dimensions == 2 {
                        let read = polylines::read(&bytes, name, set.scale)?;
                        lines.extend(read.all);
                        scales[index] = Some(read.scale);
                        read.notes
                    } else {
                        let read = polygons::read(&bytes, name, set.scale)?;
                        polygons.extend(read.all);
                        scales[index] = Some(read.scale);
                        read.notes
                    };
                    let noted = |note| format!("[[joint_set]] \"{}\": {note}", set.name);
                    notes.extend(notes_of_file.into_iter().map(noted));
                    Ok(())
                });
                if let Err(message) = read {
                    faults.push(
                        Fault::at(
                            document.value(Table::of("joint_set", index), "file"),
                            format!("[[joint_set]] \"{}\": {message}", set.name),
                        )
                        .label("this file"),
                    );
                }
            }
            sets.push((set, lines));
            in_space.push((set, polygons));
        }
        let between_groups = file.joint_set.iter().map(|set| is_between_groups(set, file)).collect();
        Self { sets, scales, between_groups, polygons: in_space, notes }
    }

    /// Advice for a set, by its number, that has no joints in the bodies with these nodes.
    pub(crate) fn advice<const D: usize>(
        &self,
        set: usize,
        nodes: impl Iterator<Item = [f64; D]>,
    ) -> Option<String> {
        let of_lines = self.sets[set].1.iter().flatten().map(|end| end.to_vec());
        let of_polygons = self.polygons[set].1.iter().flatten().map(|corner| corner.to_vec());
        let shapes = off_body::around(of_lines.chain(of_polygons))?;
        let bodies = off_body::around(nodes.map(|node| node.to_vec()))?;
        off_body::advice(&shapes, &bodies, self.scales[set])
    }

    /// The lines in a body, in the coordinates in which it is meshed.
    fn in_body(&self, body: &Body, domain: &Domain) -> Result<Vec<Trace>, Problem> {
        let placed = FlatPlacing::of(body, domain);
        let [low, high] = placed.bounds;
        let mut traces = Vec::new();
        for (number, (set, lines)) in (0..).zip(&self.sets) {
            if !has_joints(set, body) {
                continue;
            }
            let found = joints_of((set, body), lines, MOST, |dip, spacing| {
                statistical(set, dip, spacing, placed.bounds)
            })?;
            let beyond = |ends: &Line| {
                (0..2).any(|axis| {
                    ends.iter().all(|end| end[axis] < low[axis])
                        || ends.iter().all(|end| end[axis] > high[axis])
                })
            };
            let inside = found.into_iter().filter(|ends| !beyond(ends));
            traces.extend(inside.map(|ends| Trace { set: number, ends: ends.map(|end| placed.back(end)) }));
        }
        Ok(traces)
    }

    /// The joints in a body with a mesh from a file: the facets of the groups that joint sets name.
    ///
    /// # Errors
    /// A set that names the body and a group that is not there; a group without a facet between two elements;
    /// a facet in two sets.
    pub(crate) fn of_groups<const D: usize, const N: usize>(
        &self,
        body: &Body,
        piece: &Piece<D, N>,
    ) -> Result<Vec<JointFacet<D>>, Problem>
    where
        [[f64; D]; N]: Corners<D, N>,
    {
        let mut joints: Vec<JointFacet<D>> = Vec::new();
        let facet = if D == 2 { "edge" } else { "face" };
        for (number, (set, _)) in (0..).zip(&self.sets) {
            let problem =
                |message: String| Problem::new("mesh", format!("[[joint_set]] \"{}\": {message}", set.name));
            let twice = |inner: &[[u32; D]], joints: &[JointFacet<D>]| {
                let other = joints.iter().find(|joint| inner.binary_search(&joint.facet).is_ok())?;
                let other = &self.sets[other.set as usize].0.name;
                Some(problem(format!("it has {facet}s of the [[joint_set]] \"{other}\"")))
            };
            if let Some([one, other]) = set.between.as_deref()
                && self.between_groups[number as usize]
            {
                let inner = piece.facets_between(|name| fits(one, name), |name| fits(other, name));
                if let Some(problem) = twice(&inner, &joints) {
                    return Err(problem);
                }
                joints.extend(inner.into_iter().map(|facet| JointFacet {
                    facet,
                    set: number,
                    trace: number,
                }));
                continue;
            }
            let Some(name) = set.group.as_ref().filter(|_| may_have_group(set, body)) else { continue };
            let Some(group) = piece.groups.get(name) else {
                if set.bodies.is_none() {
                    continue;
                }
                let known: Vec<&str> = piece.groups.keys().map(String::as_str).collect();
                return Err(Problem {
                    help: Some(suggestion(name, &known, "group")),
                    ..problem(format!("the body \"{}\" has no group \"{name}\"", body.name))
                });
            };
            let inner = piece.inner_facets_of(group);
            if inner.is_empty() {
                return Err(Problem {
                    help: Some(format!(
                        "mark the {facet}s inside the body: in Gmsh embed the curve or surface and give it a physical group, in Abaqus make a *SURFACE of them"
                    )),
                    ..problem(format!("the group \"{name}\" has no {facet} between two elements"))
                });
            }
            if let Some(problem) = twice(&inner, &joints) {
                return Err(problem);
            }
            joints.extend(inner.into_iter().map(|facet| JointFacet { facet, set: number, trace: number }));
        }
        Ok(joints)
    }

    /// Meshes a domain of a body with the joints in it. Returns also the lines of each set in the body.
    /// `refused`: an error of the mesher as a problem.
    pub(crate) fn meshed(
        &self,
        body: &Body,
        domain: &Domain,
        size: &Grading<2>,
        seed: u64,
        refused: impl Fn(&OutlineError) -> Problem,
    ) -> Result<(Triangles, Vec<JointFacet>, Vec<LinesInBody>), Problem> {
        let traces = if self.sets.is_empty() { Vec::new() } else { self.in_body(body, domain)? };
        if traces.is_empty() {
            return triangles(domain, size, seed)
                .map(|mesh| (mesh, Vec::new(), Vec::new()))
                .map_err(|error| refused(&error));
        }
        let (before, mut domain) = (domain, domain.clone());
        let lines: Vec<Line> = traces.iter().map(|trace| trace.ends).collect();
        let name = |trace: usize| traces.get(trace).map_or("", |trace| &self.sets[trace.set as usize].0.name);
        let close = |[a, b]: [usize; 2], place: Point| Problem {
            help: Some("take a smaller mesh_size, or move one of them".to_owned()),
            ..Problem::new(
                "mesh_size",
                format!(
                    "[[body]] \"{}\": joints of \"{}\" and \"{}\" are too close to each other for the mesh size near {place:?}",
                    body.name,
                    name(a),
                    name(b)
                ),
            )
        };
        let parts =
            add_lines(&mut domain, &lines, size).map_err(|tangled| close(tangled.lines, tangled.place))?;
        let mesh = triangles(&domain, size, seed).map_err(|error| match error {
            OutlineError::Crossing { place } | OutlineError::Twice { place } => {
                let (first, second) = nearest(&lines, place);
                close([first, second], place)
            }
            error => refused(&error),
        })?;
        let edges = mesh.lines.iter().zip(&mesh.line_of);
        let joints = edges.filter_map(|(&facet, &line)| {
            let trace = parts.get(line as usize).copied().flatten()?;
            Some(JointFacet { facet, set: traces[trace].set, trace: trace as u32 })
        });
        let joints: Vec<JointFacet> = joints.collect();
        let lines = self.lines_in(before, &traces, (&mesh, &joints), size);
        Ok((mesh, joints, lines))
    }

    /// The lines of each set in a domain, and how many of them the mesh does not have, because they are too
    /// near to an outline or to other lines.
    fn lines_in(
        &self,
        domain: &Domain,
        traces: &[Trace],
        (mesh, joints): (&Triangles, &[JointFacet]),
        size: &Grading<2>,
    ) -> Vec<LinesInBody> {
        let mut left = vec![0.0; traces.len()];
        for joint in joints {
            let [a, b] = joint.facet.map(|node| mesh.nodes[node as usize]);
            left[joint.trace as usize] += (a[0] - b[0]).hypot(a[1] - b[1]);
        }
        let mut all = Vec::new();
        for (number, (set, _)) in (0..).zip(&self.sets) {
            let of_set: Vec<usize> = (0..traces.len()).filter(|&trace| traces[trace].set == number).collect();
            let ends: Vec<Line> = of_set.iter().map(|&trace| traces[trace].ends).collect();
            // Lines of statistics lie along outlines by chance, and where bodies begin: those are no joints.
            let inside = lengths_inside(domain, &ends, set.dip.is_none());
            let mut lines =
                LinesInBody { set: number, length: inside.iter().sum(), vanished: 0, vanished_length: 0.0 };
            for ((&trace, ends), inside) in of_set.iter().zip(&ends).zip(inside) {
                let middle = [0, 1].map(|axis| f64::midpoint(ends[0][axis], ends[1][axis]));
                let gone = inside - left[trace];
                // The ends of other lines are moved by less than an element.
                if inside > 0.0 && (left[trace] == 0.0 || gone > size.at(middle)) {
                    lines.vanished += 1;
                    lines.vanished_length += gone;
                }
            }
            if !of_set.is_empty() {
                all.push(lines);
            }
        }
        all
    }
}

/// The joints of a set in a body: the given ones, or those that `make` makes with a dip and a spacing. It
/// returns `None` for more than `most`.
pub(crate) fn joints_of<T: Clone>(
    (set, body): (&JointSet, &Body),
    given: &[T],
    most: f64,
    make: impl FnOnce(f64, f64) -> Option<Vec<T>>,
) -> Result<Vec<T>, Problem> {
    let (Some(dip), Some(spacing)) = (set.dip, set.spacing) else { return Ok(given.to_vec()) };
    make(dip, spacing).ok_or_else(|| {
        let message = format!(
            "the joints of the [[joint_set]] \"{}\" are more than {most} in the body \"{}\"",
            set.name, body.name
        );
        let help = "take a larger spacing or trace_length";
        Problem { help: Some(help.to_owned()), ..Problem::new("mesh_size", message) }
    })
}

/// Whether a body has the joints of a set.
pub(crate) fn has_joints(set: &JointSet, body: &Body) -> bool {
    set.between.is_none() && set.group.is_none() && body.mesh.is_none() && is_named(set, body)
}

/// Whether joints of a set may be a group of the mesh file of a body.
pub(crate) fn may_have_group(set: &JointSet, body: &Body) -> bool {
    set.group.is_some() && body.mesh.is_some() && is_named(set, body)
}

/// Whether the joints of a set are between groups of mesh files: `between` names no bodies, and there are
/// mesh files.
pub(crate) fn is_between_groups(set: &JointSet, file: &ModelFile) -> bool {
    let names_body = |name: &String| may_fit_body(file, name);
    set.between.as_ref().is_some_and(|names| !names.iter().any(names_body))
        && file.body.iter().any(|body| body.mesh.is_some())
}

fn is_named(set: &JointSet, body: &Body) -> bool {
    set.bodies.as_ref().is_none_or(|bodies| bodies.contains(&body.name))
}

/// The two lines nearest to a place.
fn nearest(lines: &[Line], place: Point) -> (usize, usize) {
    let gap = |[a, b]: Line| {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let square = dx * dx + dy * dy;
        let t = ((place[0] - a[0]) * dx + (place[1] - a[1]) * dy) / if square > 0.0 { square } else { 1.0 };
        let t = t.clamp(0.0, 1.0);
        (a[0] + t * dx - place[0]).hypot(a[1] + t * dy - place[1])
    };
    let mut order: Vec<usize> = (0..lines.len()).collect();
    order.sort_by(|&a, &b| gap(lines[a]).total_cmp(&gap(lines[b])));
    (order[0], order.get(1).copied().unwrap_or(order[0]))
}

/// Rotation and translation of a body after it is meshed.
struct FlatPlacing {
    middle: Point,
    /// Cosine and sine.
    turn: [f64; 2],
    by: Point,
    /// Lower and upper corner of the bounding box of the body in the model, m.
    bounds: [Point; 2],
}

impl FlatPlacing {
    fn of(body: &Body, domain: &Domain) -> Self {
        let [low, high] = domain.bounds();
        let middle = [0, 1].map(|axis| f64::midpoint(low[axis], high[axis]));
        let (sine, cosine) =
            if body.angle == 0.0 { (0.0, 1.0) } else { libm::sincos(body.angle.to_radians()) };
        let by = body.translate.as_ref().map_or([0.0; 2], crate::text::file::Vector::components);
        let mut placed = Self { middle, turn: [cosine, sine], by, bounds: [low, high] };
        let corners = domain.loops.iter().flatten().map(|&corner| placed.forth(corner));
        placed.bounds = fdem_mesh::bounds(corners);
        placed
    }

    /// From the mesh to the model.
    fn forth(&self, point: Point) -> Point {
        let [x, y] = [0, 1].map(|axis| point[axis] - self.middle[axis]);
        let [cosine, sine] = self.turn;
        [
            self.middle[0] + cosine * x - sine * y + self.by[0],
            self.middle[1] + sine * x + cosine * y + self.by[1],
        ]
    }

    /// From the model to the mesh.
    fn back(&self, point: Point) -> Point {
        // Points of bodies that are neither turned nor moved stay unchanged.
        if self.turn == [1.0, 0.0] {
            return [0, 1].map(|axis| point[axis] - self.by[axis]);
        }
        let [x, y] = [0, 1].map(|axis| point[axis] - self.by[axis] - self.middle[axis]);
        let [cosine, sine] = self.turn;
        [self.middle[0] + cosine * x + sine * y, self.middle[1] - sine * x + cosine * y]
    }
}

/// The lines of a statistical set within a box, and some beyond it; `None` if they are too many.
///
/// Joints lie on parallel lines, which are numbered from the origin, and along each line on places that are
/// numbered from it. Each joint number has separate random numbers, so that the joints do not depend on the
/// place of the box, and the joints of neighbouring bodies continue each other.
fn statistical(set: &JointSet, dip: f64, spacing: f64, [low, high]: [Point; 2]) -> Option<Vec<Line>> {
    let seed = set.seed.unwrap_or(1);
    let origin: Point = set.origin.as_ref().map_or([0.0; 2], Vector::components);
    let persistence = set.persistence.unwrap_or(1.0);
    let [turned, shifted, longer] =
        [set.dip_deviation, set.spacing_deviation, set.trace_deviation].map(Option::unwrap_or_default);
    let (sine, cosine) = libm::sincos(dip.to_radians());
    let corners = [low, [high[0], low[1]], high, [low[0], high[1]]].map(|corner| {
        let [x, y] = [0, 1].map(|axis| corner[axis] - origin[axis]);
        [cosine * x + sine * y, cosine * y - sine * x]
    });
    let [least, most] = fdem_mesh::bounds(corners.into_iter());
    let length = set.trace_length.filter(|_| persistence < 1.0);
    // A joint reaches this far along from where it is turned, and so far across.
    let reach = length.map_or(least[0].abs().max(most[0].abs()) * 1.5, |length| 0.5 * (length + longer));
    let across = shifted + reach * libm::tan(turned.to_radians());
    let rows = [((least[1] - across) / spacing).floor(), ((most[1] + across) / spacing).ceil()];
    let period = length.map(|length| length / persistence);
    let places = period.map_or(1.0, |period| (most[0] - least[0] + 2.0 * reach) / period + 2.0);
    let all = (rows[1] - rows[0] + 1.0) * places;
    // An origin or a length beyond the range of numbers gives a number that is none.
    if all.is_nan() || all > MOST {
        return None;
    }
    let mut lines = Vec::new();
    for row in rows[0] as i64..=rows[1] as i64 {
        let own = seed.wrapping_add((row as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut random = Random::with_stream(own, 0);
        let phase = random.uniform();
        let mut add = |middle: f64, half: f64, random: &mut Random| {
            let height = row as f64 * spacing + shifted * random.between(-1.0, 1.0);
            let (s, c) = libm::sincos((dip + turned * random.between(-1.0, 1.0)).to_radians());
            let at = [0, 1]
                .map(|axis| origin[axis] + [cosine, sine][axis] * middle + [-sine, cosine][axis] * height);
            lines.push([-half, half].map(|along| [at[0] + c * along, at[1] + s * along]));
        };
        match (length, period) {
            (Some(length), Some(period)) => {
                let first = ((least[0] - reach) / period - phase).floor() as i64 - 1;
                let last = ((most[0] + reach) / period - phase).ceil() as i64 + 1;
                for place in first..=last {
                    // Odd for places before the origin, even for others; 0 is taken.
                    let stream = if place < 0 { 2 * place.unsigned_abs() + 1 } else { 2 * place as u64 + 2 };
                    let mut random = Random::with_stream(own, stream);
                    let half = 0.5 * (length + longer * random.between(-1.0, 1.0));
                    add((place as f64 + phase) * period, half, &mut random);
                }
            }
            _ => add(0.0, reach + spacing.min(reach), &mut random),
        }
    }
    Some(lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(keys: &str) -> JointSet {
        toml::from_str(&format!("name = \"a\"\nfriction_angle = 30\n{keys}")).expect("a set")
    }

    fn lines(keys: &str, bounds: [Point; 2]) -> Vec<Line> {
        let set = set(keys);
        statistical(&set, set.dip.expect("a dip"), set.spacing.expect("a spacing"), bounds).expect("few")
    }

    /// Length of the part of a line in a box.
    fn within([a, b]: Line, [low, high]: [Point; 2]) -> f64 {
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let step = b[axis] - a[axis];
            let ends = [low[axis], high[axis]].map(|limit| (limit - a[axis]) / step);
            if step.abs() > 1e-12 {
                (from, to) = (from.max(ends[0].min(ends[1])), to.min(ends[0].max(ends[1])));
            } else if a[axis] < low[axis] || a[axis] > high[axis] {
                return 0.0;
            }
        }
        (to - from).max(0.0) * (a[0] - b[0]).hypot(a[1] - b[1])
    }

    /// The length of joints in an area is persistence over spacing times the area.
    #[test]
    fn a_set_has_its_spacing_and_persistence() {
        let bounds = [[3.0, -2.0], [43.0, 28.0]];
        for (more, persistence) in [
            ("", 1.0),
            ("persistence = 0.6\ntrace_length = 3", 0.6),
            (
                "persistence = 0.3\ntrace_length = 2\ntrace_deviation = 1\nspacing_deviation = 0.1\ndip_deviation = 5",
                0.3,
            ),
        ] {
            for dip in [0.0, 35.0, -70.0, 90.0] {
                let lines = lines(&format!("dip = {dip}\nspacing = 0.5\n{more}"), bounds);
                let length: f64 = lines.iter().map(|&line| within(line, bounds)).sum();
                let expected = persistence / 0.5 * 1200.0;
                assert!((length / expected - 1.0).abs() < 0.05, "{dip} {more}: {length} {expected}");
            }
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_joints_wherever_they_are_asked_for() {
        let keys = "dip = 35\nspacing = 0.5\npersistence = 0.5\ntrace_length = 2\ntrace_deviation = 0.5\nspacing_deviation = 0.1\ndip_deviation = 10";
        let inside = |box_: [Point; 2], keys: &str| {
            let small = [[4.0, 4.0], [6.0, 6.0]];
            let mut all: Vec<String> = lines(keys, box_)
                .iter()
                .filter(|&&line| within(line, small) > 0.0)
                .map(|line| format!("{line:?}"))
                .collect();
            all.sort();
            all
        };
        let one = inside([[0.0, 0.0], [10.0, 10.0]], keys);
        assert!(one.len() > 1);
        assert_eq!(one, inside([[4.0, 3.0], [30.0, 7.0]], keys));
        assert_ne!(one, inside([[0.0, 0.0], [10.0, 10.0]], &format!("{keys}\nseed = 2")));
    }
}
