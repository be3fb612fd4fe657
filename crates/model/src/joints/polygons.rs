//! Files with polygons in space: CSV, GeoJSON and DXF.

use serde_json::Value;

use crate::joints::polylines::rows;

/// Corners of a polygon in order, m.
pub(crate) type SpacePolygon = Vec<[f64; 3]>;

/// The polygons of a file.
///
/// # Errors
/// A message about a file that is not of polygons, or has none.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<Vec<SpacePolygon>, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| format!("{name} is not a text file"))?;
    let extension = name.rsplit_once('.').map_or("", |(_, end)| end).to_lowercase();
    let polygons = if extension == "dxf" {
        dxf(text)
    } else if ["json", "geojson"].contains(&extension.as_str()) {
        let value = serde_json::from_str(text).map_err(|error| format!("{name} is not JSON: {error}"))?;
        let mut polygons = Vec::new();
        geojson(&value, &mut polygons).map(|()| polygons)
    } else {
        rows(text, corners, "x1,y1,z1,x2,y2,z2,x3,y3,z3,…")
    };
    let polygons = polygons.map_err(|why| format!("{name}: {why}"))?;
    if polygons.is_empty() {
        return Err(format!("{name} has no polygons"));
    }
    match polygons.iter().flatten().flatten().find(|number| !number.is_finite()) {
        Some(number) => Err(format!("{name} has the coordinate {number}")),
        None => Ok(polygons),
    }
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

/// Adds the polygons of all geometries.
fn geojson(value: &Value, polygons: &mut Vec<SpacePolygon>) -> Result<(), String> {
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
    let coordinates = &value["coordinates"];
    match value["type"].as_str() {
        Some("FeatureCollection") => {
            value["features"].as_array().into_iter().flatten().try_for_each(|of| geojson(of, polygons))
        }
        Some("GeometryCollection") => {
            value["geometries"].as_array().into_iter().flatten().try_for_each(|of| geojson(of, polygons))
        }
        Some("Feature") => geojson(&value["geometry"], polygons),
        Some("Polygon") => add(coordinates),
        Some("MultiPolygon") => coordinates.as_array().into_iter().flatten().try_for_each(add),
        Some(other) => Err(format!("a {other} is no polygon: it has to be Polygon or MultiPolygon")),
        None => Err("it is not GeoJSON: an object has no \"type\"".to_owned()),
    }
}

/// An entity of a DXF file while it is read.
#[derive(Default)]
struct Entity {
    kind: String,
    /// Coordinates of its corners, each by its place.
    corners: Vec<[Option<f64>; 3]>,
    closed: bool,
    elevation: f64,
}

impl Entity {
    fn set(&mut self, corner: usize, axis: usize, value: f64) {
        if self.corners.len() <= corner {
            self.corners.resize(corner + 1, [None; 3]);
        }
        self.corners[corner][axis] = Some(value);
    }

    /// The polygon that an entity is, if it is one.
    fn polygon(&self) -> Option<SpacePolygon> {
        let flat = match self.kind.as_str() {
            "3DFACE" => false,
            "LWPOLYLINE" | "POLYLINE" if self.closed => self.kind == "LWPOLYLINE",
            _ => return None,
        };
        let corner = |&[x, y, z]: &[Option<f64>; 3]| {
            [
                x.unwrap_or(0.0),
                y.unwrap_or(0.0),
                z.filter(|_| !flat).unwrap_or(if flat { self.elevation } else { 0.0 }),
            ]
        };
        let mut corners: SpacePolygon = self.corners.iter().map(corner).collect();
        // A triangle has its third corner twice.
        corners.dedup();
        let corners = open(corners);
        (corners.len() >= 3).then_some(corners)
    }
}

/// The entities 3DFACE, and closed POLYLINE and LWPOLYLINE, of a DXF file: pairs of rows, a group code and
/// its value.
fn dxf(text: &str) -> Result<Vec<SpacePolygon>, String> {
    let rows: Vec<&str> = text.lines().map(str::trim).collect();
    let mut polygons = Vec::new();
    let mut entity = Entity::default();
    let (mut entities, mut vertex) = (false, false);
    for (number, pair) in rows.chunks_exact(2).enumerate() {
        let code: u32 = pair[0].parse().map_err(|_| format!("row {}: no group code", 2 * number + 1))?;
        let value = || pair[1].parse::<f64>().map_err(|_| format!("row {}: no number", 2 * number + 2));
        match (code, entity.kind.as_str()) {
            // Vertices follow their polyline.
            (0, "POLYLINE") if pair[1] == "VERTEX" => {
                vertex = true;
                entity.corners.push([None; 3]);
            }
            (0, _) => {
                polygons.extend(entity.polygon().filter(|_| entities));
                entity = Entity { kind: pair[1].to_owned(), ..Entity::default() };
                vertex = false;
            }
            (2, "SECTION") => entities = pair[1] == "ENTITIES",
            (10..=13 | 20..=23 | 30..=33, "3DFACE") => {
                entity.set((code % 10) as usize, (code / 10 - 1) as usize, value()?);
            }
            (10, "LWPOLYLINE") => entity.corners.push([Some(value()?), None, None]),
            (20, "LWPOLYLINE") => {
                let last = entity.corners.len().saturating_sub(1);
                entity.set(last, 1, value()?);
            }
            (38, "LWPOLYLINE") => entity.elevation = value()?,
            (10 | 20 | 30, "POLYLINE") if vertex => {
                let last = entity.corners.len().saturating_sub(1);
                entity.set(last, (code / 10 - 1) as usize, value()?);
            }
            (70, "LWPOLYLINE") => entity.closed = value()? as u32 % 2 == 1,
            (70, "POLYLINE") if !vertex => entity.closed = value()? as u32 % 2 == 1,
            _ => {}
        }
    }
    Ok(polygons)
}

#[cfg(test)]
mod tests {
    use super::*;

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
        ] {
            let message = read(text.as_bytes(), name).expect_err("refused");
            assert!(message.contains(part) && message.contains(name), "{message}");
        }
    }
}
