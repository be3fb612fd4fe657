//! Files with polygons in space: CSV, GeoJSON and DXF.

use serde_json::Value;

use crate::joints::dxf::Entity;
use crate::joints::shape_file::{self, ShapeForm, Shapes, check};

/// Corners of a polygon in order, m.
pub(crate) type SpacePolygon = Vec<[f64; 3]>;

const POLYGONS: ShapeForm<SpacePolygon> = ShapeForm {
    row: corners,
    extends: |polygon| polygon.iter().any(|corner| corner != &polygon[0]),
    empty: "is a point",
    row_is: "x1,y1,z1,x2,y2,z2,x3,y3,z3,…",
    columns: &["x", "y", "z"],
    entity,
    entities: "3DFACE, closed POLYLINE and LWPOLYLINE, CIRCLE and ELLIPSE",
    refused: &["INSERT", "3DSOLID", "BODY", "MESH", "POLYLINE of a mesh", "REGION", "SURFACE"],
    coordinates: |polygon| polygon.as_flattened_mut(),
    geometries: "Polygon and MultiPolygon",
    geometry,
};

/// The polygons of a file. `scale`: length of the unit of the file, m, if the model says it.
///
/// # Errors
/// A message about a file that is not of polygons, or has none.
pub(crate) fn read(bytes: &[u8], name: &str, scale: Option<f64>) -> Result<Shapes<SpacePolygon>, String> {
    let read = shape_file::read(bytes, name, scale, &POLYGONS)?;
    let polygons = &read.all;
    check(name, "polygons", polygons.is_empty(), polygons.iter().flatten().flatten())?;
    Ok(read)
}

/// The corners of a list x1, y1, z1, x2, y2, z2, …; `None` if it is not that.
pub(crate) fn corners(numbers: &[f64]) -> Option<SpacePolygon> {
    let whole = numbers.len() >= 9 && numbers.len().is_multiple_of(3);
    whole.then(|| open(numbers.chunks(3).map(|corner| [corner[0], corner[1], corner[2]]).collect()))
}

/// Without the last corner, if it is the first again.
fn open(mut corners: SpacePolygon) -> SpacePolygon {
    if corners.len() > 3 && corners.first() == corners.last() {
        corners.pop();
    }
    corners
}

/// Adds the polygons of a geometry.
fn geometry(kind: &str, coordinates: &Value, polygons: &mut Vec<SpacePolygon>) -> Result<(), String> {
    let mut add = |rings: &Value| -> Result<(), String> {
        let rings = rings.as_array().filter(|rings| !rings.is_empty());
        let rings = rings.ok_or("coordinates of a polygon are not a list of rings")?;
        if rings.len() > 1 {
            return Err("a polygon has a hole: joints are polygons without holes".to_owned());
        }
        let corner =
            |point: &Value| Some([point.get(0)?.as_f64()?, point.get(1)?.as_f64()?, point.get(2)?.as_f64()?]);
        let ring: Option<SpacePolygon> =
            rings[0].as_array().and_then(|points| points.iter().map(corner).collect());
        let ring = ring.map(open).filter(|ring| ring.len() >= 3);
        polygons.push(ring.ok_or("coordinates of a polygon are not three corners [x, y, z] or more")?);
        Ok(())
    };
    match kind {
        "Polygon" => add(coordinates),
        "MultiPolygon" => {
            let polygons = coordinates.as_array();
            polygons.ok_or("coordinates of a MultiPolygon are no list")?.iter().try_for_each(add)
        }
        other => Err(format!("a {other} is no polygon: it has to be Polygon or MultiPolygon")),
    }
}

