//! The entities of DXF files in ASCII that have corners.
//!
//! # Source
//! Autodesk, "DXF Reference" (2012): group codes, `$INSUNITS`, and the arbitrary axis algorithm.

use std::f64::consts::{PI, TAU};

/// Angle between two corners of an arc, degrees: chords are within 0.4 % of the radius.
const STEP: f64 = 10.0;

/// Kinds of entities that are read.
const READ: [&str; 7] = ["LINE", "3DFACE", "POLYLINE", "LWPOLYLINE", "CIRCLE", "ARC", "ELLIPSE"];

/// An entity with its corners.
#[derive(Debug)]
pub(crate) struct Entity<'a> {
    /// The kind of entity, by its name in the file.
    pub(crate) kind: &'a str,
    /// Corners, in the unit of the file, in order. A triangle has its last one twice. Empty for kinds that
    /// are not read.
    pub(crate) corners: Vec<[f64; 3]>,
    /// Whether the last corner is joined to the first.
    pub(crate) is_closed: bool,
}

/// The entities of a file, and its unit.
#[derive(Debug)]
pub(crate) struct DxfDrawing<'a> {
    pub(crate) entities: Vec<Entity<'a>>,
    /// The number of `$INSUNITS`; 0 if the file has none.
    unit: u32,
}

/// Units by their number in `$INSUNITS`, with their length in metres.
const UNITS: [(u32, &str, f64); 15] = [
    (1, "inches", 0.0254),
    (2, "feet", 0.3048),
    (3, "miles", 1609.344),
    (4, "millimetres", 1e-3),
    (5, "centimetres", 1e-2),
    (6, "metres", 1.0),
    (7, "kilometres", 1e3),
    (8, "microinches", 2.54e-8),
    (9, "mils", 2.54e-5),
    (10, "yards", 0.9144),
    (11, "angstroms", 1e-10),
    (12, "nanometres", 1e-9),
    (13, "micrometres", 1e-6),
    (14, "decimetres", 0.1),
    (21, "US survey feet", 1200.0 / 3937.0),
];

impl DxfDrawing<'_> {
    /// Name of the unit of the file, and its length in metres; `None` if the file has no unit.
    ///
    /// # Errors
    /// A unit that is not known here.
    pub(crate) fn unit(&self) -> Result<Option<(&'static str, f64)>, String> {
        if self.unit == 0 {
            return Ok(None);
        }
        let known = UNITS.iter().find(|(number, ..)| *number == self.unit);
        known.map(|(_, name, length)| Some((*name, *length))).ok_or_else(|| {
            format!(
                "its unit, $INSUNITS {}, is not known here: say scale, the length of its unit in metres",
                self.unit
            )
        })
    }
}

/// An entity, or a vertex of one, by the rows of its group codes.
struct Raw<'a> {
    kind: &'a str,
    /// Number of the row of its kind.
    row: usize,
    /// Group code, value, and the number of the row of the value.
    pairs: Vec<(u32, &'a str, usize)>,
    vertices: Vec<Raw<'a>>,
}

