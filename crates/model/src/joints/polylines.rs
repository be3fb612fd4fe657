//! Files with lines in the plane: CSV, GeoJSON and DXF.

use serde_json::Value;

use crate::joints::dxf::Entity;
use crate::joints::shape_file::{self, ShapeForm, Shapes, check};
use crate::shapes::outline::Point;

const POLYLINES: ShapeForm<Vec<Point>> = ShapeForm {
    row: points,
    extends: |chain| extends(chain),
    empty: "has no length",
    row_is: "x1,y1,x2,y2,…",
    columns: &["x", "y"],
    entity,
    entities: "LINE, LWPOLYLINE, POLYLINE, CIRCLE, ARC and ELLIPSE",
    refused: &["SPLINE", "INSERT", "MLINE", "HELIX", "RAY", "XLINE"],
    coordinates: |chain| chain.as_flattened_mut(),
    geometries: "LineString and MultiLineString",
    geometry,
};

/// The lines of a file, by their two ends; a polyline is several. `scale`: length of the unit of the file, m,
/// if the model says it.
///
/// # Errors
/// A message about a file that is not of lines, or has none.
pub(crate) fn read(bytes: &[u8], name: &str, scale: Option<f64>) -> Result<Shapes<[Point; 2]>, String> {
    let Shapes { all: chains, scale, notes } = shape_file::read(bytes, name, scale, &POLYLINES)?;
    let lines: Vec<[Point; 2]> =
        chains.iter().flat_map(|chain| chain.windows(2).map(|pair| [pair[0], pair[1]])).collect();
    check(name, "lines", lines.is_empty(), lines.iter().flatten().flatten())?;
    Ok(Shapes { all: lines, scale, notes })
}

/// The points of a list x1, y1, x2, y2, …; `None` if it is not that.
pub(crate) fn points(numbers: &[f64]) -> Option<Vec<Point>> {
    let whole = numbers.len() >= 4 && numbers.len().is_multiple_of(2);
    whole.then(|| numbers.chunks(2).map(|pair| [pair[0], pair[1]]).collect())
}

/// Whether a polyline has a length.
pub(crate) fn extends(chain: &[Point]) -> bool {
    chain.iter().any(|point| point != &chain[0])
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

/// The points of an entity that is a line.
fn entity(entity: &Entity<'_>) -> Option<Vec<Point>> {
    let mut chain: Vec<Point> = entity.corners.iter().map(|&[x, y, _]| [x, y]).collect();
    chain.extend(chain.first().copied().filter(|_| entity.is_closed));
    (entity.kind != "3DFACE" && chain.len() > 1).then_some(chain)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8], name: &str) -> Result<Vec<[Point; 2]>, String> {
        super::read(bytes, name, None).map(|lines| lines.all)
    }

    /// A drawing in millimetres with a hole, a note and a polyline of the older kind.
    #[test]
    fn a_drawing_has_its_unit_and_all_of_its_lines() {
        let rows = |text: &str| text.split_whitespace().collect::<Vec<_>>().join("\n");
        let drawing = |unit: &str, more: &str| {
            rows(&format!(
                "0 SECTION 2 HEADER 9 $INSUNITS 70 {unit} 0 ENDSEC 0 SECTION 2 ENTITIES \
                 0 CIRCLE 10 0 20 0 40 500 0 TEXT 10 0 20 0 1 Hole 0 POLYLINE 70 0 66 1 10 0 20 0 \
                 0 VERTEX 10 1000 20 0 0 VERTEX 10 1000 20 2000 0 SEQEND {more} 0 ENDSEC 0 EOF"
            ))
        };
        let length = |lines: &[[Point; 2]]| -> f64 {
            lines.iter().map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).sum()
        };
        let of = super::read(drawing("4", "").as_bytes(), "a.dxf", None).expect("lines");
        assert_eq!(of.all.len(), 37);
        let expected = 36.0 * libm::sin(5.0_f64.to_radians()) + 2.0;
        assert!((length(&of.all) - expected).abs() < 1e-9, "{}", length(&of.all));
        let notes = of.notes.join("\n");
        for part in
            ["a.dxf: not used: 1 TEXT;", "its unit is millimetres ($INSUNITS), so that 1 of it is 0.001 m"]
        {
            assert!(notes.contains(part), "{notes}");
        }
        let of = super::read(drawing("4", "").as_bytes(), "a.dxf", Some(0.1)).expect("lines");
        assert!((length(&of.all) - 100.0 * expected).abs() < 1e-9);
        assert_eq!(of.notes.len(), 1, "the model says the unit: {:?}", of.notes);
        for (unit, more, part) in [
            ("15", "", "$INSUNITS 15, is not known here: say scale"),
            ("6", "0 SPLINE 10 1 20 1", "it has SPLINE, which is not read"),
            ("6", "0 INSERT 2 block", "it has INSERT, which is not read"),
        ] {
            let message = read(drawing(unit, more).as_bytes(), "a.dxf").expect_err("refused");
            assert!(message.contains(part), "{message}");
        }
    }

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

    /// Exports have points and labels beside their lines. A geometry that could have been meant for a line is
    /// refused.
    #[test]
    fn points_of_a_geojson_file_are_not_used_and_counted() {
        let feature = |kind: &str, coordinates: &str| {
            format!(
                r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"{kind}","coordinates":{coordinates}}}}}"#
            )
        };
        let file = |last: &str| {
            let features =
                [feature("LineString", "[[0,1],[2,3]]"), feature("Point", "[0,1]"), last.to_owned()];
            format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(","))
        };
        let without = r#"{"type":"Feature","properties":{},"geometry":null}"#;
        let of = super::read(file(without).as_bytes(), "a.geojson", None).expect("lines");
        assert_eq!(of.all, [[[0.0, 1.0], [2.0, 3.0]]]);
        let note =
            "a.geojson: not used: 1 Feature without geometry, 1 Point; LineString and MultiLineString are";
        assert_eq!(of.notes, [note]);
        let polygon = file(&feature("Polygon", "[[[0,0],[1,0],[1,1],[0,0]]]"));
        let message = read(polygon.as_bytes(), "a.geojson").expect_err("a polygon");
        assert!(message.starts_with("a.geojson: feature 3: a Polygon is no line"), "{message}");
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
            ("0,0.5,1,0.5\n0.2,0.2,0.2,0.2\n", "a.csv", "row 2 has no length"),
            (
                "{\"type\":\"LineString\",\"coordinates\":[[1,2],[1,2]]}",
                "a.json",
                "geometry 1, a LineString, has no length",
            ),
            ("{\"type\":\"FeatureCollection\"}", "a.json", "a FeatureCollection has no list \"features\""),
        ] {
            let message = read(text.as_bytes(), name).expect_err("refused");
            assert!(message.contains(part) && message.contains(name), "{message}");
        }
    }
}
