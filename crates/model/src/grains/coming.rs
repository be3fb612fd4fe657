//! Spheres of `[[insertion]]`, and the boxes of `[[delete]]`.

use std::f64::consts::PI;

use fdem_io::numbers::brief;
use fdem_simulation::grains::{Insertion, Removal};

use crate::grains::spheres::{in_space, sizes};
use crate::prepared::{ComingSpheres, PreparedRemoval};
use crate::text::fault::Problem;
use crate::text::file::{BoxRegion, ModelFile, SphereInsertion, SphereRemoval, Spin};

/// Spheres that an insertion has at most.
const MOST: f64 = 2e7;

/// The spheres of a table that come in. `[material, group]`: their numbers; `density`: kg/m³. The table has
/// been checked.
pub(crate) fn insertion(
    file: &ModelFile,
    table: &SphereInsertion,
    discs: bool,
    (density, [material, group]): (f64, [u32; 2]),
) -> Result<(Insertion, ComingSpheres), Problem> {
    let thickness = if discs { file.model.thickness } else { 1.0 };
    let sizes = sizes(&table.radius);
    let count = match (table.count, table.mass) {
        (Some(count), _) => count,
        (None, mass) => {
            let of_one = density * thickness * sizes.mean_measure(discs);
            count_of(mass.unwrap_or(0.0), of_one).map_err(|problem| Problem {
                message: format!("[[insertion]] \"{}\": {}", table.name, problem.message),
                ..problem
            })?
        }
    };
    let radii = sizes.draw(count, discs, table.seed);
    let volume = |&radius: &f64| {
        let disc = PI * radius * radius;
        if discs { disc * thickness } else { 4.0 / 3.0 * disc * radius }
    };
    let mass = density * radii.iter().map(volume).sum::<f64>();
    let of_mass = table.mass_rate.map(|rate| rate * count as f64 / mass);
    let rate = table.rate.or(of_mass);
    let range = radii.iter().fold([f64::INFINITY, 0.0], |[a, b]: [f64; 2], &r| [a.min(r), b.max(r)]);
    let of = Insertion {
        name: table.name.clone(),
        region: region(&table.within),
        radii,
        from: table.from,
        rate: rate.unwrap_or(f64::INFINITY),
        velocity: table.velocity.as_ref().map_or([0.0; 3], in_space),
        spin: table.spin.map_or([0.0; 3], Spin::vector),
        material,
        group,
        seed: table.seed,
    };
    let coming = ComingSpheres {
        name: table.name.clone(),
        count,
        radii: range,
        mass,
        from: table.from,
        rate,
        by_end: of.due(file.model.end_time),
    };
    Ok((of, coming))
}

/// The number of spheres that have this mass, kg; `of_one`: the mean mass of one, kg.
fn count_of(mass: f64, of_one: f64) -> Result<usize, Problem> {
    let count = (mass / of_one).round();
    if count > MOST {
        let message = format!("it would have about {count:.2e} spheres, and may have {MOST:.0e}");
        let help = format!("one of them has a mass of {} kg", brief(of_one));
        return Err(Problem { help: Some(help), ..Problem::new("mass", message) });
    }
    if count < 1.0 {
        let message = format!("one sphere has more mass than that, {} kg", brief(of_one));
        let help = "take more mass, or smaller spheres".to_owned();
        return Err(Problem { help: Some(help), ..Problem::new("mass", message) });
    }
    Ok(count as usize)
}

/// The box of a table in which spheres are removed.
pub(crate) fn removal(table: &SphereRemoval) -> (Removal, PreparedRemoval) {
    let times = [table.from, table.until.unwrap_or(f64::INFINITY)];
    let of = Removal { name: table.name.clone(), region: region(&table.within), times };
    (of, PreparedRemoval { name: table.name.clone(), from: table.from, until: table.until })
}

/// Insertions from which nothing comes until the end of the run, and boxes that remove nothing until then.
pub(crate) fn without_effect(file: &ModelFile) -> Vec<String> {
    let end = file.model.end_time;
    let late = |table: &str, name: &str, words: &str| {
        format!("[[{table}]] \"{name}\" {words}: it begins after the end of the run, {} s", brief(end))
    };
    let insertions = file.insertion.iter().filter(|of| of.from > end);
    let removals = file.delete.iter().filter(|of| of.from > end);
    insertions
        .map(|of| late("insertion", &of.name, "brings no sphere"))
        .chain(removals.map(|of| late("delete", &of.name, "removes nothing")))
        .collect()
}

/// Share of a box that spheres and discs at random places fill, beyond which some find no room.
const FULL: [f64; 2] = [0.6, 0.8];

/// Warnings of insertions that are to come in at once, and that their boxes cannot hold.
pub(crate) fn without_room(file: &ModelFile, insertions: &[Insertion], discs: bool) -> Vec<String> {
    let axes = if discs { 2 } else { 3 };
    let tables = file.insertion.iter().zip(insertions);
    let at_once = tables.filter(|(table, _)| table.rate.is_none() && table.mass_rate.is_none());
    at_once
        .filter_map(|(table, of)| {
            let [low, high] = of.region;
            let room: f64 = (0..axes).map(|axis| high[axis] - low[axis]).product();
            let measure = |&r: &f64| if discs { PI * r * r } else { 4.0 / 3.0 * PI * r * r * r };
            let share = of.radii.iter().map(measure).sum::<f64>() / room;
            (share > FULL[usize::from(discs)]).then(|| {
                format!(
                    "[[insertion]] \"{}\": the spheres have {:.0} % of the volume of its box and come in at once: those \
                     that find no room wait until others have left it",
                    table.name,
                    100.0 * share
                )
            })
        })
        .collect()
}

/// The corners of a box in space.
fn region(within: &BoxRegion) -> [[f64; 3]; 2] {
    [in_space(&within.min), in_space(&within.max)]
}
