//! Small holes of surfaces from scans, which are closed on request.

use std::collections::BTreeMap;

use fdem_io::numbers::{brief, grouped};

pub(crate) type Corner = [f64; 3];

/// Closes the holes of a surface whose boxes are no wider than `width`, m: triangles from the edges of a hole
/// to the middle of its corners. Returns a note on the holes that were closed. Holes that meet in a corner
/// stay open.
pub(crate) fn close(triangles: &mut Vec<[Corner; 3]>, width: f64) -> Option<String> {
    let (mut closed, mut widest) = (0_u64, 0.0_f64);
    for hole in holes(triangles) {
        let across = self::width(&hole);
        if across > width {
            continue;
        }
        closed += 1;
        widest = widest.max(across);
        if let [a, b, c] = hole[..] {
            triangles.push([a, b, c]);
            continue;
        }
        let share = 1.0 / hole.len() as f64;
        let middle = [0, 1, 2].map(|axis| hole.iter().map(|corner| share * corner[axis]).sum());
        let next = hole.iter().cycle().skip(1);
        triangles.extend(hole.iter().zip(next).map(|(&from, &to)| [from, to, middle]));
    }
    let noun = if closed == 1 { "hole" } else { "holes" };
    (closed > 0)
        .then(|| format!("{} {noun} of its surface closed, the widest {} m", grouped(closed), brief(widest)))
}

/// Advice on the holes of a surface that `close_holes` would close; `None` if there are none.
pub(crate) fn words(triangles: &[[Corner; 3]]) -> Option<String> {
    let all = holes(triangles);
    let widest = all.iter().map(|hole| width(hole)).max_by(f64::total_cmp)?;
    let number = match all.len() {
        1 => "its hole".to_owned(),
        count => format!("its {} holes", grouped(count as u64)),
    };
    Some(format!(
        "close it in the program that made it; close_holes closes holes up to a width: {number}, the widest {} m",
        brief(widest)
    ))
}

/// Largest width of the box of a hole along the axes.
fn width(hole: &[Corner]) -> f64 {
    let [low, high] = fdem_mesh::bounds(hole.iter().copied());
    (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max)
}

