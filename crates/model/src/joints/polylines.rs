//! Files with lines in the plane: CSV, GeoJSON and DXF.

use serde_json::Value;

use crate::shapes::outline::Point;

/// The lines of a file, by their two ends; a polyline is several.
///
/// # Errors
/// A message about a file that is not of lines, or has none.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<Vec<[Point; 2]>, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| format!("{name} is not a text file"))?;
    let extension = name.rsplit_once('.').map_or("", |(_, end)| end).to_lowercase();
    let chains = if extension == "dxf" {
        dxf(text)
    } else if ["json", "geojson"].contains(&extension.as_str()) {
        let value = serde_json::from_str(text).map_err(|error| format!("{name} is not JSON: {error}"))?;
        let mut chains = Vec::new();
        geojson(&value, &mut chains).map(|()| chains)
    } else {
        rows(text, points, "x1,y1,x2,y2,…")
    };
    let chains = chains.map_err(|why| format!("{name}: {why}"))?;
    let lines: Vec<[Point; 2]> =
        chains.iter().flat_map(|chain| chain.windows(2).map(|pair| [pair[0], pair[1]])).collect();
    if lines.is_empty() {
        return Err(format!("{name} has no lines"));
    }
    match lines.iter().flatten().flatten().find(|number| !number.is_finite()) {
        Some(number) => Err(format!("{name} has the coordinate {number}")),
        None => Ok(lines),
    }
}

/// The points of a list x1, y1, x2, y2, …; `None` if it is not that.
pub(crate) fn points(numbers: &[f64]) -> Option<Vec<Point>> {
    let whole = numbers.len() >= 4 && numbers.len().is_multiple_of(2);
    whole.then(|| numbers.chunks(2).map(|pair| [pair[0], pair[1]]).collect())
}

/// One polyline or polygon a row, which `of` makes of its numbers. A first row of words is a heading. `form`:
/// description of a row, for messages.
pub(crate) fn rows<T>(text: &str, of: impl Fn(&[f64]) -> Option<T>, form: &str) -> Result<Vec<T>, String> {
    let mut found = Vec::new();
    for (number, row) in (1..).zip(text.lines()) {
        let row = row.split('#').next().unwrap_or_default().trim();
        if row.is_empty() {
            continue;
        }
        let cells =
            row.split(|c: char| ",;".contains(c) || c.is_whitespace()).filter(|cell| !cell.is_empty());
        let numbers: Result<Vec<f64>, _> = cells.map(str::parse).collect();
        match numbers.ok().and_then(|numbers| of(&numbers)) {
            Some(one) => found.push(one),
            None if number == 1 && row.chars().any(char::is_alphabetic) => {}
            None => return Err(format!("row {number} is not {form}: {row:.60}")),
        }
    }
    Ok(found)
}

/// Adds the lines of all geometries.
fn geojson(value: &Value, chains: &mut Vec<Vec<Point>>) -> Result<(), String> {
    let chain = |points: &Value| -> Option<Vec<Point>> {
        let point = |point: &Value| Some([point.get(0)?.as_f64()?, point.get(1)?.as_f64()?]);
        points.as_array()?.iter().map(point).collect()
    };
    let wrong = || "coordinates of a line are not a list of [x, y]".to_owned();
    let coordinates = &value["coordinates"];
    match value["type"].as_str() {
        Some("FeatureCollection") => {
            value["features"].as_array().into_iter().flatten().try_for_each(|of| geojson(of, chains))
        }
        Some("GeometryCollection") => {
            value["geometries"].as_array().into_iter().flatten().try_for_each(|of| geojson(of, chains))
        }
        Some("Feature") => geojson(&value["geometry"], chains),
        Some("LineString") => {
            chains.push(chain(coordinates).ok_or_else(wrong)?);
            Ok(())
        }
        Some("MultiLineString") => {
            for of in coordinates.as_array().ok_or_else(wrong)? {
                chains.push(chain(of).ok_or_else(wrong)?);
            }
            Ok(())
        }
        Some(other) => Err(format!("a {other} is no line: it has to be LineString or MultiLineString")),
        None => Err("it is not GeoJSON: an object has no \"type\"".to_owned()),
    }
}

/// The entities LINE and LWPOLYLINE of a DXF file: pairs of rows, a group code and its value.
fn dxf(text: &str) -> Result<Vec<Vec<Point>>, String> {
    let rows: Vec<&str> = text.lines().map(str::trim).collect();
    let (mut chains, mut entity, mut xs, mut ys, mut closed) =
        (Vec::new(), "", Vec::new(), Vec::new(), false);
    let mut entities = false;
    for (number, pair) in rows.chunks_exact(2).enumerate() {
        let code: u32 = pair[0].parse().map_err(|_| format!("row {}: no group code", 2 * number + 1))?;
        let value = || pair[1].parse::<f64>().map_err(|_| format!("row {}: no number", 2 * number + 2));
        match (code, entity) {
            (0, _) => {
                if ["LINE", "LWPOLYLINE"].contains(&entity) && entities {
                    let mut chain: Vec<Point> = xs.iter().zip(&ys).map(|(&x, &y)| [x, y]).collect();
                    chain.extend(chain.first().copied().filter(|_| closed));
                    chains.push(chain);
                }
                (entity, closed) = (pair[1], false);
                xs.clear();
                ys.clear();
            }
            (2, "SECTION") => entities = pair[1] == "ENTITIES",
            (10, "LINE" | "LWPOLYLINE") | (11, "LINE") => xs.push(value()?),
            (20, "LINE" | "LWPOLYLINE") | (21, "LINE") => ys.push(value()?),
            (70, "LWPOLYLINE") => closed = value()? as u32 % 2 == 1,
            _ => {}
        }
    }
    Ok(chains)
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
