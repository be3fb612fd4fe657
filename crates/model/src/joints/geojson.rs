//! The geometries of GeoJSON files.

use serde_json::Value;

/// Calls `add` with the type and the coordinates of each geometry, in order.
pub(crate) fn geometries(
    value: &Value,
    add: &mut impl FnMut(&str, &Value) -> Result<(), String>,
) -> Result<(), String> {
    let mut each = |kind: &str, list: &str| {
        let values = value[list].as_array().ok_or_else(|| format!("a {kind} has no list \"{list}\""))?;
        values.iter().try_for_each(|value| geometries(value, add))
    };
    match value["type"].as_str() {
        Some(kind @ "FeatureCollection") => each(kind, "features"),
        Some(kind @ "GeometryCollection") => each(kind, "geometries"),
        Some("Feature") => geometries(&value["geometry"], add),
        Some(kind) => add(kind, &value["coordinates"]),
        None => Err("it is not GeoJSON: an object has no \"type\"".to_owned()),
    }
}
