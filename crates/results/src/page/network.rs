//! Report of a network as an HTML page in one file, with a 3D view, distributions and a table.
//!
//! ```text
//! Network ──> Scene ──┬─> arrays, deflated, base64 ─┐
//!                     ├─> distributions as SVG ─────┼─> page.html with style.css and the scripts
//! facts ──────────────┴─> text and tables ──────────┘
//! ```
//! The page loads nothing over the network. Its content security policy allows only its own script and style,
//! by their hashes. Texts from outside, such as the name of a file, are also escaped.

mod arrays;

use std::cell::Cell;
use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use fdem_contact::{Couple, PeriodicCouple};
use fdem_io::numbers::{brief, grouped};
use serde_json::json;

use crate::analysis::Radial;
use crate::network::{Couples, Network, PairCutoffs, Sizes, Space};
use crate::page::{PageParts, STYLE, escape, rows};
use crate::picture::camera::outline;
use crate::picture::colour::{ALONE, HEAT, SEA};
use crate::picture::furniture::{Counts, counts};
use crate::picture::scene::Scene;
use crate::picture::{Bodies, Caption, PictureError, bodies, g_of_r, panels, preview, room};

/// Largest number of elements that a page of a network shows: of more, the part nearest to the middle.
pub const SHOWN_ELEMENTS: usize = 250_000;

/// Largest number of contacts that a page of a network shows: with more, fewer elements are shown.
pub const SHOWN_CONTACTS: usize = 2_000_000;

/// Largest number of bodies of any shape in a report: with more, a browser would run out of memory.
pub const MOST_BODIES: usize = 1_000_000;

/// Largest number of their contacts in a report: with more, a browser would run out of memory.
pub const MOST_CONTACTS: usize = 5_000_000;

const PAGE: &str = include_str!("network/page.html");
const SCRIPTS: [&str; 4] = [
    include_str!("network/data.js"),
    include_str!("network/view.js"),
    include_str!("network/table.js"),
    include_str!("network/main.js"),
];

/// Contents of a report.
///
/// # Shapes
/// `ids`: one per element, or `None` if elements are numbered from 0. `facts`: rows of the summary, each with
/// a name and a text. A row without a name continues the row before.
#[derive(Clone, Copy, Debug)]
pub struct NetworkReport<'a, const D: usize> {
    /// Elements and contacts.
    pub network: Network<'a, D>,
    /// Title and unit.
    pub caption: Caption<'a>,
    /// Ids of the elements.
    pub ids: Option<&'a [i64]>,
    /// The summary.
    pub facts: &'a [(&'a str, &'a str)],
}

/// Writes the report of a network as HTML.
///
/// Values of single elements and contacts are shown with all digits of their 64 bits.
///
/// If there are more than [`SHOWN_ELEMENTS`] elements, or more than [`SHOWN_CONTACTS`] contacts, the page
/// shows the elements nearest to the middle and the contacts between them, with a note. The radial
/// distribution is that of all elements.
///
/// # Errors
/// The errors of [`crate::picture::png()`].
///
/// # Panics
/// If a couple was not found among these elements, or the number of ids is not that of the elements.
///
/// # Cost
/// The page has about 60 bytes per element with three contacts.
///
/// # Example
/// ```
/// use fdem_contact::Couple;
/// use fdem_results::network::{Couples, Network, Sizes, Space};
/// use fdem_results::picture::Caption;
/// use fdem_results::page::network::{NetworkReport, html};
///
/// let centres = [[0.0, 0.0], [1.9, 0.0]];
/// let couples = Couples::Plain(vec![Couple::new(0, 1)]);
/// let space = Space { centres: &centres, cell: None };
/// let network = Network { space, sizes: Sizes::All(1.0), couples: &couples, forces: None };
/// let caption = Caption { title: "two <b>discs</b>", unit: None };
/// let page = html(&NetworkReport { network, caption, ids: None, facts: &[("elements", "2")] })?;
/// assert!(page.contains("two &lt;b&gt;discs"));
/// # Ok::<(), fdem_results::picture::PictureError>(())
/// ```
pub fn html<const D: usize>(report: &NetworkReport<'_, D>) -> Result<String, PictureError> {
    let NetworkReport { network, caption, ids, facts } = *report;
    let elements = network.space.centres.len();
    if let Some(ids) = ids {
        assert_eq!(ids.len(), elements, "every element has an id");
    }
    let radial = || g_of_r(&network);
    if elements <= SHOWN_ELEMENTS && network.couples.len() <= SHOWN_CONTACTS {
        return whole_page(report, radial);
    }
    // Places, ranks and counts of all elements.
    room::check(elements * (8 * D + 24))?;
    let part = Part::of(&network, [SHOWN_ELEMENTS, SHOWN_CONTACTS]);
    let shown = format!(
        "the {} of {} elements that are nearest to the middle, with the {} contacts between them, in the view, the \
         table and the plots but g(r); elements at the edge of this part lack contacts. The rows of this summary are of \
         all elements",
        grouped(part.numbers.len() as u64),
        grouped(elements as u64),
        grouped(part.couples.len() as u64),
    );
    let mut told = vec![("shown", shown.as_str())];
    told.extend(facts);
    let names: Vec<i64> = part
        .numbers
        .iter()
        .map(|&number| ids.map_or(i64::from(number), |ids| ids[number as usize]))
        .collect();
    let sizes = match (network.sizes, &part.pairs) {
        (Sizes::Each(_), _) => Sizes::Each(&part.radii),
        (Sizes::Pairs(_), Some(pairs)) => Sizes::Pairs(pairs),
        (sizes, _) => sizes,
    };
    let space = Space { centres: &part.centres, cell: network.space.cell };
    let shown = Network { space, sizes, couples: &part.couples, forces: part.forces.as_deref() };
    whole_page(&NetworkReport { network: shown, caption, ids: Some(&names), facts: &told }, radial)
}

