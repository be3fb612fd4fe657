//! Plots of the distributions of contacts, overlaps, sizes, directions and distances.

use fdem_io::numbers::{brief, grouped};

use crate::analysis::{Radial, RadialOptions, radial};
use crate::network::Network;
use crate::picture::colour::{HEAT, Rgb, SEA, hex};
use crate::picture::furniture::{self, HEAD};
use crate::picture::scene::Scene;
use crate::picture::svg::{Anchor, INK, PALE, Svg, shortened};
use crate::picture::ticks::{tick_texts, ticks};

/// Size of a panel with its axes and texts.
pub(crate) const WIDTH: f64 = 420.0;
pub(crate) const HEIGHT: f64 = 300.0;

const MARGIN: f64 = 24.0;
/// Margins of a histogram within its panel.
const LEFT: f64 = 66.0;
const TOP: f64 = 40.0;
const BOTTOM: f64 = 52.0;

/// Number of sectors in half a turn.
const SECTORS: usize = 18;

/// A plot of one distribution.
pub(crate) struct Panel {
    pub(crate) name: String,
    /// Description for screen readers.
    pub(crate) description: String,
    kind: Kind,
}

enum Kind {
    /// Bars from `edges[k]` to `edges[k + 1]`.
    Bars {
        edges: Vec<f64>,
        heights: Vec<u64>,
        across: String,
        up: &'static str,
        colour: Rgb,
        whole: bool,
    },
    /// Sectors of equal angle over half a turn, counter-clockwise from the right. With `both_sides`, they are
    /// repeated in the other half.
    Rose {
        radii: Vec<f64>,
        names: [&'static str; 2],
        ring: f64,
        ring_text: String,
        both_sides: bool,
    },
    /// A line through points, and a dashed line at 1.
    Curve {
        x: Vec<f64>,
        y: Vec<f64>,
        across: String,
    },
    Nothing(String),
}

/// Returns the plots of all distributions of a network.
pub(crate) fn panels(scene: &Scene, radial: &Result<Radial, String>) -> Vec<Panel> {
    let mut panels = vec![coordination(scene), overlap(scene), size(scene)];
    if scene.dimensions == 2 {
        panels.push(azimuth(scene, "directions of contacts"));
    } else {
        panels.push(azimuth(scene, "directions of contacts, seen along z"));
        panels.push(inclination(scene));
    }
    panels.push(distances(scene, radial));
    panels
}

/// Number of panels in a row.
const COLUMNS: usize = 3;

/// Size of the drawing of all distributions.
pub(crate) fn whole_size(scene: &Scene) -> [f64; 2] {
    let rows = count(scene).div_ceil(COLUMNS);
    [MARGIN * 2.0 + COLUMNS as f64 * WIDTH, HEAD + rows as f64 * HEIGHT + MARGIN]
}

/// Number of distributions.
fn count(scene: &Scene) -> usize {
    if scene.dimensions == 2 { 5 } else { 6 }
}

/// Draws all distributions as one SVG.
pub(crate) fn svg(scene: &Scene, radial: &Result<Radial, String>) -> String {
    let panels = panels(scene, radial);
    let [width, height] = whole_size(scene);
    let description: Vec<&str> = panels.iter().map(|panel| panel.description.as_str()).collect();
    let name = format!("Distributions of {}", scene.title);
    let mut svg = Svg::new(width, height, &name, &description.join(" "));
    svg.background();
    furniture::title(&mut svg, scene, MARGIN, width - 2.0 * MARGIN);
    for (k, panel) in panels.iter().enumerate() {
        // A row that is not full is centred.
        let in_row = COLUMNS.min(panels.len() - k / COLUMNS * COLUMNS);
        let left = MARGIN + (COLUMNS - in_row) as f64 * WIDTH / 2.0;
        let at = [left + (k % COLUMNS) as f64 * WIDTH, HEAD + (k / COLUMNS) as f64 * HEIGHT];
        panel.draw(&mut svg, at);
    }
    svg.finish()
}

impl Panel {
    /// Draws this panel alone.
    pub(crate) fn svg(&self) -> String {
        let mut svg = Svg::new(WIDTH, HEIGHT, &self.name, &self.description);
        self.draw(&mut svg, [0.0, 0.0]);
        svg.finish()
    }

