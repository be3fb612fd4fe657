//! One figure for each of the other engines.

use std::error::Error;

use fdem_contact::{CGrid, Couple, Detector, Direct, Elements, Engine, Multilevel, Rows, Search};
use fdem_scenes::{Sizes, gas};

use super::cells::Frame;
use super::paper::{BODY, CENTRAL, COUPLE, FAINT, INK, NEIGHBOUR, Paper};

type Figure = Result<String, Box<dyn Error>>;

/// Every body with every other.
pub(crate) fn direct() -> Figure {
    let (centres, radius) = (gas::<2>(14, 5, 1.6, Sizes::Equal { radius: 0.5 })?.centres, 0.5);
    let mut couples = Vec::new();
    Direct.couples(&Elements::spheres(&centres, radius)?, &mut couples)?;
    let frame = around(&centres, radius, 62.0, [24.0, 52.0]);
    let mut paper = Paper::new();
    let n = centres.len();
    paper.text(
        [24.0, 26.0],
        15.0,
        "start",
        format_args!("{n} bodies: {} comparisons, {} contacts", n * (n - 1) / 2, couples.len()),
    );
    bodies(&mut paper, &frame, &centres, |_| radius, |_| BODY);
    for i in 0..n {
        for j in i + 1..n {
            frame.line(
                &mut paper,
                centres[i],
                centres[j],
                &format!("stroke=\"{FAINT}\" stroke-width=\"0.8\""),
            );
        }
    }
    lines(&mut paper, &frame, &centres, &couples);
    Ok(paper.svg(size(&frame), "All-against-all: a line for each comparison, red where the bodies touch", ""))
}

/// Sorted rows, and the windows of one body.
pub(crate) fn rows() -> Figure {
    let (centres, radius) = (gas::<2>(90, 11, 2.4, Sizes::Equal { radius: 0.5 })?.centres, 0.5);
    let elements = Elements::spheres(&centres, radius)?;
    let mut couples = Vec::new();
    Rows::new().couples(&elements, &mut couples)?;
    let edge = Rows::<f64, 2>::new().plan(&elements).cell_size();
    let frame = around(&centres, radius, 54.0, [24.0, 52.0]);
    let low = frame.origin.map(|x| x + radius);
    let row = |body: usize| ((centres[body][1] - low[1]) / edge).floor();

    // Where the search meets them: row by row, and along the rows.
    let mut order: Vec<usize> = (0..centres.len()).collect();
    order.sort_by(|&a, &b| row(a).total_cmp(&row(b)).then(centres[a][0].total_cmp(&centres[b][0])));
    let middle = frame.origin.map(|x| x + frame.size[0] / 2.0);
    let from = |body: &usize| (centres[*body][0] - middle[0]).hypot(centres[*body][1] - middle[1]);
    let central = *order.iter().min_by(|a, b| from(a).total_cmp(&from(b))).ok_or("no bodies")?;

    let mut paper = Paper::new();
    paper.text(
        [24.0, 26.0],
        15.0,
        "start",
        "Bodies sorted into rows and along them; orange looks only into two windows (blue)",
    );
    let [x, reach] = [centres[central][0], 2.0 * radius];
    let bottom = low[1] + row(central) * edge;
    let shade = format!("fill=\"{NEIGHBOUR}\" fill-opacity=\"0.35\"");
    frame.rect(&mut paper, [x, bottom], [reach, edge], &shade);
    frame.rect(&mut paper, [x - reach, bottom - edge], [2.0 * reach, edge], &shade);
    for k in 0..=((frame.size[1] - radius) / edge).floor() as u32 {
        let y = low[1] + f64::from(k) * edge;
        let style = format!("stroke=\"{FAINT}\" stroke-width=\"1\"");
        frame.line(&mut paper, [frame.origin[0], y], [frame.origin[0] + frame.size[0], y], &style);
    }
    let looked_at = |body: usize| {
        let distance = centres[body][0] - x;
        let own = row(body) == row(central) && (0.0..=reach).contains(&distance);
        own || (row(body) == row(central) - 1.0 && distance.abs() <= reach)
    };
    bodies(
        &mut paper,
        &frame,
        &centres,
        |_| radius,
        |body| {
            if body == central {
                CENTRAL
            } else if looked_at(body) {
                NEIGHBOUR
            } else {
                BODY
            }
        },
    );
    for pair in order.windows(2).filter(|pair| row(pair[0]) == row(pair[1])) {
        let style = format!("stroke=\"{INK}\" stroke-width=\"0.8\" stroke-dasharray=\"2 3\"");
        frame.line(&mut paper, centres[pair[0]], centres[pair[1]], &style);
    }
    let of_central: Vec<Couple> = couples
        .iter()
        .copied()
        .filter(|couple| {
            let other = if couple.i as usize == central { couple.j } else { couple.i };
            (couple.i as usize == central || couple.j as usize == central) && looked_at(other as usize)
        })
        .collect();
    lines(&mut paper, &frame, &centres, &of_central);
    Ok(paper.svg(size(&frame), "Sorted rows: a body is compared with those in two short windows", ""))
}