/// The page of all elements of a report. `radial` is called once the elements can be drawn.
fn whole_page<const D: usize>(
    report: &NetworkReport<'_, D>,
    radial: impl FnOnce() -> Result<Radial, String>,
) -> Result<String, PictureError> {
    let NetworkReport { network, caption, ids, facts } = *report;
    let (elements, contacts) = (network.space.centres.len(), network.couples.len());
    let picture = room::of_pixels(room::LARGEST_PAGE, 1.0);
    room::check(room::of_scene(&network) + picture + page_bytes::<D>(elements, contacts))?;
    let scene = Scene::new(&network, &caption)?;
    // Ids that are numbers from 0 are not stored.
    let ids = ids.filter(|ids| ids.iter().enumerate().any(|(index, &id)| id != index.cast_signed() as i64));
    let data = data(&scene, &network, ids);
    let radial = radial();
    // The threads of the analysis have heaps of their own, which may keep address space.
    room::check(picture)?;
    page(&scene, &radial, facts, data)
}

/// The elements of a network that are nearest to its middle, and the contacts between them.
struct Part<const D: usize> {
    /// Numbers of the elements in the network, ascending.
    numbers: Vec<u32>,
    centres: Vec<[f64; D]>,
    /// Radii, if each element has its own.
    radii: Vec<f64>,
    /// Cut-offs by pairs of types, if the points have them.
    pairs: Option<PairCutoffs>,
    /// Couples by the numbers in the part.
    couples: Couples<D>,
    /// The force of each couple, if the forces are known.
    forces: Option<Vec<[f64; D]>>,
}