    fn draw(&self, svg: &mut Svg, [x, y]: [f64; 2]) {
        svg.label([x + 8.0, y + 20.0], 13.5, Anchor::Start, INK, &self.name);
        match &self.kind {
            Kind::Bars { edges, heights, across, up, colour, whole } => {
                let bars = Bars { edges, heights, colour: *colour, whole: *whole };
                bars.draw(svg, [x + LEFT, y + TOP]);
                let middle = x + LEFT + (WIDTH - LEFT - 16.0) / 2.0;
                svg.label([middle, y + HEIGHT - 12.0], 12.0, Anchor::Middle, PALE, across);
                svg.label([x + WIDTH - 16.0, y + 20.0], 12.0, Anchor::End, PALE, up);
            }
            Kind::Rose { radii, names, ring, ring_text, both_sides } => {
                let rose = Rose { radii, names: *names, ring: *ring, both_sides: *both_sides };
                rose.draw(svg, [x + WIDTH / 2.0, y + HEIGHT / 2.0 + 6.0]);
                svg.label([x + WIDTH - 16.0, y + HEIGHT - 12.0], 11.5, Anchor::End, PALE, ring_text);
            }
            Kind::Curve { x: distances, y: values, across } => {
                curve(svg, [x + LEFT, y + TOP], distances, values);
                let middle = x + LEFT + (WIDTH - LEFT - 16.0) / 2.0;
                svg.label([middle, y + HEIGHT - 12.0], 12.0, Anchor::Middle, PALE, across);
                svg.label([x + WIDTH - 16.0, y + 20.0], 12.0, Anchor::End, PALE, "dashed: no structure");
            }
            Kind::Nothing(why) => {
                svg.label([x + WIDTH / 2.0, y + HEIGHT / 2.0], 12.5, Anchor::Middle, PALE, why);
            }
        }
    }
}

struct Bars<'a> {
    edges: &'a [f64],
    heights: &'a [u64],
    colour: Rgb,
    /// Whether values are integers, each in the middle of its bar.
    whole: bool,
}

impl Bars<'_> {
    fn draw(&self, svg: &mut Svg, [x, y]: [f64; 2]) {
        let (width, height) = (WIDTH - LEFT - 16.0, HEIGHT - TOP - BOTTOM);
        let (low, high) = (self.edges[0], self.edges[self.edges.len() - 1]);
        let tallest = self.heights.iter().copied().max().unwrap_or(0).max(1);
        let across = |value: f64| x + (value - low) / (high - low) * width;
        let up = |count: f64| y + height - count / tallest as f64 * height;
        for tick in ticks(0.0, tallest as f64, 4).into_iter().filter(|tick| tick.fract() == 0.0) {
            svg.put(format_args!(
                r##"<line class="grid" x1="{x:.1}" y1="{0:.1}" x2="{1:.1}" y2="{0:.1}" stroke="#e3e7eb" stroke-width="1"/>"##,
                up(tick),
                x + width
            ));
            svg.label([x - 7.0, up(tick) + 4.0], 11.0, Anchor::End, INK, &grouped(tick as u64));
        }
        for (pair, &count) in self.edges.windows(2).zip(self.heights) {
            if count > 0 {
                let (left, right) = (across(pair[0]), across(pair[1]));
                let gap = if right - left > 4.0 { 1.0 } else { 0.0 };
                let top = up(count as f64).min(y + height - 0.7);
                svg.rect(
                    [left + gap / 2.0, top],
                    [(right - left - gap).max(0.5), y + height - top],
                    self.colour,
                );
            }
        }
        svg.line([x, y + height], [x + width, y + height], 1.2, INK);
        let values = if self.whole { ticks((low + 0.5).ceil(), high - 0.5, 8) } else { ticks(low, high, 4) };
        let values: Vec<f64> = values.into_iter().filter(|tick| !self.whole || tick.fract() == 0.0).collect();
        let texts = if self.whole {
            values.iter().map(|&tick| grouped(tick as u64)).collect()
        } else {
            tick_texts(&values)
        };
        for (&tick, text) in values.iter().zip(texts) {
            svg.line([across(tick), y + height], [across(tick), y + height + 4.0], 1.0, INK);
            svg.label([across(tick), y + height + 17.0], 11.0, Anchor::Middle, INK, &text);
        }
    }
}