/// Reads a file: pairs of rows, a group code and its value. Entities are those of the section ENTITIES.
///
/// # Errors
/// Names the row. A file without the group EOF at its end is cut off.
pub(crate) fn drawing(text: &str) -> Result<DxfDrawing<'_>, String> {
    let rows: Vec<&str> = text.lines().map(str::trim).collect();
    let (mut section, mut variable, mut unit) = ("", "", 0);
    let mut all: Vec<Raw<'_>> = Vec::new();
    let mut ends = false;
    for (number, pair) in rows.chunks_exact(2).enumerate() {
        let code: u32 = pair[0].parse().map_err(|_| format!("row {}: no group code", 2 * number + 1))?;
        let (value, row) = (pair[1], 2 * number + 2);
        match (code, section) {
            (2, "SECTION") => section = value,
            (0, _) if value == "EOF" => {
                ends = true;
                break;
            }
            (0, _) if value == "SECTION" => section = "SECTION",
            (0, _) if value == "ENDSEC" => section = "",
            (9, "HEADER") => variable = value,
            (70, "HEADER") if variable == "$INSUNITS" => {
                unit = value.parse().map_err(|_| format!("row {row}: no number of a unit"))?;
            }
            (0, "ENTITIES") => {
                let raw = Raw { kind: value, row, pairs: Vec::new(), vertices: Vec::new() };
                match all.last_mut().filter(|last| last.kind == "POLYLINE") {
                    Some(last) if value == "VERTEX" => last.vertices.push(raw),
                    Some(_) if value == "SEQEND" => {}
                    _ => all.push(raw),
                }
            }
            (_, "ENTITIES") => {
                if let Some(last) = all.last_mut() {
                    let Raw { pairs, vertices, .. } = last;
                    let pairs = vertices.last_mut().map_or(pairs, |vertex| &mut vertex.pairs);
                    pairs.push((code, value, row));
                }
            }
            _ => {}
        }
    }
    if !ends || !section.is_empty() {
        let row = rows.len();
        let missing = if ends { "a section has no ENDSEC" } else { "it does not end with EOF" };
        return Err(match all.last().filter(|_| !ends && section == "ENTITIES") {
            Some(last) => {
                format!(
                    "row {row}: the file is cut off after the {} of row {}: {missing}",
                    last.kind, last.row
                )
            }
            None => format!("row {row}: the file is cut off: {missing}"),
        });
    }
    let entities = all.iter().map(Raw::entity).collect::<Result<Vec<_>, _>>()?;
    Ok(DxfDrawing { entities, unit })
}

impl<'a> Raw<'a> {
    /// The number of a group code, if it is there.
    fn find(&self, code: u32) -> Result<Option<f64>, String> {
        let pair = self.pairs.iter().find(|(known, ..)| *known == code);
        pair.map(|(_, value, row)| value.parse().map_err(|_| format!("row {row}: no number"))).transpose()
    }

    fn number(&self, code: u32, default: f64) -> Result<f64, String> {
        Ok(self.find(code)?.unwrap_or(default))
    }

    /// The number of a group code that has to be there.
    fn needed(&self, code: u32) -> Result<f64, String> {
        self.find(code)?.ok_or_else(|| format!("row {}: the {} has no group {code}", self.row, self.kind))
    }

    fn flags(&self) -> Result<u32, String> {
        Ok(self.number(70, 0.0)? as u32)
    }

    /// The point whose x has this group code. Flat drawings may have no z.
    fn point(&self, code: u32) -> Result<[f64; 3], String> {
        Ok([self.needed(code)?, self.needed(code + 10)?, self.number(code + 20, 0.0)?])
    }

