//! Parts around a drawing: title, colour bars, scale bar, axes.

use fdem_io::numbers::{brief, grouped};

use crate::picture::colour::{ALONE, HEAT, Rgb, SEA, at};
use crate::picture::scene::{OverlapRange, Scene};
use crate::picture::svg::{Anchor, INK, PALE, Svg};
use crate::picture::text::{OF_TITLES, fitting};
use crate::picture::ticks::{round_below, tick_texts, ticks};

/// Height of the space above the drawing, and below it.
pub(crate) const HEAD: f64 = 66.0;
pub(crate) const FOOT: f64 = 74.0;

/// Width of a colour bar.
pub(crate) const BAR: f64 = 230.0;

/// Range of the numbers of contacts in the colour bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) high: u32,
    pub(crate) largest: u32,
}

impl Counts {
    /// Ends the colours at the number that 99.5 % of the elements do not exceed, because a few large elements
    /// would leave the others with nearly one colour.
    pub(crate) fn new(coordination: &[u32]) -> Self {
        let mut sorted = coordination.to_vec();
        let Some(last) = sorted.len().checked_sub(1) else { return Self { high: 1, largest: 0 } };
        let (_, &mut high, _) = sorted.select_nth_unstable((last as f64 * 0.995) as usize);
        let largest = sorted.iter().copied().max().unwrap_or(0);
        Self { high: if largest <= high + 2 { largest } else { high }.max(1), largest }
    }

    pub(crate) fn colour(self, contacts: u32) -> Rgb {
        if contacts == 0 {
            return ALONE;
        }
        at(&SEA, f64::from(contacts - 1) / f64::from(self.high.max(2) - 1))
    }
}

/// Line with the numbers of elements and contacts.
pub(crate) fn counts(scene: &Scene) -> String {
    let n = scene.centres.len();
    let mut text = format!(
        "{} {}, {} {}, {:.4} per {}",
        grouped(n as u64),
        scene.noun(),
        grouped(scene.bonds.len() as u64),
        if scene.bonds.len() == 1 { "contact" } else { "contacts" },
        scene.mean_coordination(),
        scene.nouns()[1],
    );
    if scene.alone() > 0 {
        text = format!("{text}, {} without", grouped(scene.alone() as u64));
    }
    text
}

pub(crate) fn title(svg: &mut Svg, scene: &Scene, x: f64, width: f64) {
    let (title, size) = fitting(&scene.title, width, OF_TITLES, true);
    svg.bold([x, 30.0], size, &title);
    svg.label([x, 51.0], 12.5, Anchor::Start, PALE, &counts(scene));
}

/// Draws a scale bar of a round length. `unit` follows the number.
pub(crate) fn scale_bar(svg: &mut Svg, unit: &str, [x, y]: [f64; 2], scale: f64) {
    let length = round_below(150.0 / scale);
    let width = length * scale;
    if !(1.0..=200.0).contains(&width) {
        return;
    }
    svg.line([x, y + 20.0], [x + width, y + 20.0], 2.0, INK);
    for end in [x, x + width] {
        svg.line([end, y + 15.0], [end, y + 25.0], 1.2, INK);
    }
    let text = format!("{}{unit}", brief(length));
    svg.label([x, y + 42.0], 12.0, Anchor::Start, INK, &text);
}

/// Draws the directions of the axes.
pub(crate) fn axes(svg: &mut Svg, [x, y]: [f64; 2], axes: &[(&str, [f64; 2])]) {
    for (name, [dx, dy]) in axes {
        let tip = [x + 26.0 * dx, y + 26.0 * dy];
        svg.line([x, y], tip, 1.6, INK);
        svg.label([x + 36.0 * dx, y + 36.0 * dy + 4.0], 11.5, Anchor::Middle, INK, name);
    }
}

/// Draws the colour bar of the overlaps, aligned to the right.
pub(crate) fn overlap_bar(svg: &mut Svg, name: &str, overlaps: OverlapRange, [right, y]: [f64; 2]) {
    let OverlapRange { low, high, largest } = overlaps;
    let x = right - BAR;
    svg.label([x, y + 10.0], 12.0, Anchor::Start, INK, name);
    if largest > high {
        svg.label([right, y + 10.0], 11.0, Anchor::End, PALE, &format!("largest {}", brief(largest)));
    }
    if high <= low {
        svg.rect([x, y + 18.0], [BAR, 13.0], at(&HEAT, 0.5));
        svg.label([x + BAR / 2.0, y + 46.0], 11.5, Anchor::Middle, INK, &brief(high));
        return;
    }
    strips(svg, [x, y], |share| at(&HEAT, share));
    let ticks = ticks(low, high, 4);
    for (tick, text) in ticks.iter().zip(tick_texts(&ticks)) {
        let share = (tick - low) / (high - low);
        svg.line([x + share * BAR, y + 31.0], [x + share * BAR, y + 35.0], 1.0, INK);
        svg.label([x + share * BAR, y + 47.0], 11.5, Anchor::Middle, INK, &text);
    }
    if largest > high {
        svg.label([right + 4.0, y + 29.0], 11.5, Anchor::Start, INK, "+");
    }
}

/// Draws the colour bar of the numbers of contacts, aligned to the right. `noun`: element or body, with its
/// article.
pub(crate) fn coordination_bar(svg: &mut Svg, noun: &str, counts: Counts, [right, y]: [f64; 2]) {
    let x = right - BAR;
    svg.label([x, y + 10.0], 12.0, Anchor::Start, INK, &format!("contacts of {noun}"));
    let high = counts.high;
    if counts.largest > high {
        let largest = format!("largest {}", grouped(u64::from(counts.largest)));
        svg.label([right, y + 10.0], 11.0, Anchor::End, PALE, &largest);
    }
    let over = |count: u32| if count == high && counts.largest > high { "+" } else { "" };
    if high <= 15 {
        let width = BAR / f64::from(high + 1);
        for count in 0..=high {
            let at = x + width * f64::from(count);
            svg.rect([at, y + 18.0], [width - 1.0, 13.0], counts.colour(count));
            let text = format!("{count}{}", over(count));
            svg.label([at + width / 2.0, y + 47.0], 11.5, Anchor::Middle, INK, &text);
        }
        return;
    }
    strips(svg, [x, y], |share| counts.colour((share * f64::from(high)).round() as u32));
    for tick in ticks(0.0, f64::from(high), 4).into_iter().filter(|tick| tick.fract() == 0.0) {
        let share = tick / f64::from(high);
        svg.line([x + share * BAR, y + 31.0], [x + share * BAR, y + 35.0], 1.0, INK);
        svg.label([x + share * BAR, y + 47.0], 11.5, Anchor::Middle, INK, &grouped(tick as u64));
    }
}

/// Draws the colours of a bar, 18 units below its upper left corner.
pub(crate) fn strips(svg: &mut Svg, [x, y]: [f64; 2], colour: impl Fn(f64) -> Rgb) {
    const STRIPS: usize = 64;
    for strip in 0..STRIPS {
        // Each strip reaches to the right end and is covered by the next ones, so that there are no gaps.
        let left = BAR * strip as f64 / STRIPS as f64;
        let share = (strip as f64 + 0.5) / STRIPS as f64;
        svg.rect([x + left, y + 18.0], [BAR - left, 13.0], colour(share));
    }
}