impl<const D: usize> Part<D> {
    /// A part of at most `most` elements and contacts, whose outline has the shape of that of the network.
    fn of(network: &Network<'_, D>, [most_elements, most_contacts]: [usize; 2]) -> Self {
        let space = &network.space;
        let places: Vec<[f64; D]> = match &space.cell {
            None => space.centres.to_vec(),
            Some(cell) => {
                (0..space.centres.len() as u32).map(|element| space.wrapped(cell, element).0).collect()
            }
        };
        let mut limits = [[f64::INFINITY, f64::NEG_INFINITY]; D];
        for place in &places {
            for ([low, high], x) in limits.iter_mut().zip(place) {
                (*low, *high) = (low.min(*x), high.max(*x));
            }
        }
        // The distance from the middle over that of the outline in this direction; it ascends with the rank.
        let distance = |element: &u32| {
            let place = &places[*element as usize];
            (0..D)
                .map(|axis| {
                    let [low, high] = limits[axis];
                    let half = (high - low) / 2.0;
                    if half > 0.0 { ((place[axis] - low) / half - 1.0).abs() } else { 0.0 }
                })
                .fold(0.0, f64::max)
        };
        let mut ranked: Vec<u32> = (0..places.len() as u32).collect();
        ranked.sort_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)));
        let mut rank = vec![0_u32; ranked.len()];
        for (at, &element) in (0..).zip(&ranked) {
            rank[element as usize] = at;
        }
        // A contact is in every part that has the outer of its two elements.
        let mut outer = vec![0_usize; ranked.len()];
        for couple in network.couples.iter() {
            outer[rank[couple.i as usize].max(rank[couple.j as usize]) as usize] += 1;
        }
        let contacts = outer.iter().scan(0, |sum: &mut usize, count| {
            *sum += count;
            Some(*sum)
        });
        let count = contacts.take(most_elements).take_while(|contacts| *contacts <= most_contacts).count();

        let mut numbers = ranked;
        numbers.truncate(count);
        numbers.sort_unstable();
        let is_in = |element: u32| (rank[element as usize] as usize) < count;
        let own = |element: u32| numbers.partition_point(|&number| number < element) as u32;
        let is_shown = |couple: &PeriodicCouple<D>| is_in(couple.i) && is_in(couple.j);
        let couples = network.couples.iter().filter(is_shown);
        let forces = network.forces.map(|forces| {
            let all = network.couples.iter().zip(forces);
            all.filter(|(couple, _)| is_shown(couple)).map(|(_, force)| *force).collect()
        });
        let couples = match network.couples {
            Couples::Plain(_) => {
                Couples::Plain(couples.map(|couple| Couple::new(own(couple.i), own(couple.j))).collect())
            }
            Couples::Periodic(_) => Couples::Periodic(
                couples
                    .map(|couple| PeriodicCouple { i: own(couple.i), j: own(couple.j), ..couple })
                    .collect(),
            ),
        };
        let centres = numbers.iter().map(|&number| space.centres[number as usize]).collect();
        let radii = match network.sizes {
            Sizes::Each(radii) => numbers.iter().map(|&number| radii[number as usize]).collect(),
            _ => Vec::new(),
        };
        let pairs = match network.sizes {
            Sizes::Pairs(pairs) => Some(pairs.among(&numbers)),
            _ => None,
        };
        Self { numbers, centres, radii, pairs, couples, forces }
    }
}

/// Contents of a report of bodies of any shape.
#[derive(Clone, Copy, Debug)]
pub struct BodiesReport<'a> {
    /// The bodies and their contacts.
    pub bodies: Bodies<'a>,
    /// Title and unit.
    pub caption: Caption<'a>,
    /// Ids of the bodies; `None` if they are numbered from 0.
    pub ids: Option<&'a [i64]>,
    /// Columns of the contacts, at most four: a name, and a value per contact. The values of the first column
    /// colour the contacts.
    pub columns: &'a [(&'a str, &'a [f64])],
    /// The summary.
    pub facts: &'a [(&'a str, &'a str)],
}

/// Writes the report of bodies as HTML: meshes, spheres with walls, or bodies of an image.
///
/// # Errors
/// Like [`html`]; [`PictureError::TooMany`] for more than [`MOST_BODIES`], [`MOST_CONTACTS`] or
/// [`crate::picture::MOST_FACETS`] triangles.
///
/// # Panics
/// If the number of ids is not that of the bodies, the length of a column is not the number of contacts, or
/// an index of a contact or a triangle is out of range.
///
/// # Example
/// ```
/// use fdem_results::picture::{Bodies, BodyJoint, Caption};
/// use fdem_results::page::network::{BodiesReport, bodies_html};
///
/// // Two spheres on a floor.
/// let joint = |bodies, point, normal| BodyJoint { bodies, point, normal, value: 0.0 };
/// let bodies = Bodies {
///     dimensions: 3,
///     centres: &[[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 0.0, 0.0]],
///     radii: &[1.0, 1.0, 0.0],
///     points: &[[-4.0, -4.0, 0.0], [8.0, -4.0, 0.0], [-4.0, 8.0, 0.0]],
///     facets: &[[0, 1, 2]],
///     owners: &[2],
///     walls: true,
///     joints: &[joint([0, 1], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]), joint([0, 2], [0.0; 3], [0.0, 0.0, -1.0])],
///     value: "depth",
/// };
/// let report =
///     BodiesReport { bodies, caption: Caption::default(), ids: None, columns: &[("depth", &[0.0, 0.0])], facts: &[] };
/// assert!(bodies_html(&report)?.contains("3 bodies"));
/// # Ok::<(), fdem_results::picture::PictureError>(())
/// ```
pub fn bodies_html(report: &BodiesReport<'_>) -> Result<String, PictureError> {
    let BodiesReport { bodies, caption, ids, columns, facts } = *report;
    let counts =
        [("bodies", bodies.centres.len(), MOST_BODIES), ("contacts", bodies.joints.len(), MOST_CONTACTS)];
    if let Some((what, found, most)) = counts.into_iter().find(|(_, found, most)| found > most) {
        return Err(PictureError::TooMany { what, found, most });
    }
    if let Some(ids) = ids {
        assert_eq!(ids.len(), bodies.centres.len(), "every body has an id");
    }
    let picture = room::of_pixels(room::LARGEST_PAGE, 1.0);
    let shapes = 24 * bodies.points.len() + 16 * bodies.facets.len();
    room::check(picture + page_bytes::<3>(bodies.centres.len(), 3 * bodies.joints.len()) + 5 * shapes)?;
    let scene = bodies::scene(&bodies, &caption)?;
    page(&scene, &bodies::no_radial(), facts, data_of_bodies(&scene, columns, ids))
}