/// The polygon of a 3DFACE, or of a closed line.
fn entity(entity: &Entity<'_>) -> Option<SpacePolygon> {
    if entity.kind != "3DFACE" && !entity.is_closed {
        return None;
    }
    let mut corners = entity.corners.clone();
    // A triangle has its third corner twice.
    corners.dedup();
    let corners = open(corners);
    (corners.len() >= 3).then_some(corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8], name: &str) -> Result<Vec<SpacePolygon>, String> {
        super::read(bytes, name, None).map(|polygons| polygons.all)
    }

    #[test]
    fn polygons_of_each_format() {
        let triangle = vec![[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 2.0, 1.0]];
        let slope = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]];
        let both = Ok(vec![triangle, slope]);
        let csv = "x1,y1,z1,x2,y2,z2\n0,0,1,2,0,1,0,2,1\n# comment\n0 0 0 1 0 0 1 1 1 0 1 1 0 0 0\n";
        assert_eq!(read(csv.as_bytes(), "a.csv"), both);
        let json = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":
            {"type":"Polygon","coordinates":[[[0,0,1],[2,0,1],[0,2,1],[0,0,1]]]}},
            {"type":"MultiPolygon","coordinates":[[[[0,0,0],[1,0,0],[1,1,1],[0,1,1],[0,0,0]]]]}]}"#;
        assert_eq!(read(json.as_bytes(), "a.geojson"), both);
        let rows = |pairs: &[(&str, &str)]| -> String {
            pairs.iter().flat_map(|(code, value)| [*code, "\n", *value, "\n"]).collect()
        };
        let begin = rows(&[("0", "SECTION"), ("2", "ENTITIES")]);
        let flat = rows(&[
            ("0", "LWPOLYLINE"),
            ("38", "1"),
            ("70", "1"),
            ("10", "0"),
            ("20", "0"),
            ("10", "2"),
            ("20", "0"),
            ("10", "0"),
            ("20", "2"),
        ]);
        let face = |codes: [[&str; 3]; 4]| -> String {
            let corners = ["0", "0", "0", "1", "0", "0", "1", "1", "1", "0", "1", "1"];
            let pairs: Vec<(&str, &str)> = codes.as_flattened().iter().copied().zip(corners).collect();
            rows(&[("0", "3DFACE"), ("8", "0")]) + &rows(&pairs)
        };
        let face = face([["10", "20", "30"], ["11", "21", "31"], ["12", "22", "32"], ["13", "23", "33"]]);
        let end = rows(&[("0", "ENDSEC"), ("0", "EOF")]);
        assert_eq!(read(format!("{begin}{flat}{face}{end}").as_bytes(), "a.dxf"), both);
        let mut chain =
            rows(&[("0", "POLYLINE"), ("66", "1"), ("10", "0"), ("20", "0"), ("30", "0"), ("70", "9")]);
        for [x, y, z] in [["0", "0", "0"], ["1", "0", "0"], ["1", "1", "1"], ["0", "1", "1"]] {
            chain += &rows(&[("0", "VERTEX"), ("10", x), ("20", y), ("30", z), ("70", "32")]);
        }
        chain += &rows(&[("0", "SEQEND")]);
        assert_eq!(read(format!("{begin}{flat}{chain}{end}").as_bytes(), "a.dxf"), both);
    }

    #[test]
    fn what_is_no_polygon_is_refused() {
        for (text, name, part) in [
            ("0,1,2,3,4,5\n", "a.csv", "row 1"),
            ("", "a.csv", "no polygons"),
            ("{\"type\":\"LineString\"}", "a.json", "LineString"),
            ("{\"type\":\"Polygon\",\"coordinates\":[[[0,0],[1,0],[1,1]]]}", "a.json", "[x, y, z]"),
            ("{\"type\":\"Polygon\",\"coordinates\":[[],[]]}", "a.json", "hole"),
            ("[]", "a.json", "type"),
            ("x\ny\n", "a.dxf", "group code"),
            ("0,0,0,1,0,0,1,1,inf\n", "a.csv", "coordinate"),
            ("1,1,1,1,1,1,1,1,1\n", "a.csv", "row 1 is a point"),
            ("{\"type\":\"MultiPolygon\"}", "a.json", "no list"),
        ] {
            let message = read(text.as_bytes(), name).expect_err("refused");
            assert!(message.contains(part) && message.contains(name), "{message}");
        }
    }
}
