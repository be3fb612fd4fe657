//! Files with lines in the plane: CSV, GeoJSON and DXF.

use serde_json::Value;

use crate::joints::dxf::Entity;
use crate::joints::shape_file::{self, ShapeForm, check};
use crate::shapes::outline::Point;

const POLYLINES: ShapeForm<Vec<Point>> =
    ShapeForm { row: points, row_is: "x1,y1,x2,y2,…", columns: &["x", "y"], entity, geometry };

/// The lines of a file, by their two ends; a polyline is several.
///
/// # Errors
/// A message about a file that is not of lines, or has none.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<Vec<[Point; 2]>, String> {
    let chains = shape_file::read(bytes, name, &POLYLINES)?;
    let lines: Vec<[Point; 2]> =
        chains.iter().flat_map(|chain| chain.windows(2).map(|pair| [pair[0], pair[1]])).collect();
    check(name, "lines", lines.is_empty(), lines.iter().flatten().flatten())?;
    Ok(lines)
}

/// The points of a list x1, y1, x2, y2, …; `None` if it is not that.
pub(crate) fn points(numbers: &[f64]) -> Option<Vec<Point>> {
    let whole = numbers.len() >= 4 && numbers.len().is_multiple_of(2);
    whole.then(|| numbers.chunks(2).map(|pair| [pair[0], pair[1]]).collect())
}

/// Adds the lines of a geometry.
fn geometry(kind: &str, coordinates: &Value, chains: &mut Vec<Vec<Point>>) -> Result<(), String> {
    let chain = |points: &Value| -> Option<Vec<Point>> {
        let point = |point: &Value| Some([point.get(0)?.as_f64()?, point.get(1)?.as_f64()?]);
        points.as_array()?.iter().map(point).collect()
    };
    let wrong = || "coordinates of a line are not a list of [x, y]".to_owned();
    match kind {
        "LineString" => chains.push(chain(coordinates).ok_or_else(wrong)?),
        "MultiLineString" => {
            for of in coordinates.as_array().ok_or_else(wrong)? {
                chains.push(chain(of).ok_or_else(wrong)?);
            }
        }
        other => return Err(format!("a {other} is no line: it has to be LineString or MultiLineString")),
    }
    Ok(())
}

/// The points of a LINE or LWPOLYLINE.
fn entity(entity: &Entity<'_>) -> Option<Vec<Point>> {
    let mut chain: Vec<Point> = entity.corners.iter().map(|&[x, y, _]| [x, y]).collect();
    chain.extend(chain.first().copied().filter(|_| entity.is_closed));
    ["LINE", "LWPOLYLINE"].contains(&entity.kind).then_some(chain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_each_format() {
        let line = [[0.0, 1.0], [2.0, 3.0]];
        let chain = [line, [[2.0, 3.0], [4.0, 5.0]]];
        let csv = "x1,y1,x2,y2\n0,1,2,3\n# comment\n0 1 2 3 4 5\n";
        assert_eq!(read(csv.as_bytes(), "a.csv"), Ok(vec![line, chain[0], chain[1]]));
        let json = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":
            {"type":"LineString","coordinates":[[0,1],[2,3],[4,5]]}}, {"type":"MultiLineString","coordinates":[[[0,1,9],[2,3,9]]]}]}"#;
        assert_eq!(read(json.as_bytes(), "a.geojson"), Ok(vec![chain[0], chain[1], line]));
        let dxf = "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n0\n10\n0\n20\n1\n11\n2\n21\n3\n0\nLWPOLYLINE\n70\n0\n10\n0\n20\n1\n10\n2\n20\n3\n10\n4\n20\n5\n0\nENDSEC\n0\nEOF\n";
        assert_eq!(read(dxf.as_bytes(), "a.dxf"), Ok(vec![line, chain[0], chain[1]]));
    }

    #[test]
    fn what_is_no_line_is_refused() {
        for (text, name, part) in [
            ("0,1,2\n", "a.csv", "row 1"),
            ("x1,x2,y1,y2\n0,4,1,3.5\n", "a.csv", "the column \"x2\" in the place of y"),
            ("x1 [mm],y1 [mm],x2 [mm],y2 [mm]\n0,1,4,3\n", "a.csv", "the unit mm"),
            ("x1;y1;x2;y2\n1,5;1,5;8,5;1,5\n", "a.csv", "row 2 has decimal commas"),
            ("1,5 1,5 8,5 1,5\n", "a.csv", "row 1 has decimal commas"),
            ("", "a.csv", "no lines"),
            ("{\"type\":\"Point\"}", "a.json", "Point"),
            ("[]", "a.json", "type"),
            ("x\ny\n", "a.dxf", "group code"),
            ("0,1,2,inf\n", "a.csv", "coordinate"),
        ] {
            let message = read(text.as_bytes(), name).expect_err("refused");
            assert!(message.contains(part) && message.contains(name), "{message}");
        }
    }
}
