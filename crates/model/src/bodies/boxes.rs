//! The boxes around bodies before they are meshed, so that a wrong unit is seen before it costs time.

use std::fmt;

use fdem_io::numbers::brief;

use crate::bodies::{gmsh, mesh_file, space};
use crate::shapes::extent::extent;
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{Body, ModelFile, Vector};
use crate::text::included::Load;

/// Width of a body over its mesh size that nobody means without saying so.
const FINEST: f64 = 500.0;

/// The box around a body that is meshed here, as its shape has it: before it is turned.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyBox {
    /// Name of the body.
    pub name: String,
    /// Least coordinates, m: two or three.
    pub low: Vec<f64>,
    /// Largest coordinates, m.
    pub high: Vec<f64>,
    /// Edge of its elements, m.
    pub mesh_size: f64,
    /// Angle by which it is turned about the middle of the box, degrees.
    pub angle: f64,
}

impl BodyBox {
    fn new<const D: usize>(body: &Body, [low, high]: [[f64; D]; 2], mesh_size: f64) -> Self {
        let by = body.translate.as_ref().map_or([0.0; D], Vector::components);
        let moved = |corner: [f64; D]| (0..D).map(|axis| corner[axis] + by[axis]).collect();
        Self { name: body.name.clone(), low: moved(low), high: moved(high), mesh_size, angle: body.angle }
    }

    fn widths(&self) -> impl Iterator<Item = f64> {
        self.low.iter().zip(&self.high).map(|(low, high)| high - low)
    }

    fn size(&self) -> String {
        self.widths().map(brief).collect::<Vec<_>>().join(" x ")
    }
}

impl fmt::Display for BodyBox {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let from = self.low.iter().map(|x| brief(*x)).collect::<Vec<_>>().join(", ");
        let Self { name, mesh_size, angle, .. } = self;
        write!(out, "{name}: {} m, from [{from}], ", self.size())?;
        if *angle != 0.0 {
            write!(out, "before it is turned by {} degrees, ", brief(*angle))?;
        }
        write!(out, "mesh_size {} m", brief(*mesh_size))
    }
}

/// The boxes of all bodies that are meshed here; none for packings and for shapes that are wrong. Refuses a
/// mesh size far below the width of a body, unless the model says that it is meant.
pub(crate) fn boxes(
    file: &ModelFile,
    document: &Document<'_>,
    load: &mut Load<'_>,
    faults: &mut Vec<Fault>,
) -> Vec<BodyBox> {
    let mut all = Vec::new();
    for (index, body) in file.body.iter().enumerate() {
        let Some(found) = box_of(body, load) else { continue };
        let width = found.widths().fold(0.0, f64::max);
        if !body.fine && width > FINEST * found.mesh_size {
            let message = format!(
                "[[body]] \"{}\" is {} m wide, {} times its mesh_size of {} m",
                body.name,
                found.size(),
                brief((width / found.mesh_size).round()),
                brief(found.mesh_size)
            );
            let unit = if body.surface.is_some() || body.mesh.is_some() {
                ", or say scale if the unit of the file is another"
            } else {
                ""
            };
            let help = format!("take a larger mesh_size{unit}; with fine = true it is meshed as it is");
            let span = document.value(Table::of("body", index), "mesh_size");
            faults.push(Fault::at(span, message).label("very small").help(help));
        }
        all.push(found);
    }
    all
}

fn box_of(body: &Body, load: &mut Load<'_>) -> Option<BodyBox> {
    let size = body.mesh_size.filter(|_| body.packing.is_none())?;
    if let Some(flat) = extent(body) {
        return Some(BodyBox::new(body, flat.bounds, size));
    }
    // Errors of files are reported where the bodies are made.
    let bounds = if let Some(name) = &body.surface {
        let triangles = mesh_file::triangles(load, name, mesh_file::scale_of(body)).ok()?;
        fdem_mesh::bounds(triangles.into_iter().flatten())
    } else if let Some(name) = body.mesh.as_ref().filter(|name| gmsh::is_geometry(name)) {
        gmsh::bounds(&load(name).ok()?, name)?.map(|corner| corner.map(|x| x * mesh_file::scale_of(body)))
    } else {
        space::bounds(body)?
    };
    let is_known = bounds.as_flattened().iter().all(|x| x.is_finite());
    is_known.then(|| BodyBox::new(body, bounds, size))
}

#[cfg(test)]
mod tests {
    use super::BodyBox;

    #[test]
    fn the_box_of_a_turned_body_says_so() {
        let of = |angle: f64| BodyBox {
            name: "a".to_owned(),
            low: vec![0.0, 0.0],
            high: vec![2.0, 1.0],
            mesh_size: 0.1,
            angle,
        };
        assert_eq!(of(0.0).to_string(), "a: 2 x 1 m, from [0, 0], mesh_size 0.1 m");
        assert_eq!(
            of(30.0).to_string(),
            "a: 2 x 1 m, from [0, 0], before it is turned by 30 degrees, mesh_size 0.1 m"
        );
    }
}
