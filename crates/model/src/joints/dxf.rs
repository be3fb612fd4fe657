//! The entities of DXF files in ASCII that have corners.

/// A LINE, 3DFACE, POLYLINE or LWPOLYLINE.
#[derive(Debug, Default)]
pub(crate) struct Entity<'a> {
    pub(crate) kind: &'a str,
    /// Corners, m, in order. A triangle has its last one twice.
    pub(crate) corners: Vec<[f64; 3]>,
    /// Whether a polyline ends where it begins.
    pub(crate) is_closed: bool,
    /// Height of all corners, m, for an LWPOLYLINE.
    elevation: f64,
}

impl Entity<'_> {
    fn set(&mut self, corner: usize, axis: usize, value: f64) {
        if self.corners.len() <= corner {
            self.corners.resize(corner + 1, [0.0; 3]);
        }
        self.corners[corner][axis] = value;
    }

    fn set_last(&mut self, axis: usize, value: f64) {
        self.set(self.corners.len().saturating_sub(1), axis, value);
    }
}

/// The entities of the section ENTITIES. A file is a list of pairs of rows, a group code and its value.
pub(crate) fn entities(text: &str) -> Result<Vec<Entity<'_>>, String> {
    let rows: Vec<&str> = text.lines().map(str::trim).collect();
    let mut all = Vec::new();
    let mut entity = Entity::default();
    let (mut in_section, mut in_vertex) = (false, false);
    for (number, pair) in rows.chunks_exact(2).enumerate() {
        let code: u32 = pair[0].parse().map_err(|_| format!("row {}: no group code", 2 * number + 1))?;
        let value = || pair[1].parse::<f64>().map_err(|_| format!("row {}: no number", 2 * number + 2));
        let axis = (code / 10).saturating_sub(1) as usize;
        match (code, entity.kind) {
            // Vertices follow their polyline.
            (0, "POLYLINE") if pair[1] == "VERTEX" => {
                in_vertex = true;
                entity.corners.push([0.0; 3]);
            }
            (0, _) => {
                let mut last = std::mem::replace(&mut entity, Entity { kind: pair[1], ..Entity::default() });
                in_vertex = false;
                if in_section && ["LINE", "3DFACE", "POLYLINE", "LWPOLYLINE"].contains(&last.kind) {
                    if last.kind == "LWPOLYLINE" {
                        last.corners.iter_mut().for_each(|corner| corner[2] = last.elevation);
                    }
                    all.push(last);
                }
            }
            (2, "SECTION") => in_section = pair[1] == "ENTITIES",
            (10..=13 | 20..=23 | 30..=33, "LINE" | "3DFACE") => {
                entity.set((code % 10) as usize, axis, value()?);
            }
            (10, "LWPOLYLINE") => entity.corners.push([value()?, 0.0, 0.0]),
            (20, "LWPOLYLINE") => entity.set_last(1, value()?),
            (38, "LWPOLYLINE") => entity.elevation = value()?,
            (10 | 20 | 30, "POLYLINE") if in_vertex => entity.set_last(axis, value()?),
            (70, "LWPOLYLINE") => entity.is_closed = value()? as u32 % 2 == 1,
            (70, "POLYLINE") if !in_vertex => entity.is_closed = value()? as u32 % 2 == 1,
            _ => {}
        }
    }
    Ok(all)
}
