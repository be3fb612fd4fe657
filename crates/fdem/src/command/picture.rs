//! A picture of a packing and its contact network, as SVG.

use std::io::{self, Write};

use crate::command::failure::Failure;
use crate::network::{Network, Sizes};

/// More elements than this are neither told apart nor opened by a browser.
const MAX_ELEMENTS: usize = 100_000;

/// Longer side of the picture, in pixels.
const SIDE: f64 = 900.0;

const MARGIN: f64 = 12.0;

/// Refuses what cannot be drawn.
pub(crate) fn check(elements: usize, file: &str) -> Result<(), Failure> {
    if elements > MAX_ELEMENTS {
        return Err(Failure::Unusable(format!(
            "{file}: {elements} elements are too many for --picture, which draws up to {MAX_ELEMENTS}"
        )));
    }
    Ok(())
}

/// Draws discs, or spheres from the front and a little from above, and a line for each couple coloured by its overlap.
///
/// What lies in front is drawn last.
pub(crate) fn draw<const D: usize>(out: &mut dyn Write, network: &Network<'_, D>) -> io::Result<()> {
    let Network { space, sizes, couples } = *network;
    let view = View::new(space.centres, sizes);
    let [width, height] = view.size;
    writeln!(
        out,
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.1} {height:.1}" width="{width:.1}" height="{height:.1}" stroke-linecap="round">"#
    )?;
    writeln!(out, r#"<rect width="100%" height="100%" fill="white"/>"#)?;
    writeln!(out, r##"<g fill="#dbe2ea" stroke="#8494a7" stroke-width="0.6">"##)?;
    for &index in &view.back_to_front {
        let ([x, y], r) = (view.at[index], sizes.radius(index) * view.scale);
        writeln!(out, r#"<circle cx="{x:.2}" cy="{y:.2}" r="{:.2}"/>"#, r.max(0.5))?;
    }
    writeln!(out, "</g>")?;

    // A line across a face of the box would lead to an image that is not drawn.
    let drawn = || couples.iter().filter(|couple| couple.shift == [0; D]);
    let largest = drawn().map(|couple| network.overlap(couple)).fold(f64::MIN_POSITIVE, f64::max);
    writeln!(out, r#"<g stroke-width="2.2">"#)?;
    for couple in drawn() {
        let ([x1, y1], [x2, y2]) = (view.at[couple.i as usize], view.at[couple.j as usize]);
        let colour = colour(network.overlap(couple) / largest);
        writeln!(out, r#"<path d="M{x1:.2} {y1:.2}L{x2:.2} {y2:.2}" stroke="{colour}"/>"#)?;
    }
    writeln!(out, "</g>\n</svg>")
}

/// Where the elements are on the paper.
struct View {
    at: Vec<[f64; 2]>,
    back_to_front: Vec<usize>,
    scale: f64,
    size: [f64; 2],
}

impl View {
    fn new<const D: usize>(centres: &[[f64; D]], sizes: Sizes<'_>) -> Self {
        let plane: Vec<[f64; 2]> = centres.iter().map(project).collect();
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for (index, point) in plane.iter().enumerate() {
            for axis in 0..2 {
                min[axis] = min[axis].min(point[axis] - sizes.radius(index));
                max[axis] = max[axis].max(point[axis] + sizes.radius(index));
            }
        }
        if plane.is_empty() {
            (min, max) = ([0.0; 2], [1.0; 2]);
        }
        let extent = [max[0] - min[0], max[1] - min[1]];
        let longest = extent[0].max(extent[1]);
        let scale = if longest > 0.0 { (SIDE - 2.0 * MARGIN) / longest } else { 1.0 };
        let mut back_to_front: Vec<usize> = (0..centres.len()).collect();
        back_to_front.sort_by(|&a, &b| depth(&centres[b]).total_cmp(&depth(&centres[a])));
        Self {
            at: plane
                .iter()
                .map(|[x, y]| [MARGIN + (x - min[0]) * scale, MARGIN + (max[1] - y) * scale])
                .collect(),
            back_to_front,
            scale,
            size: extent.map(|side| side * scale + 2.0 * MARGIN),
        }
    }
}

/// Sine and cosine of the two angles of the view in 3D: turned by 30 degrees, seen 20 degrees from above.
const TURN: [f64; 2] = [0.5, 0.866_025_403_784_438_6];
const TILT: [f64; 2] = [0.342_020_143_325_668_7, 0.939_692_620_785_908_4];

/// A point on the paper, y upwards: 2D as it is, 3D along parallel rays with z upwards.
fn project<const D: usize>(point: &[f64; D]) -> [f64; 2] {
    match *point.as_slice() {
        [x, y, z] => [TURN[1] * x + TURN[0] * y, TILT[1] * z + TILT[0] * (TURN[1] * y - TURN[0] * x)],
        [x, y] => [x, y],
        _ => unreachable!("files hold 2D or 3D"),
    }
}

/// Distance from the eye, up to a constant.
fn depth<const D: usize>(point: &[f64; D]) -> f64 {
    match *point.as_slice() {
        [x, y, z] => TILT[1] * (TURN[1] * y - TURN[0] * x) - TILT[0] * z,
        _ => 0.0,
    }
}

/// From pale to dark red with the share of the largest overlap.
fn colour(share: f64) -> String {
    const STOPS: [[f64; 3]; 4] =
        [[253.0, 204.0, 138.0], [252.0, 141.0, 89.0], [215.0, 48.0, 31.0], [122.0, 1.0, 20.0]];
    let place = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let stop = (place as usize).min(STOPS.len() - 2);
    let [r, g, b] = std::array::from_fn(|channel| {
        let (low, high) = (STOPS[stop][channel], STOPS[stop + 1][channel]);
        (low + (high - low) * (place - stop as f64)).round() as u8
    });
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::{Couples, Space};
    use fdem_contact::Couple;

    fn drawn<const D: usize>(centres: &[[f64; D]], radius: f64, couples: Vec<Couple>) -> String {
        let mut svg = Vec::new();
        let (space, couples) = (Space { centres, cell: None }, Couples::Plain(couples));
        draw(&mut svg, &Network { space, sizes: Sizes::All(radius), couples: &couples }).unwrap();
        String::from_utf8(svg).unwrap()
    }

    #[test]
    fn colours_run_from_pale_to_dark() {
        assert_eq!(colour(0.0), "#fdcc8a");
        assert_eq!(colour(1.0), "#7a0114");
        assert_eq!(colour(f64::NAN.max(0.0)), colour(0.0));
        assert_eq!(colour(-1.0), colour(0.0), "a gap within the tolerance");
    }

    #[test]
    fn every_element_and_couple_is_drawn_inside_the_picture() {
        let centres = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [9.0, 5.0, 2.0]];
        let svg = drawn(&centres, 0.5, vec![Couple::new(0, 1)]);
        assert_eq!(svg.matches("<circle").count(), 3);
        assert_eq!(svg.matches("<path").count(), 1);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        let view = View::new(&centres, Sizes::All(0.5));
        for [x, y] in view.at {
            assert!((0.0..=view.size[0]).contains(&x) && (0.0..=view.size[1]).contains(&y));
        }
    }

    #[test]
    fn nothing_and_one_point_can_be_drawn() {
        for centres in [vec![], vec![[1.0, 2.0]]] {
            assert!(!drawn(&centres, 0.0, Vec::new()).contains("NaN"));
        }
    }
}