/// Levels of unlike sizes, each with its own cells.
pub(crate) fn multilevel() -> Figure {
    let sizes = Sizes::PowerLaw { min: 0.25, max: 3.2, exponent: -2.2 };
    let cloud = gas::<2>(150, 8, 1.4, sizes)?;
    let (centres, radii) = (&cloud.centres, &cloud.radii);
    let elements = Elements::spheres_with_radii(centres, radii)?;
    let mut search = Multilevel::new().with_limits(&[1.0, 3.0]);
    let levels = search.levels(&elements);
    let mut couples = Vec::new();
    search.couples(&elements, &mut couples)?;
    let largest = radii.iter().copied().fold(0.0, f64::max);
    let colours = [NEIGHBOUR, CENTRAL, "#a78bfa"];
    let level_of =
        |body: usize| levels.iter().position(|level| 2.0 * radii[body] <= level.largest).unwrap_or(0);

    let mut paper = Paper::new();
    let first = around(centres, largest, 11.0, [24.0, 78.0]);
    let step = first.size[0] * first.scale + 28.0;
    for (k, level) in levels.iter().enumerate() {
        let frame = Frame { at: [24.0 + step * k as f64, 78.0], ..first };
        let text = format!("level {}: {} bodies", k + 1, level.elements);
        paper.text([frame.at[0], 52.0], 13.0, "start", text);
        frame.grid(&mut paper, level.cell_size, [true, true]);
        bodies(
            &mut paper,
            &frame,
            centres,
            |body| radii[body],
            |body| {
                if level_of(body) == k { colours[k % colours.len()] } else { "none" }
            },
        );
    }
    let wide = Frame { at: [24.0 + step * levels.len() as f64, 78.0], ..first };
    paper.text(
        [wide.at[0], 52.0],
        13.0,
        "start",
        format_args!("{} contacts, within and between", couples.len()),
    );
    bodies(&mut paper, &wide, centres, |body| radii[body], |body| colours[level_of(body) % colours.len()]);
    lines(&mut paper, &wide, centres, &couples);
    paper.text([24.0, 26.0], 15.0, "start", "Levels of similar sizes, each with cells of its own size");
    let [_, height] = size(&first);
    let width = 24.0 + step * (levels.len() + 1) as f64;
    Ok(paper.svg([width, height], "Bodies of unlike sizes in levels, each with its own cells", ""))
}

