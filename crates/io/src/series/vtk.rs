//! Points of VTK files, with a radius from their data.

use crate::column_values::ColumnValues;
use crate::columns::{Name, Role};
use crate::error::ReadError;
use crate::mesh::error::Fault;
use crate::mesh::vtk_points::PointCloud;
use crate::mesh::{vtk, vtk_xml};
use crate::options::ReadOptions;
use crate::packing::{Format, Frame, Packing};
use crate::place::Place;
use crate::series::collection::{PieceFiles, Pieces};
use crate::series::values;

/// Names that mean diameters here only: `ParaView` draws spheres of this diameter.
const DIAMETERS: [&str; 3] = ["scale", "glyphscale", "diameters"];

pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Packing, ReadError> {
    packing(vtk::points(bytes).map_err(fault)?, Format::Vtk, options)
}

pub(super) fn read_xml(bytes: &[u8], options: &ReadOptions) -> Result<Packing, ReadError> {
    packing(vtk_xml::points(bytes).map_err(fault)?, Format::VtkXml, options)
}

pub(super) fn read_pieces(
    pieces: &Pieces,
    files: &dyn PieceFiles,
    options: &ReadOptions,
) -> Result<Packing, ReadError> {
    packing(pieces.points(files)?, Format::VtkXml, options)
}

fn fault((place, problem): Fault) -> ReadError {
    ReadError::Broken { place, problem: problem.to_string() }
}

fn packing(cloud: PointCloud, format: Format, options: &ReadOptions) -> Result<Packing, ReadError> {
    let PointCloud { points, mut arrays, step, time } = cloud;
    let axes = ["x", "y", "z"].into_iter().enumerate().map(|(axis, plain)| {
        let mut name = Name::unsuffixed(&format!("Points:{axis}"));
        plain.clone_into(&mut name.plain);
        name
    });
    let rows = points.len();
    let names: Vec<Name> = axes.chain(arrays.iter().map(|(label, _)| name(label))).collect();
    let column = |place: usize| {
        let Some(array) = place.checked_sub(3) else {
            return Ok(ColumnValues::Real(points.iter().map(|point| point[place]).collect()));
        };
        let (label, values) = &mut arrays[array];
        // Each column is requested once.
        let values = std::mem::replace(values, ColumnValues::Whole(Vec::new()));
        if values.len() == rows {
            return Ok(values);
        }
        let problem = format!("point data {label} has {} values for {rows} points", values.len());
        Err(ReadError::Broken { place: Place::File, problem })
    };
    values::packing(&names, rows, column, format, Frame { index: 0, step, time }, options)
}

/// The role of point data by their name. Point data are never coordinates; the points are.
fn name(label: &str) -> Name {
    let mut name = Name::unsuffixed(label);
    if DIAMETERS.contains(&name.plain.as_str()) {
        "diameter".clone_into(&mut name.plain);
    } else if matches!(name.role(), Some(Role::X | Role::Y | Role::Z)) {
        name.plain = format!("data {label}");
    }
    name
}