/// Draws a curve over distances from 0 on. `[x, y]`: upper left corner.
fn curve(svg: &mut Svg, [x, y]: [f64; 2], distances: &[f64], values: &[f64]) {
    let (width, height) = (WIDTH - LEFT - 16.0, HEIGHT - TOP - BOTTOM);
    // The last distance is the middle of the last bin, which ends half a bin later.
    let far = distances.last().map_or(1.0, |&last| last + distances[0]);
    let tallest = values.iter().copied().fold(1.0, f64::max) * 1.05;
    let across = |distance: f64| x + distance / far * width;
    let up = |value: f64| y + height - value / tallest * height;
    let marks = ticks(0.0, tallest, 4);
    for (&tick, text) in marks.iter().zip(tick_texts(&marks)) {
        svg.put(format_args!(
            r##"<line class="grid" x1="{x:.1}" y1="{0:.1}" x2="{1:.1}" y2="{0:.1}" stroke="#e3e7eb" stroke-width="1"/>"##,
            up(tick),
            x + width
        ));
        svg.label([x - 7.0, up(tick) + 4.0], 11.0, Anchor::End, INK, &text);
    }
    svg.put(format_args!(
        r#"<line class="ring" x1="{x:.1}" y1="{0:.1}" x2="{1:.1}" y2="{0:.1}" stroke="{INK}" stroke-dasharray="4 3"/>"#,
        up(1.0),
        x + width
    ));
    let points: Vec<String> = distances
        .iter()
        .zip(values)
        .map(|(&distance, &value)| format!("{:.1},{:.1}", across(distance), up(value)))
        .collect();
    svg.put(format_args!(
        r#"<polyline points="{}" fill="none" stroke="{}" stroke-width="1.6" stroke-linejoin="round"/>"#,
        points.join(" "),
        hex(SEA[8])
    ));
    svg.line([x, y + height], [x + width, y + height], 1.2, INK);
    let marks = ticks(0.0, far, 5);
    for (&tick, text) in marks.iter().zip(tick_texts(&marks)) {
        svg.line([across(tick), y + height], [across(tick), y + height + 4.0], 1.0, INK);
        svg.label([across(tick), y + height + 17.0], 11.0, Anchor::Middle, INK, &text);
    }
}

/// Returns the radial distribution of a network with the default options of `--analyse`, or the reason why it
/// cannot be given.
pub(crate) fn g_of_r<const D: usize>(network: &Network<'_, D>) -> Result<Radial, String> {
    /// Most pairs of centres: more would take longer than everything else.
    const MOST_PAIRS: f64 = 2e9;
    // The number of pairs within 3 mean diameters is about 3^D times the number within one.
    let (elements, contacts) = (network.space.centres.len() as f64, network.couples.len() as f64);
    if (contacts + elements / 2.0) * 3_f64.powf(D as f64) > MOST_PAIRS {
        return Err("too many pairs of centres".to_owned());
    }
    let found = radial::of_network(network, RadialOptions::default());
    found.unwrap_or_else(|error| Err(error.to_string()))
}

/// Plot of the radial distribution.
fn distances(scene: &Scene, radial: &Result<Radial, String>) -> Panel {
    let name = "radial distribution g(r)".to_owned();
    match radial {
        Ok(radial) => {
            let highest =
                (0..radial.g.len()).max_by(|&a, &b| radial.g[a].total_cmp(&radial.g[b])).unwrap_or(0);
            let description = format!(
                "Radial distribution function of the centres: its largest value is {:.4} at {}, up to a distance of {}.",
                radial.g.get(highest).copied().unwrap_or(0.0),
                brief(radial.r.get(highest).copied().unwrap_or(0.0)),
                brief(radial.r_max)
            );
            let across = format!("distance of centres{}", scene.after_name());
            Panel {
                name,
                description,
                kind: Kind::Curve { x: radial.r.clone(), y: radial.g.clone(), across },
            }
        }
        Err(why) => {
            let description = format!("No radial distribution: {why}.");
            Panel { name, description, kind: Kind::Nothing(shortened(why, 60)) }
        }
    }
}

struct Rose<'a> {
    radii: &'a [f64],
    names: [&'static str; 2],
    ring: f64,
    both_sides: bool,
}

