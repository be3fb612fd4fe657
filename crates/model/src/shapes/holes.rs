//! Small holes of surfaces from scans, which are closed on request.

use std::collections::BTreeMap;

use fdem_io::numbers::{brief, grouped};

type Corner = [f64; 3];

/// Closes the holes of a surface whose boxes are no wider than `width`, m: triangles from the edges of a hole
/// to the middle of its corners. Returns a note on the holes that were closed. Holes that meet in a corner
/// stay open.
pub(crate) fn close(triangles: &mut Vec<[Corner; 3]>, width: f64) -> Option<String> {
    let (mut closed, mut widest) = (0_u64, 0.0_f64);
    for hole in holes(triangles) {
        let [low, high] = fdem_mesh::bounds(hole.iter().copied());
        let across = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
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
    fn holes_that_meet_in_a_corner_stay_open() {
        let mut open = cube();
        // Opposite triangles of one fan meet in its middle.
        open.remove(2);
        open.remove(0);
        assert_eq!(close(&mut open, 9.0), None);
    }
}
