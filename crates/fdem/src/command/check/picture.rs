//! `fdem check --picture` draws a model before its run.

use std::collections::BTreeMap;
use std::path::Path;

use fdem_mesh::Corners;
use fdem_model::{AnyPrepared, Prepared, PreparedStage, Quantity};
use fdem_results::picture::PictureError;
use fdem_results::{BodyGroup, ModelDrawing, ModelMark, ModelPoint};
use fdem_simulation::{MaterialPoint, Mesh, Probe, Target};

use crate::command::args::has_extension;

/// Most bodies of which each has a row of the legend; of more, the pieces of a packing have one together.
const MOST_BODIES: usize = 12;

/// The picture of a model, in the format of its file: PNG or SVG. `name`: that of the model file. `width`: of
/// a PNG, pixels.
pub(super) fn draw(
    prepared: &AnyPrepared,
    name: &str,
    file: &Path,
    width: Option<u32>,
) -> Result<Vec<u8>, PictureError> {
    let is_png = has_extension(file, "png");
    match prepared {
        AnyPrepared::Plane(prepared) => {
            let parts = PictureParts::of(prepared, name);
            let drawing = parts.drawing(&prepared.model.mesh);
            if is_png { drawing.png(width) } else { drawing.svg().map(String::into_bytes) }
        }
        AnyPrepared::Space(prepared) => {
            let parts = PictureParts::of(prepared, name);
            let drawing = parts.drawing(&prepared.model.mesh);
            if is_png { drawing.png(width) } else { drawing.svg().map(String::into_bytes) }
        }
    }
}

/// The parts of a picture besides the mesh.
struct PictureParts<const D: usize> {
    title: String,
    bodies: Vec<BodyGroup>,
    joints: Vec<ModelMark<D>>,
    boundaries: Vec<ModelMark<D>>,
    points: Vec<ModelPoint<D>>,
    stages: Vec<String>,
}

impl<const D: usize> PictureParts<D> {
    fn of<const N: usize>(prepared: &Prepared<D, N>, name: &str) -> Self
    where
        [[f64; D]; N]: Corners<D, N>,
    {
        let boundaries = prepared.model.boundaries.iter().map(|boundary| match &boundary.target {
            Target::Nodes(nodes) => {
                let mut nodes = nodes.clone();
                nodes.sort_unstable();
                ModelMark { name: boundary.name.clone(), facets: Vec::new(), nodes }
            }
            Target::Facets(facets) | Target::Held(facets, _) => {
                ModelMark { name: boundary.name.clone(), facets: facets.clone(), nodes: Vec::new() }
            }
        });
        Self {
            title: if prepared.title.is_empty() { file_name(name) } else { prepared.title.clone() },
            bodies: groups(prepared),
            joints: joints(prepared),
            boundaries: boundaries.collect(),
            points: points(prepared),
            stages: stages(prepared),
        }
    }

    fn drawing<'a, const N: usize>(&'a self, mesh: &'a Mesh<D, N>) -> ModelDrawing<'a, D, N> {
        let Self { title, bodies, joints, boundaries, points, stages } = self;
        ModelDrawing { title, mesh, bodies, joints, boundaries, points, notes: stages }
    }
}

/// The name of a file without its folder.
fn file_name(name: &str) -> String {
    Path::new(name).file_name().map_or_else(|| name.to_owned(), |file| file.to_string_lossy().into_owned())
}

/// Bodies with one colour and one row of the legend.
fn groups<const D: usize, const N: usize>(prepared: &Prepared<D, N>) -> Vec<BodyGroup> {
    let pieces = prepared.bodies.len() > MOST_BODIES;
    let mut groups: Vec<BodyGroup> = Vec::new();
    let mut places: BTreeMap<&str, usize> = BTreeMap::new();
    for (number, body) in (0..).zip(&prepared.bodies) {
        let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        let name = match body.name.rsplit_once('-') {
            Some((packing, piece)) if pieces && is_number(piece) => packing,
            _ => &body.name,
        };
        let place = *places.entry(name).or_insert_with(|| {
            groups.push(BodyGroup { name: name.to_owned(), bodies: Vec::new() });
            groups.len() - 1
        });
        groups[place].bodies.push(number);
    }
    for group in groups.iter_mut().filter(|group| group.bodies.len() > 1) {
        group.name = format!("{}: {} bodies", group.name, group.bodies.len());
    }
    groups
}

/// The joint sets with their facets.
fn joints<const D: usize, const N: usize>(prepared: &Prepared<D, N>) -> Vec<ModelMark<D>>
where
    [[f64; D]; N]: Corners<D, N>,
{
    let model = &prepared.model;
    let named = |set: &fdem_simulation::JointSet| ModelMark {
        name: set.name.clone(),
        facets: Vec::new(),
        nodes: Vec::new(),
    };
    let mut marks: Vec<ModelMark<D>> = model.joint_sets.iter().map(named).collect();
    for (nodes, sets) in model.mesh.elements.iter().zip(&model.joint_facets) {
        for (facet, &set) in <[[f64; D]; N]>::FACETS.into_iter().zip(sets) {
            if let Some(mark) = marks.get_mut(set as usize) {
                mark.facets.push(fdem_mesh::sorted(facet.map(|corner| nodes[corner])));
            }
        }
    }
    for mark in &mut marks {
        mark.facets.sort_unstable();
        mark.facets.dedup();
    }
    marks
}