/// Writes the page of a scene. `meta` describes the arrays in `data`.
fn page(
    scene: &Scene,
    radial: &Result<Radial, String>,
    facts: &[(&str, &str)],
    (meta, data): (String, String),
) -> Result<String, PictureError> {
    let data = Cell::new(data);
    let parts = PageParts {
        kind: "contact network",
        command: "fdem contacts --report",
        skip: ["elements-table", "Skip to the table of {{nouns}}"],
        main: PAGE,
        data: "<script type=\"text/plain\" id=\"data\">{{data}}</script>\n",
        style: STYLE.to_owned(),
        scripts: &SCRIPTS,
    };
    let [noun, _, nouns] = scene.nouns();
    let value = |name: &str| -> Result<String, PictureError> {
        Ok(match name {
            "title" => escape(&scene.title),
            "counts" => escape(&counts(scene)),
            "preview" => STANDARD.encode(preview(scene)?),
            "sentence" => escape(&sentence(scene)),
            "facts" => rows(facts),
            "plots" => plots(scene, radial),
            "noun" => noun.to_owned(),
            "nouns" => nouns.to_owned(),
            "value" => escape(scene.value()),
            "meta" => meta.clone(),
            // The data is by far the largest part. It occurs once, so it is moved.
            "data" => data.take(),
            _ => unreachable!("the page has no other places"),
        })
    };
    parts.page(value)
}

/// Most bytes that the arrays of a page take, with their compressed forms and the page itself.
fn page_bytes<const D: usize>(elements: usize, contacts: usize) -> usize {
    /// The arrays, twice their size during compression, and twice their size for the text and the page.
    const COPIES: usize = 5;
    COPIES * (elements * (8 * D + 16) + contacts * (16 + 8 * D))
}

/// Returns the description of the arrays of a network, and the packed arrays.
fn data<const D: usize>(scene: &Scene, network: &Network<'_, D>, ids: Option<&[i64]>) -> (String, String) {
    let count_of_numbers = scene.centres.len() * (D + 2) + scene.bonds.len() * (2 + D);
    let mut arrays = arrays::Arrays::default();
    arrays.bytes.reserve_exact(8 * count_of_numbers + 64);
    arrays.f64("centre", scene.centres.iter().flat_map(|centre| centre[..D].iter().copied()));
    let equal = scene.sizes.is_some_and(|[low, high]| low == high);
    let count = if equal { 1 } else { scene.centres.len() };
    arrays.f64("radius", (0..count).map(|index| network.sizes.radius(index)));
    arrays.f64("distance", scene.bonds.iter().map(|bond| bond.distance));
    // The page computes overlaps from radii, or from the one cut-off.
    if scene.of_forces || matches!(network.sizes, Sizes::Pairs(_)) {
        arrays.f64("overlap", scene.bonds.iter().map(|bond| bond.overlap));
    }
    if let Some(ids) = ids {
        arrays.i64("id", ids.iter().copied());
    }
    arrays.u32("i", scene.bonds.iter().map(|bond| bond.i));
    arrays.u32("j", scene.bonds.iter().map(|bond| bond.j));
    if network.space.cell.is_some() {
        arrays.f32("branch", scene.bonds.iter().flat_map(|bond| bond.branch[..D].iter().map(|&x| x as f32)));
        arrays.i32("shift", network.couples.iter().flat_map(|couple| couple.shift));
    }
    packed(
        scene,
        &arrays,
        ids.is_some(),
        json!({ "cutoff": network.sizes.cutoff(), "bodies": null, "facets": 0 }),
    )
}

