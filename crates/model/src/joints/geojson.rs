//! The geometries of GeoJSON files.

use serde_json::Value;

/// Calls `add` with the type and the coordinates of each geometry, in order.
pub(crate) fn geometries(
    value: &Value,
    add: &mut impl FnMut(&str, &Value) -> Result<(), String>,
) -> Result<(), String> {
    let mut each = |list: &str| {
        let list = value[list].as_array().into_iter().flatten();
        list.into_iter().try_for_each(|value| geometries(value, add))
    };
    match value["type"].as_str() {
        Some("FeatureCollection") => each("features"),
        Some("GeometryCollection") => each("geometries"),
        Some("Feature") => geometries(&value["geometry"], add),
        Some(kind) => add(kind, &value["coordinates"]),
        None => Err("it is not GeoJSON: an object has no \"type\"".to_owned()),
    }
}