impl Rose<'_> {
    fn draw(&self, svg: &mut Svg, [x, y]: [f64; 2]) {
        const RADIUS: f64 = 102.0;
        let largest = self.radii.iter().copied().fold(self.ring, f64::max);
        let point = |angle: f64, r: f64| {
            let r = r / largest * RADIUS;
            [x + r * angle.cos(), y - r * angle.sin()]
        };
        let step = std::f64::consts::PI / self.radii.len() as f64;
        let sides = if self.both_sides { 2 } else { 1 };
        for side in 0..sides {
            for (k, &radius) in self.radii.iter().enumerate() {
                let from = step * k as f64 + std::f64::consts::PI * f64::from(side);
                let ([x1, y1], [x2, y2]) = (point(from, radius), point(from + step, radius));
                let r = radius / largest * RADIUS;
                svg.put(format_args!(
                    r##"<path d="M{x:.1} {y:.1}L{x1:.1} {y1:.1}A{r:.1} {r:.1} 0 0 0 {x2:.1} {y2:.1}Z" fill="#058e99" class="sector" stroke="white" stroke-width="0.8"/>"##
                ));
            }
        }
        svg.put(format_args!(
            r#"<circle class="ring" cx="{x:.1}" cy="{y:.1}" r="{:.1}" fill="none" stroke="{INK}" stroke-dasharray="4 3"/>"#,
            self.ring / largest * RADIUS
        ));
        svg.line([x - RADIUS - 6.0, y], [x + RADIUS + 6.0, y], 0.8, PALE);
        svg.line([x, y - RADIUS - 6.0], [x, y + RADIUS + 6.0], 0.8, PALE);
        svg.label([x + RADIUS + 11.0, y + 4.0], 12.0, Anchor::Start, INK, self.names[0]);
        svg.label([x, y - RADIUS - 12.0], 12.0, Anchor::Middle, INK, self.names[1]);
    }
}

fn coordination(scene: &Scene) -> Panel {
    let [of_one, _, many] = scene.nouns();
    let name = format!("contacts of {of_one}");
    let Some(largest) = scene.coordination.iter().copied().max() else {
        return Panel { name, description: format!("No {many}."), kind: Kind::Nothing(format!("no {many}")) };
    };
    // A few large elements may have thousands of contacts; a bar then covers several numbers.
    let step = (largest / 60 + 1) as usize;
    let mut heights = vec![0_u64; largest as usize / step + 1];
    for &contacts in &scene.coordination {
        heights[contacts as usize / step] += 1;
    }
    let edges = (0..=heights.len()).map(|k| (k * step) as f64 - 0.5).collect();
    let commonest =
        (0..heights.len()).max_by_key(|&k| (heights[k], std::cmp::Reverse(k))).unwrap_or(0) * step;
    Panel {
        name,
        description: format!(
            "{} have 0 to {largest} contacts, {:.4} on average, most often {commonest}.",
            capital(many),
            scene.mean_coordination()
        ),
        kind: Kind::Bars {
            edges,
            heights,
            across: "contacts".to_owned(),
            up: many,
            colour: SEA[9],
            whole: true,
        },
    }
}

fn overlap(scene: &Scene) -> Panel {
    let values: Vec<f64> = scene.bonds.iter().map(|bond| bond.overlap).collect();
    let unit = if scene.value_is_length() { scene.after_name() } else { String::new() };
    histogram(&values, scene.value(), &unit, "contacts", HEAT[8])
}

fn size(scene: &Scene) -> Panel {
    if scene.are_points {
        let description = "The elements are points.".to_owned();
        return Panel {
            name: "radius".to_owned(),
            description,
            kind: Kind::Nothing("points have no radius".to_owned()),
        };
    }
    if scene.shapes.is_some() {
        let radii: Vec<f64> = scene.radii.iter().copied().filter(|&radius| radius > 0.0).collect();
        return histogram(&radii, "radius", &scene.after_name(), "bodies", SEA[10]);
    }
    histogram(&scene.radii, "radius", &scene.after_name(), "elements", SEA[10])
}