/// Like [`data`], for bodies.
fn data_of_bodies(scene: &Scene, columns: &[(&str, &[f64])], ids: Option<&[i64]>) -> (String, String) {
    const NAMES: [&str; 4] = ["overlap", "second", "third", "fourth"];
    let d = scene.dimensions;
    let mut arrays = arrays::Arrays::default();
    arrays.f64("centre", scene.centres.iter().flat_map(|centre| centre[..d].iter().copied()));
    arrays.f64("radius", scene.radii.iter().copied());
    let mut told = Vec::new();
    for ((name, values), array) in columns.iter().zip(NAMES) {
        assert_eq!(values.len(), scene.bonds.len(), "every contact has a number in each column");
        arrays.f64(array, values.iter().copied());
        told.push(json!({ "name": name, "array": array }));
    }
    if let Some(ids) = ids {
        arrays.i64("id", ids.iter().copied());
    }
    arrays.u32("i", scene.bonds.iter().map(|bond| bond.i));
    arrays.u32("j", scene.bonds.iter().map(|bond| bond.j));
    let joints = || scene.bonds.iter().filter_map(|bond| bond.joint);
    arrays.f64("point", joints().flat_map(|joint| joint.point.into_iter().take(d)));
    arrays.u32("halves", joints().map(|joint| u32::from(joint.to[0]) | u32::from(joint.to[1]) << 1));
    let mut walls = false;
    let mut facets = 0;
    if let Some(shapes) = &scene.shapes {
        walls = shapes.walls;
        facets = shapes.facets.len();
        arrays.f64("corners", shapes.points.iter().flatten().copied());
        arrays.u32("facets", shapes.facets.iter().flatten().copied());
        arrays.u32("owner", shapes.owners.iter().copied());
    }
    let bodies = json!({ "walls": walls, "rod": rod(scene), "columns": told });
    packed(scene, &arrays, ids.is_some(), json!({ "cutoff": null, "bodies": bodies, "facets": facets }))
}

/// Width of the lines of the contacts of bodies: a part of the mean radius of the spheres, or without spheres
/// of the diagonal of all triangles.
fn rod(scene: &Scene) -> f64 {
    let spheres = || scene.radii.iter().copied().filter(|&radius| radius > 0.0);
    let count = spheres().count();
    if count > 0 {
        return 0.12 * spheres().sum::<f64>() / count as f64;
    }
    let mut limits = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for corner in scene.facets().flat_map(|(corners, _)| corners) {
        for ([low, high], x) in limits.iter_mut().zip(corner) {
            (*low, *high) = (low.min(x), high.max(x));
        }
    }
    let diagonal = limits.iter().map(|[low, high]| (high - low).max(0.0).powi(2)).sum::<f64>().sqrt();
    0.003 * diagonal
}

/// Returns the description of the arrays and of the scene, with `more`, and the packed arrays.
fn packed(scene: &Scene, arrays: &arrays::Arrays, ids: bool, more: serde_json::Value) -> (String, String) {
    let counts = Counts::new(&scene.coordination);
    let [noun, one, many] = scene.nouns();
    let mut meta = json!({
        "title": scene.title,
        "unit": scene.unit,
        "dimensions": scene.dimensions,
        "elements": scene.centres.len(),
        "noun": noun,
        "nouns": [one, many],
        "value": scene.value(),
        // Radius as drawn over radius.
        "drawn": scene.drawn,
        "sizes": scene.sizes,
        "overlaps": scene.overlaps.map(|o| json!({ "low": o.low, "high": o.high, "largest": o.largest })),
        "counts": { "high": counts.high, "largest": counts.largest },
        "heat": HEAT,
        "sea": SEA,
        "alone": ALONE,
        "alone_count": scene.alone(),
        "outline": outline(scene),
        "ids": ids,
        "bytes": arrays.bytes.len(),
        "arrays": arrays.index,
    });
    if let (Some(meta), serde_json::Value::Object(more)) = (meta.as_object_mut(), more) {
        meta.extend(more);
    }
    // A script element would end at "</script", so every "<" is escaped.
    let meta = meta.to_string().replace('<', "\\u003c");
    let deflated = miniz_oxide::deflate::compress_to_vec(&arrays.bytes, 6);
    (meta, STANDARD.encode(deflated))
}