    fn entity(&self) -> Result<Entity<'a>, String> {
        let mut kind = self.kind;
        let (mut corners, mut is_closed) = (Vec::new(), false);
        match kind {
            // In the space of a sheet of paper: no part of the model.
            _ if READ.contains(&kind) && self.find(67)? == Some(1.0) => kind = "paper space",
            "LINE" => corners.extend([self.point(10)?, self.point(11)?]),
            "3DFACE" => {
                corners.extend([self.point(10)?, self.point(11)?, self.point(12)?]);
                let is_triangle = self.find(13)?.is_none();
                corners.push(self.point(if is_triangle { 12 } else { 13 })?);
            }
            "LWPOLYLINE" => {
                is_closed = self.flags()? & 1 == 1;
                corners = self.bulged(&self.flat_vertices()?, is_closed)?;
            }
            "POLYLINE" if self.flags()? & (16 | 64) != 0 => kind = "POLYLINE of a mesh",
            "POLYLINE" => {
                is_closed = self.flags()? & 1 == 1;
                corners = self.vertices_of_polyline(is_closed)?;
            }
            "CIRCLE" => {
                is_closed = true;
                corners = self.round([0.0, TAU])?;
            }
            "ARC" => {
                let [from, to] = [self.needed(50)?, self.needed(51)?].map(f64::to_radians);
                corners = self.round([from, if to > from { to } else { to + TAU }])?;
            }
            "ELLIPSE" => {
                let [from, to] = [self.number(41, 0.0)?, self.number(42, TAU)?];
                let to = if to > from { to } else { to + TAU };
                is_closed = to - from > TAU - 1e-9;
                corners = self.ellipse([from, to])?;
            }
            _ => {}
        }
        Ok(Entity { kind, corners, is_closed })
    }

    /// Corners of an LWPOLYLINE, each with the bulge of the edge after it.
    fn flat_vertices(&self) -> Result<Vec<([f64; 3], f64)>, String> {
        let elevation = self.number(38, 0.0)?;
        let (mut vertices, mut heights): (Vec<([f64; 3], f64)>, usize) = (Vec::new(), 0);
        for (code, value, row) in self.pairs.iter().filter(|(code, ..)| [10, 20, 42].contains(code)) {
            let value: f64 = value.parse().map_err(|_| format!("row {row}: no number"))?;
            if *code == 10 {
                vertices.push(([value, 0.0, elevation], 0.0));
            } else if let Some((corner, bulge)) = vertices.last_mut() {
                heights += usize::from(*code == 20);
                *(if *code == 20 { &mut corner[1] } else { bulge }) = value;
            }
        }
        let found = vertices.len();
        let said = self.number(90, found as f64)?;
        if heights != found || said != found as f64 {
            return Err(format!(
                "row {}: the LWPOLYLINE has {found} x and {heights} y of its {said} vertices",
                self.row
            ));
        }
        Ok(vertices)
    }

    fn vertices_of_polyline(&self, is_closed: bool) -> Result<Vec<[f64; 3]>, String> {
        let mut vertices = Vec::new();
        for vertex in &self.vertices {
            // The frame of a spline is not on the line.
            if vertex.flags()? & 16 == 0 {
                vertices.push((vertex.point(10)?, vertex.number(42, 0.0)?));
            }
        }
        if self.flags()? & 8 != 0 {
            return Ok(vertices.into_iter().map(|(corner, _)| corner).collect());
        }
        let elevation = self.number(30, 0.0)?;
        for (corner, _) in vertices.iter_mut().filter(|(corner, _)| corner[2] == 0.0) {
            corner[2] = elevation;
        }
        self.bulged(&vertices, is_closed)
    }

    /// Corners with those of the arcs between them, in the model.
    fn bulged(&self, vertices: &[([f64; 3], f64)], is_closed: bool) -> Result<Vec<[f64; 3]>, String> {
        let mut corners = Vec::new();
        for (k, &(from, bulge)) in vertices.iter().enumerate() {
            corners.push(from);
            let to = vertices.get(k + 1).or_else(|| vertices.first().filter(|_| is_closed));
            let Some((to, _)) = to.filter(|_| bulge != 0.0) else { continue };
            // A bulge is the tangent of a quarter of the angle of the arc, which turns to the left.
            let angle = 4.0 * libm::atan(bulge);
            let high = (1.0 - bulge * bulge) / (4.0 * bulge);
            let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
            let centre =
                [f64::midpoint(from[0], to[0]) - high * dy, f64::midpoint(from[1], to[1]) + high * dx];
            let [x, y] = [from[0] - centre[0], from[1] - centre[1]];
            let steps = steps(angle);
            corners.extend((1..steps).map(|step| {
                let (sine, cosine) = libm::sincos(angle * step as f64 / steps as f64);
                [centre[0] + cosine * x - sine * y, centre[1] + sine * x + cosine * y, from[2]]
            }));
        }
        self.in_model(corners)
    }

    /// Corners of a circle, or of the arc between two angles.
    fn round(&self, [from, to]: [f64; 2]) -> Result<Vec<[f64; 3]>, String> {
        let (centre, radius) = (self.point(10)?, self.needed(40)?);
        let place = |angle: f64| {
            let (sine, cosine) = libm::sincos(angle);
            [centre[0] + radius * cosine, centre[1] + radius * sine, centre[2]]
        };
        self.in_model(turned([from, to]).map(place).collect())
    }

    /// Corners of an ellipse, or of its part between two parameters.
    fn ellipse(&self, [from, to]: [f64; 2]) -> Result<Vec<[f64; 3]>, String> {
        let (centre, long, ratio) = (self.point(10)?, self.point(11)?, self.needed(40)?);
        let short = cross(self.normal()?, long).map(|x| ratio * x);
        let place = |angle: f64| {
            let (sine, cosine) = libm::sincos(angle);
            [0, 1, 2].map(|k| centre[k] + cosine * long[k] + sine * short[k])
        };
        Ok(turned([from, to]).map(place).collect())
    }

    /// The direction in which an entity is extruded, of length 1.
    fn normal(&self) -> Result<[f64; 3], String> {
        let normal = [self.number(210, 0.0)?, self.number(220, 0.0)?, self.number(230, 1.0)?];
        Ok(unit(normal))
    }

    /// Flat entities are in coordinates of their own plane.
    fn in_model(&self, mut corners: Vec<[f64; 3]>) -> Result<Vec<[f64; 3]>, String> {
        let normal = self.normal()?;
        if normal == [0.0, 0.0, 1.0] {
            return Ok(corners);
        }
        let is_steep = normal[0].abs() < 1.0 / 64.0 && normal[1].abs() < 1.0 / 64.0;
        let along = unit(cross(if is_steep { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] }, normal));
        let across = cross(normal, along);
        for corner in &mut corners {
            let [x, y, z] = *corner;
            *corner = [0, 1, 2].map(|k| x * along[k] + y * across[k] + z * normal[k]);
        }
        Ok(corners)
    }
}