fn histogram(values: &[f64], name: &str, unit: &str, up: &'static str, colour: Rgb) -> Panel {
    const BINS: usize = 40;
    let across = format!("{name}{unit}");
    let name = name.to_owned();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if values.is_empty() {
        let description = format!("No {up}.");
        return Panel { name, description, kind: Kind::Nothing("none".to_owned()) };
    }
    let sum: f64 = values.iter().sum();
    let description = format!(
        "{} of {} {up}: from {} to {}, {} on average.",
        capital(&name),
        grouped(values.len() as u64),
        brief(low),
        brief(high),
        brief(sum / values.len() as f64)
    );
    // Values that differ only by rounding are drawn as one.
    let spread = (high - low).is_normal() && high - low > 1e-9 * high.abs().max(low.abs());
    let (from, to) = match (spread, high == 0.0) {
        (true, _) => (low, high),
        (false, true) => (-1.0, 1.0),
        (false, false) => (high - high.abs() / 2.0, high + high.abs() / 2.0),
    };
    let bins = if spread { BINS } else { 9 };
    let mut heights = vec![0_u64; bins];
    for &value in values {
        heights[(((value - from) / (to - from) * bins as f64) as usize).min(bins - 1)] += 1;
    }
    let edges = (0..=bins).map(|k| from + (to - from) * k as f64 / bins as f64).collect();
    Panel { name, description, kind: Kind::Bars { edges, heights, across, up, colour, whole: false } }
}

fn capital(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}

/// Plot of the directions of the contacts in the plane of x and y.
fn azimuth(scene: &Scene, name: &str) -> Panel {
    let mut counts = [0_u64; SECTORS];
    for bond in &scene.bonds {
        let [x, y, _] = bond.branch;
        if x != 0.0 || y != 0.0 {
            // Opposite directions are the same, so that half a turn is enough.
            let turn = y.atan2(x) / std::f64::consts::PI;
            let half = if turn < 0.0 { turn + 1.0 } else { turn };
            counts[(half * SECTORS as f64) as usize % SECTORS] += 1;
        }
    }
    let total: u64 = counts.iter().sum();
    let name = name.to_owned();
    if total == 0 {
        return Panel {
            name,
            description: "No directions of contacts.".to_owned(),
            kind: Kind::Nothing("none".to_owned()),
        };
    }
    let shares: Vec<f64> = counts.iter().map(|&count| count as f64 / total as f64).collect();
    let strongest = (0..SECTORS).max_by_key(|&k| (counts[k], std::cmp::Reverse(k))).unwrap_or(0);
    let width = 180 / SECTORS;
    let description = format!(
        "Most contacts, {:.1} %, lie between {} and {} degrees from x; without a preferred direction every sector has {:.1} %.",
        100.0 * shares[strongest],
        strongest * width,
        (strongest + 1) * width,
        100.0 / SECTORS as f64
    );
    Panel {
        name,
        description,
        kind: Kind::Rose {
            radii: shares,
            names: ["x", "y"],
            ring: 1.0 / SECTORS as f64,
            ring_text: "dashed: no preferred direction".to_owned(),
            both_sides: true,
        },
    }
}