/// The histories at points, and of means over elements in their middle.
fn points<const D: usize, const N: usize>(prepared: &Prepared<D, N>) -> Vec<ModelPoint<D>> {
    let mesh = &prepared.model.mesh;
    let at = |MaterialPoint { element, weights }: &MaterialPoint<D, N>| {
        let nodes = mesh.elements[*element as usize];
        weighted(mesh, nodes.into_iter().zip(*weights))
    };
    let middle = |elements: &[u32]| {
        let share = 1.0 / (elements.len() * N) as f64;
        let nodes = elements.iter().flat_map(|&element| mesh.elements[element as usize]);
        weighted(mesh, nodes.map(|node| (node, share)))
    };
    let places = |probe: &Probe<D, N>| match probe {
        Probe::Stress(elements) | Probe::Strain(elements) | Probe::Velocity(elements) => {
            vec![middle(elements)]
        }
        Probe::PointVelocity(point) | Probe::PorePressure(point) => vec![at(point)],
        Probe::Gauge { ends, .. } => ends.iter().map(at).collect(),
        // The picture has their bodies, nodes, boundaries and joints.
        Probe::ContactForce(_)
        | Probe::ForceOfSpheres(_)
        | Probe::Reaction(_)
        | Probe::Cavity(_)
        | Probe::Fluid
        | Probe::Injection(_)
        | Probe::Pores
        | Probe::PoreSurface(_)
        | Probe::JointSet(_)
        | Probe::RigidBody(_)
        | Probe::Wall { .. }
        | Probe::Spheres { .. }
        | Probe::Softening => Vec::new(),
    };
    let points = prepared.histories.iter().map(|history| ModelPoint {
        name: history.name.clone(),
        places: match history.quantity {
            Quantity::Node(node) => vec![mesh.nodes[node as usize]],
            Quantity::Probe(probe) => places(&prepared.probes[probe]),
            Quantity::Force(_) | Quantity::Torque(..) | Quantity::Energy | Quantity::CrackLength => {
                Vec::new()
            }
        },
    });
    points.filter(|point| !point.places.is_empty()).collect()
}

/// The mean of nodes with weights whose sum is 1, m.
fn weighted<const D: usize, const N: usize>(
    mesh: &Mesh<D, N>,
    nodes: impl Iterator<Item = (u32, f64)>,
) -> [f64; D] {
    nodes.fold([0.0; D], |sum, (node, weight)| {
        std::array::from_fn(|axis| sum[axis] + weight * mesh.nodes[node as usize][axis])
    })
}

/// A line for each stage: the bodies that it removes and adds, and the boundaries that end and begin.
fn stages<const D: usize, const N: usize>(prepared: &Prepared<D, N>) -> Vec<String> {
    let mut before: Option<&PreparedStage> = None;
    let mut lines = Vec::new();
    for stage in &prepared.stages {
        let (mut removed, mut added) = (Vec::new(), Vec::new());
        for body in &prepared.bodies {
            let range = body.elements.start as usize..body.elements.end as usize;
            let there =
                |stage: &PreparedStage| stage.elements[range.clone()].iter().filter(|there| **there).count();
            let (now, count) = (there(stage), range.len());
            let earlier = before.map_or(count, there);
            let name = if now == 0 || earlier == 0 || now == count {
                body.name.clone()
            } else {
                format!("part of {}", body.name)
            };
            if now < earlier {
                removed.push(name);
            } else if now > earlier {
                added.push(name);
            }
        }
        let boundaries = |acts: &dyn Fn(usize) -> bool| {
            let all = prepared.model.boundaries.iter().enumerate();
            all.filter(|(number, _)| acts(*number)).map(|(_, boundary)| boundary.name.clone()).collect()
        };
        let acted = |number: usize| before.is_none_or(|stage| stage.boundaries[number]);
        let ended: Vec<String> = boundaries(&|number| acted(number) && !stage.boundaries[number]);
        let begun: Vec<String> = boundaries(&|number| !acted(number) && stage.boundaries[number]);
        // All that is there in a later stage only is absent in the first one: that is no removal.
        let verbs = if before.is_none() { ["without", "with"] } else { ["removes", "adds"] };
        let bounds = if before.is_none() { ["without", "with"] } else { ["ends", "begins"] };
        let changes = [(verbs[0], removed), (verbs[1], added), (bounds[0], ended), (bounds[1], begun)];
        let changes: Vec<String> = changes
            .into_iter()
            .filter(|(_, names)| !names.is_empty())
            .map(|(verb, names)| format!("{verb} {}", names.join(", ")))
            .collect();
        lines.push(if changes.is_empty() {
            stage.name.clone()
        } else {
            format!("{}: {}", stage.name, changes.join("; "))
        });
        before = Some(stage);
    }
    lines
}