/// Boxes in every cell that they cover.
pub(crate) fn cgrid() -> Figure {
    let min: [[f64; 2]; 6] = [[0.6, 2.6], [3.4, 2.3], [1.2, 3.5], [6.3, 0.5], [4.7, 4.3], [7.4, 3.2]];
    let max: [[f64; 2]; 6] = [[4.5, 3.3], [4.2, 5.5], [2.4, 4.4], [7.2, 4.6], [6.4, 5.3], [9.3, 4.0]];
    let elements = Elements::boxes(&min, &max)?;
    let mut couples = Vec::new();
    CGrid::new().couples(&elements, &mut couples)?;
    let mut same = Vec::new();
    Detector::new().with_engine(Engine::Direct).couples(&elements, &mut same)?;
    couples.sort_unstable();
    same.sort_unstable();
    assert_eq!(couples, same, "the figure shows what is true");

    let frame = Frame { origin: [0.0; 2], size: [10.0, 6.0], scale: 58.0, at: [24.0, 60.0] };
    let mut paper = Paper::new();
    let covered = 1;
    let cells = |axis: usize| min[covered][axis].floor() as u32..=max[covered][axis].floor() as u32;
    for (x, y) in cells(0).flat_map(|x| cells(1).map(move |y| (x, y))) {
        let style = format!("fill=\"{CENTRAL}\" fill-opacity=\"0.22\"");
        frame.rect(&mut paper, [f64::from(x), f64::from(y)], [1.0, 1.0], &style);
    }
    for couple in &couples {
        let [a, b] = [couple.i, couple.j].map(|k| min[k as usize]);
        let cell = [0, 1].map(|axis| a[axis].max(b[axis]).floor());
        frame.rect(&mut paper, cell, [1.0, 1.0], &format!("fill=\"{COUPLE}\" fill-opacity=\"0.45\""));
    }
    frame.grid(&mut paper, 1.0, [true, true]);
    for (low, high) in min.iter().zip(&max) {
        let style = format!("fill=\"{BODY}\" fill-opacity=\"0.75\" stroke=\"{INK}\" stroke-width=\"1.4\"");
        frame.rect(&mut paper, *low, [high[0] - low[0], high[1] - low[1]], &style);
        frame.circle(&mut paper, *low, 0.07, &format!("fill=\"{INK}\""));
    }
    let title = [
        "A box is in every cell that it covers (orange).",
        "Two are compared in one cell only, that of their larger minima (red).",
    ];
    paper.text([24.0, 22.0], 14.0, "start", title[0]);
    paper.text([24.0, 41.0], 14.0, "start", title[1]);
    Ok(paper.svg(size(&frame), &title.join(" "), ""))
}

/// The part of the plane that holds all bodies, at this scale and place.
fn around(centres: &[[f64; 2]], radius: f64, scale: f64, at: [f64; 2]) -> Frame {
    let side = |axis: usize, sign: f64| {
        centres.iter().map(|centre| sign * centre[axis]).fold(f64::INFINITY, f64::min)
    };
    let origin = [0, 1].map(|axis| side(axis, 1.0) - radius);
    let far = [0, 1].map(|axis| -side(axis, -1.0) + radius);
    Frame { origin, size: [far[0] - origin[0], far[1] - origin[1]], scale, at }
}

/// The sheet around a frame.
fn size(frame: &Frame) -> [f64; 2] {
    [0, 1].map(|axis| frame.at[axis] + frame.size[axis] * frame.scale + 24.0)
}

fn bodies<'a>(
    paper: &mut Paper,
    frame: &Frame,
    centres: &[[f64; 2]],
    radius: impl Fn(usize) -> f64,
    fill: impl Fn(usize) -> &'a str,
) {
    for (body, centre) in centres.iter().enumerate() {
        let fill = fill(body);
        let stroke = if fill == "none" { FAINT } else { INK };
        let style = format!("fill=\"{fill}\" fill-opacity=\"0.75\" stroke=\"{stroke}\" stroke-width=\"0.8\"");
        frame.circle(paper, *centre, radius(body), &style);
    }
}

fn lines(paper: &mut Paper, frame: &Frame, centres: &[[f64; 2]], couples: &[Couple]) {
    for couple in couples {
        let [a, b] = [couple.i, couple.j].map(|k| centres[k as usize]);
        frame.line(paper, a, b, &format!("stroke=\"{COUPLE}\" stroke-width=\"2\" stroke-linecap=\"round\""));
    }
}