/// Plot of the angle of the contacts to the plane of x and y, in bands of equal angle, each relative to
/// isotropic contacts.
fn inclination(scene: &Scene) -> Panel {
    const BANDS: usize = SECTORS / 2;
    let mut counts = [0_u64; BANDS];
    for bond in &scene.bonds {
        let [x, y, z] = bond.branch;
        let flat = (x * x + y * y).sqrt();
        if flat > 0.0 || z != 0.0 {
            let share = z.abs().atan2(flat) / std::f64::consts::FRAC_PI_2;
            counts[((share * BANDS as f64) as usize).min(BANDS - 1)] += 1;
        }
    }
    let total: u64 = counts.iter().sum();
    let name = "inclination of contacts to the plane of x and y".to_owned();
    if total == 0 {
        return Panel {
            name,
            description: "No directions of contacts.".to_owned(),
            kind: Kind::Nothing("none".to_owned()),
        };
    }
    let angle = |k: usize| std::f64::consts::FRAC_PI_2 * k as f64 / BANDS as f64;
    let density = |k: usize| counts[k] as f64 / total as f64 / (angle(k + 1).sin() - angle(k).sin());
    let bands: Vec<f64> = (0..BANDS).map(density).collect();
    // The other quarter is its mirror image, because opposite directions are the same and the azimuth has a
    // separate plot.
    let radii: Vec<f64> = bands.iter().chain(bands.iter().rev()).copied().collect();
    let description = format!(
        "Relative to isotropic contacts: {:.2} near the plane of x and y, {:.2} near z.",
        bands[0],
        bands[BANDS - 1]
    );
    Panel {
        name,
        description,
        kind: Kind::Rose {
            radii,
            names: ["x, y", "z"],
            ring: 1.0,
            ring_text: "dashed: no preferred direction".to_owned(),
            both_sides: true,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::{Couples, Network, Sizes, Space};
    use crate::picture::caption::Caption;
    use fdem_contact::Couple;

    fn scene(centres: &[[f64; 2]], couples: Vec<Couple>) -> Scene {
        let couples = Couples::Plain(couples);
        let space = Space { centres, cell: None };
        let network = Network { space, sizes: Sizes::All(0.5), couples: &couples, forces: None };
        Scene::new(&network, &Caption::default()).unwrap()
    }

    fn heights(panel: &Panel) -> &[u64] {
        let Kind::Bars { heights, .. } = &panel.kind else { panic!("no bars") };
        heights
    }

    #[test]
    fn a_row_points_along_x() {
        let centres: Vec<[f64; 2]> = (0..5).map(|k| [f64::from(k), 0.0]).collect();
        let scene = scene(&centres, (0..4).map(|k| Couple::new(k, k + 1)).collect());
        let panels = panels(&scene, &Err(String::new()));
        assert_eq!(heights(&panels[0]), [0, 2, 3]);
        assert_eq!(heights(&panels[1]).iter().sum::<u64>(), 4);
        let Kind::Rose { radii, .. } = &panels[3].kind else { panic!("no rose") };
        assert_eq!(radii[0], 1.0);
        assert_eq!(radii[1..], [0.0; SECTORS - 1]);
    }

    #[test]
    fn nothing_is_said_to_be_nothing() {
        for scene in [scene(&[], vec![]), scene(&[[1.0, 2.0]], vec![])] {
            let drawn = svg(&scene, &Err("there are no elements".to_owned()));
            assert!(!drawn.contains("NaN") && !drawn.contains("inf\""), "{drawn}");
        }
    }

    /// A square lattice has centres at the distances of the lattice and none between them.
    #[test]
    fn distances_of_a_lattice_are_peaks() {
        let centres: Vec<[f64; 2]> = (0..400).map(|k| [f64::from(k % 20), f64::from(k / 20)]).collect();
        let couples = Couples::Plain(vec![]);
        let space = Space { centres: &centres, cell: None };
        let network = Network { space, sizes: Sizes::All(0.5), couples: &couples, forces: None };
        let scene = Scene::new(&network, &Caption::default()).unwrap();
        let panels = panels(&scene, &g_of_r(&network));
        assert_eq!(panels.len(), count(&scene));
        let Kind::Curve { x, y, .. } = &panels[4].kind else { panic!("no curve") };
        let near =
            |r: f64| x.iter().zip(y).filter(|(x, _)| (*x - r).abs() < 0.03).map(|(_, y)| *y).sum::<f64>();
        assert!(near(1.0) > 5.0 && near(2_f64.sqrt()) > 5.0 && near(1.2) == 0.0, "{y:?}");
        assert!(svg(&scene, &g_of_r(&network)).contains("<polyline"));
    }

    /// Directions distributed evenly over the sphere make a circle.
    #[test]
    fn inclinations_of_all_directions_are_even() {
        let count = 40_000;
        let centres: Vec<[f64; 3]> = std::iter::once([0.0; 3])
            .chain((0..count).map(|k| {
                let z = (f64::from(k) + 0.5) / f64::from(count);
                let (r, a) = ((1.0 - z * z).sqrt(), f64::from(k) * 2.399_963);
                [r * a.cos(), r * a.sin(), z]
            }))
            .collect();
        let couples = Couples::Plain((1..=count as u32).map(|k| Couple::new(0, k)).collect());
        let space = Space { centres: &centres, cell: None };
        let network = Network { space, sizes: Sizes::Cutoff(1.1), couples: &couples, forces: None };
        let panel = inclination(&Scene::new(&network, &Caption::default()).unwrap());
        let Kind::Rose { radii, .. } = &panel.kind else { panic!("no rose") };
        assert!(radii.iter().all(|r| (r - 1.0).abs() < 0.01), "{radii:?}");
    }
}