fn sentence(scene: &Scene) -> String {
    let n = scene.centres.len();
    if n == 0 {
        return format!("There are no {}.", scene.nouns()[2]);
    }
    let mut text = format!(
        "{} {} in {}D have {} {}: {} touches {:.4} others on average",
        grouped(n as u64),
        scene.noun(),
        scene.dimensions,
        grouped(scene.bonds.len() as u64),
        if scene.bonds.len() == 1 { "contact" } else { "contacts" },
        scene.nouns()[0],
        scene.mean_coordination(),
    );
    if scene.alone() > 0 {
        text = format!("{text}, and {} of them {} none", grouped(scene.alone() as u64), touch(scene.alone()));
    }
    text.push('.');
    if let Some(overlaps) = scene.overlaps {
        let unit = if scene.value_is_length() { scene.after_number() } else { String::new() };
        text = format!("{text} The largest {} is {}{unit}.", scene.value(), brief(overlaps.largest));
    }
    text
}

fn touch(count: usize) -> &'static str {
    if count == 1 { "touches" } else { "touch" }
}

fn plots(scene: &Scene, radial: &Result<Radial, String>) -> String {
    let mut plots = String::new();
    for panel in panels(scene, radial) {
        let _ = write!(plots, "<figure>{}</figure>", panel.svg());
    }
    plots
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(title: &str, facts: &[(&str, &str)]) -> String {
        let centres = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [5.0, 5.0, 5.0]];
        let couples = Couples::Plain(vec![Couple::new(0, 1)]);
        let space = Space { centres: &centres, cell: None };
        let network = Network { space, sizes: Sizes::All(0.5), couples: &couples, forces: None };
        html(&NetworkReport { network, caption: Caption { title, unit: None }, ids: Some(&[7, 8, 9]), facts })
            .unwrap()
    }

    /// Texts from outside cannot add elements or attributes, or end the script.
    #[test]
    fn names_are_text() {
        let hostile = r#"</script><img src=x onerror="alert(1)">'{{script}}"#;
        let page = page(hostile, &[(hostile, hostile)]);
        assert!(!page.contains("<img src=x"));
        assert_eq!(page.matches("</script>").count(), 3);
        assert!(
            page.contains("&lt;/script&gt;&lt;img src=x onerror=&quot;alert(1)&quot;&gt;&#39;{{script}}")
        );
    }

    #[test]
    fn a_page_is_whole_and_asks_for_nothing() {
        let page = page("p.csv", &[]);
        assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
        assert!(!page.contains("{{") || page.contains("p.csv"));
        for address in ["http://", "https://"] {
            let named: Vec<&str> = page.split(address).skip(1).map(|rest| &rest[..10]).collect();
            assert!(named.iter().all(|name| name.starts_with("www.w3.org")), "{named:?}");
        }
        for handler in ["onclick=", "onload=", "javascript:", " style="] {
            assert!(!page.contains(handler), "{handler} would need a weaker policy");
        }
    }

    /// A row of discs, each of which touches the next.
    #[test]
    fn a_part_is_the_middle_with_its_contacts() {
        let centres: Vec<[f64; 2]> = (0..11).map(|k| [f64::from(k), 0.0]).collect();
        let radii: Vec<f64> = (0..11).map(|k| 0.5 + f64::from(k) / 100.0).collect();
        let couples = Couples::Plain((0..10).map(|k| Couple::new(k, k + 1)).collect());
        let space = Space { centres: &centres, cell: None };
        let network = Network { space, sizes: Sizes::Each(&radii), couples: &couples, forces: None };
        let part = Part::of(&network, [5, 100]);
        assert_eq!(part.numbers, [3, 4, 5, 6, 7]);
        assert_eq!((part.centres[0], part.radii[0]), ([3.0, 0.0], 0.53));
        assert_eq!(part.couples, Couples::Plain((0..4).map(|k| Couple::new(k, k + 1)).collect()));
        assert_eq!(Part::of(&network, [11, 2]).numbers, [4, 5, 6]);
    }

    #[test]
    fn a_page_of_very_many_shows_a_part_and_says_so() {
        let centres: Vec<[f64; 2]> = (0..=SHOWN_ELEMENTS).map(|k| [k as f64, 0.0]).collect();
        let couples = Couples::Plain(vec![]);
        let network = Network {
            space: Space { centres: &centres, cell: None },
            sizes: Sizes::All(0.25),
            couples: &couples,
            forces: None,
        };
        let facts = [("elements", "250,001")];
        let page =
            html(&NetworkReport { network, caption: Caption::default(), ids: None, facts: &facts }).unwrap();
        assert!(page.contains("the 250,000 of 250,001 elements that are nearest to the middle"));
    }
}