/// The corners of each hole, in the order that triangles in it have.
fn holes(triangles: &[[Corner; 3]]) -> Vec<Vec<Corner>> {
    // 0 and -0 are one place.
    let key = |corner: Corner| corner.map(|x| (x + 0.0).to_bits());
    let mut edges: BTreeMap<[[u64; 3]; 2], i32> = BTreeMap::new();
    for &[a, b, c] in triangles {
        for [from, to] in [[a, b], [b, c], [c, a]].map(|edge| edge.map(key)) {
            *edges.entry([from, to]).or_default() += 1;
            *edges.entry([to, from]).or_default() -= 1;
        }
    }
    // An edge of one triangle alone is passed the other way by a triangle in the hole.
    let mut next: BTreeMap<[u64; 3], Vec<[u64; 3]>> = BTreeMap::new();
    for ([from, to], _) in edges.iter().filter(|(_, count)| **count < 0) {
        next.entry(*from).or_default().push(*to);
    }
    let mut found = Vec::new();
    while let Some((&start, _)) = next.iter().next() {
        let (mut corners, mut at) = (Vec::new(), start);
        let mut is_simple = true;
        while let Some(ends) = next.remove(&at) {
            is_simple &= ends.len() == 1;
            corners.push(at.map(f64::from_bits));
            at = ends[0];
        }
        if is_simple && at == start && corners.len() > 2 {
            found.push(corners);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of width 1; each face is a fan around its middle.
    fn cube() -> Vec<[Corner; 3]> {
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let corner = |k: usize| [k & 1, k >> 1 & 1, k >> 2].map(|x| x as f64);
        let fan = |quad: [usize; 4]| {
            let middle = [0, 1, 2].map(|axis| quad.iter().map(|&k| 0.25 * corner(k)[axis]).sum());
            (0..4).map(move |k| [corner(quad[k]), corner(quad[(k + 1) % 4]), middle])
        };
        quads.into_iter().flat_map(fan).collect()
    }

    fn volume(triangles: &[[Corner; 3]]) -> f64 {
        let six = |&[a, b, c]: &[Corner; 3]| {
            (0..3)
                .map(|k| a[k] * (b[(k + 1) % 3] * c[(k + 2) % 3] - b[(k + 2) % 3] * c[(k + 1) % 3]))
                .sum::<f64>()
        };
        triangles.iter().map(six).sum::<f64>() / 6.0
    }

    #[test]
    fn holes_up_to_a_width_are_closed() {
        let whole = cube();
        assert_eq!((holes(&whole).len(), volume(&whole)), (0, 1.0));
        // A triangle of the first face, and all of the last, which have no corner in common.
        let mut open: Vec<_> = whole[..20].to_vec();
        open.remove(3);
        let mut small = open.clone();
        assert_eq!(close(&mut small, 0.5), None, "each hole is 1 m wide");
        assert_eq!(small.len(), 19);
        let note = close(&mut open, 1.0).expect("two holes");
        assert_eq!(note, "2 holes of its surface closed, the widest 1 m");
        assert_eq!((open.len(), holes(&open).len()), (24, 0));
        assert!((volume(&open) - 1.0).abs() < 1e-12, "{}", volume(&open));
    }

    #[test]
    fn a_hole_larger_than_asked_stays_and_is_described() {
        let mut open = cube();
        // A triangle of the first face, and all of the last, which have no corner in common.
        open.truncate(20);
        open.remove(3);
        let advice = words(&open).expect("two holes");
        assert!(advice.ends_with("its 2 holes, the widest 1 m"), "{advice}");
        let small: Vec<_> =
            open.iter().map(|triangle| triangle.map(|corner| corner.map(|x| 0.1 * x))).collect();
        // The wide cube is ten times as large as the small one beside it.
        open.extend(small.iter().map(|triangle| triangle.map(|[x, y, z]| [x + 2.0, y, z])));
        assert_eq!(close(&mut open, 0.2).as_deref(), Some("2 holes of its surface closed, the widest 0.1 m"));
        assert!(words(&open).is_some_and(|advice| advice.ends_with("its 2 holes, the widest 1 m")));
        assert_eq!(words(&cube()), None);
    }

    #[test]
    fn a_hole_with_many_corners_is_closed() {
        const CORNERS: usize = 100;
        let at = |k: usize, z: f64| {
            let (sin, cos) = f64::sin_cos(std::f64::consts::TAU * (k % CORNERS) as f64 / CORNERS as f64);
            [cos, sin, z]
        };
        // A prism without its top.
        let mut prism = Vec::new();
        for k in 0..CORNERS {
            prism.push([at(k, 0.0), at(k + 1, 0.0), at(k + 1, 1.0)]);
            prism.push([at(k, 0.0), at(k + 1, 1.0), at(k, 1.0)]);
            prism.push([at(k + 1, 0.0), at(k, 0.0), [0.0; 3]]);
        }
        assert_eq!(close(&mut prism, 1.9), None);
        assert!(close(&mut prism, 2.0 + 1e-9).is_some());
        assert_eq!((prism.len(), holes(&prism).len()), (4 * CORNERS, 0));
        let base = 0.5 * CORNERS as f64 * (std::f64::consts::TAU / CORNERS as f64).sin();
        assert!((volume(&prism) - base).abs() < 1e-12, "{} {base}", volume(&prism));
    }

    #[test]
    fn holes_that_meet_in_a_corner_stay_open() {
        let mut open = cube();
        // Opposite triangles of one fan meet in its middle.
        open.remove(2);
        open.remove(0);
        assert_eq!(close(&mut open, 9.0), None);
    }
}