/// Number of chords of an arc.
fn steps(angle: f64) -> usize {
    // Rounding does not add one.
    (angle.abs().to_degrees() / STEP - 1e-9).ceil().clamp(1.0, 360.0 / STEP) as usize
}

/// Angles from one to another, without the last of a whole turn.
fn turned([from, to]: [f64; 2]) -> impl Iterator<Item = f64> {
    let steps = steps(to - from);
    let is_whole = to - from > 2.0 * PI - 1e-9;
    (0..steps + usize::from(!is_whole)).map(move |step| from + (to - from) * step as f64 / steps as f64)
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = a.iter().fold(0.0, |sum: f64, x| sum.hypot(*x));
    a.map(|x| if length > 0.0 { x / length } else { x })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(entities: &str) -> DxfDrawing<'static> {
        let rows = format!("0 SECTION 2 ENTITIES {entities} 0 ENDSEC 0 EOF").replace(' ', "\n");
        drawing(rows.leak()).expect("a drawing")
    }

    fn is_near(a: [f64; 3], b: [f64; 3]) -> bool {
        (0..3).all(|k| (a[k] - b[k]).abs() < 1e-12)
    }

    #[test]
    fn round_entities_have_corners_within_their_tolerance() {
        let of = read(
            "0 CIRCLE 10 1 20 2 30 3 40 2 0 ARC 10 0 20 0 40 1 50 270 51 90 \
             0 ELLIPSE 10 0 20 0 30 0 11 2 21 0 31 0 40 0.5 41 0 42 1.5707963267948966",
        );
        let [circle, arc, ellipse] = &of.entities[..] else { panic!("{of:?}") };
        assert_eq!((circle.corners.len(), circle.is_closed), (36, true));
        let is_on = |[x, y, z]: &[f64; 3]| ((x - 1.0).hypot(y - 2.0) - 2.0).abs() < 1e-12 && *z == 3.0;
        assert!(circle.corners.iter().all(is_on));
        assert_eq!((arc.corners.len(), arc.is_closed), (19, false));
        assert!(is_near(arc.corners[0], [0.0, -1.0, 0.0]) && is_near(arc.corners[18], [0.0, 1.0, 0.0]));
        assert!(is_near(arc.corners[9], [1.0, 0.0, 0.0]), "it turns to the left");
        assert_eq!((ellipse.corners.len(), ellipse.is_closed), (10, false));
        assert!(is_near(ellipse.corners[9], [0.0, 1.0, 0.0]));
    }

    #[test]
    fn bulges_are_arcs_and_flat_entities_are_in_their_plane() {
        let of = read(
            "0 LWPOLYLINE 70 1 10 0 20 0 42 1 10 2 20 0 0 LWPOLYLINE 70 0 210 0 220 0 230 -1 10 1 20 2 10 3 20 4",
        );
        let [half, mirrored] = &of.entities[..] else { panic!("{of:?}") };
        assert_eq!(half.corners.len(), 19, "the closing edge is straight");
        assert!(is_near(half.corners[9], [1.0, -1.0, 0.0]), "{half:?}");
        assert!(is_near(mirrored.corners[1], [-3.0, 4.0, 0.0]), "{mirrored:?}");
    }

    /// A file that is cut off anywhere is refused, with the row at which it ends.
    #[test]
    fn a_file_that_is_cut_off_is_refused() {
        let whole = "0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 ENTITIES \
                     0 LINE 10 -100 20 500 11 2000 21 500 0 LWPOLYLINE 90 2 70 0 10 300 20 0 10 300 20 1000 \
                     0 ENDSEC 0 EOF";
        let rows: Vec<&str> = whole.split(' ').filter(|row| !row.is_empty()).collect();
        drawing(&rows.join("\n")).expect("a drawing");
        drawing(&(rows.join("\r\n") + "\r\n\u{1a}")).expect("a drawing with an old mark of the end");
        for end in 0..rows.len() {
            let error = drawing(&rows[..end].join("\n")).expect_err("a file that is cut off");
            assert!(error.starts_with(&format!("row {end}: the file is cut off")), "{end}: {error}");
        }
        let cut = drawing(&rows[..38].join("\n")).expect_err("a file that is cut off");
        assert_eq!(
            cut,
            "row 38: the file is cut off after the LWPOLYLINE of row 26: it does not end with EOF"
        );
    }

    #[test]
    fn entities_without_a_coordinate_are_refused() {
        for (entity, part) in [
            ("0 LINE 10 1 20 1 11 2", "row 6: the LINE has no group 21"),
            ("0 CIRCLE 10 1 20 1", "row 6: the CIRCLE has no group 40"),
            ("0 LWPOLYLINE 70 0 10 1 20 1 10 2", "row 6: the LWPOLYLINE has 2 x and 1 y of its 2 vertices"),
            ("0 LWPOLYLINE 90 3 10 1 20 1 10 2 20 2", "has 2 x and 2 y of its 3 vertices"),
        ] {
            let rows = format!("0 SECTION 2 ENTITIES {entity} 0 ENDSEC 0 EOF").replace(' ', "\n");
            let error = drawing(&rows).expect_err("a coordinate is missing");
            assert!(error.contains(part), "{error}");
        }
    }

    #[test]
    fn a_mesh_and_the_frame_of_a_spline_are_no_polylines() {
        let of = read(
            "0 POLYLINE 70 16 0 VERTEX 10 1 20 1 0 SEQEND \
             0 POLYLINE 70 4 0 VERTEX 10 5 20 5 70 16 0 VERTEX 10 1 20 1 0 VERTEX 10 2 20 1 0 SEQEND \
             0 LINE 67 1 10 0 20 0 11 1 21 0 0 SPLINE 10 1 20 1",
        );
        let kinds: Vec<(&str, usize)> = of.entities.iter().map(|of| (of.kind, of.corners.len())).collect();
        assert_eq!(kinds, [("POLYLINE of a mesh", 0), ("POLYLINE", 2), ("paper space", 0), ("SPLINE", 0)]);
    }
}
