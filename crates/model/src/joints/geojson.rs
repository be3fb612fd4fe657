//! The geometries of GeoJSON files.

use std::collections::BTreeMap;

use serde_json::Value;

/// Geometries that are not used, by their kinds: points and labels, which exports have beside lines, and
/// features without a place.
pub(crate) type Unused = BTreeMap<&'static str, u64>;

/// Calls `add` with the type and the coordinates of each geometry, in order. Returns how many are not used.
///
/// # Errors
/// Text that is not GeoJSON, and the errors of `add`, with the number of the feature.
pub(crate) fn geometries(
    value: &Value,
    add: &mut impl FnMut(&str, &Value) -> Result<(), String>,
) -> Result<Unused, String> {
    let mut unused = Unused::new();
    walk(value, add, &mut unused).map(|()| unused)
}

fn walk(
    value: &Value,
    add: &mut impl FnMut(&str, &Value) -> Result<(), String>,
    unused: &mut Unused,
) -> Result<(), String> {
    let list = |kind: &str, list: &str| {
        value[list].as_array().ok_or_else(|| format!("a {kind} has no list \"{list}\""))
    };
    let mut leave_out = |kind| {
        *unused.entry(kind).or_default() += 1;
        Ok(())
    };
    match value["type"].as_str() {
        Some(kind @ "FeatureCollection") => {
            (1_u64..).zip(list(kind, "features")?).try_for_each(|(number, feature)| {
                walk(feature, add, unused).map_err(|why| format!("feature {number}: {why}"))
            })
        }
        Some(kind @ "GeometryCollection") => {
            list(kind, "geometries")?.iter().try_for_each(|geometry| walk(geometry, add, unused))
        }
        Some("Feature") if value["geometry"].is_null() => leave_out("Feature without geometry"),
        Some("Feature") => walk(&value["geometry"], add, unused),
        Some("Point") => leave_out("Point"),
        Some("MultiPoint") => leave_out("MultiPoint"),
        Some(kind) => add(kind, &value["coordinates"]),
        None => Err("it is not GeoJSON: an object has no \"type\"".to_owned()),
    }
}
