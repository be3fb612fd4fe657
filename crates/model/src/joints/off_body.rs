//! Advice for joint sets whose lines or polygons are not where the bodies are.

use fdem_io::numbers::brief;

/// Units that are mistaken for each other: length of one in the other.
const UNITS: [f64; 4] = [1e-3, 1e3, 1e-2, 1e2];

/// Width over that of the bodies from which, and below one over which, lines are in another unit.
const UNLIKE: f64 = 10.0;

/// Least and largest coordinates, m.
pub(crate) type Limits = [Vec<f64>; 2];

/// The box of points; `None` without any.
pub(crate) fn around(mut points: impl Iterator<Item = Vec<f64>>) -> Option<Limits> {
    let first = points.next()?;
    let with = |[mut low, mut high]: Limits, point: Vec<f64>| {
        for (axis, x) in point.into_iter().enumerate() {
            low[axis] = low[axis].min(x);
            high[axis] = high[axis].max(x);
        }
        [low, high]
    };
    Some(points.fold([first.clone(), first], with))
}

/// Advice for a set without joints; `None` if its shapes may be in the bodies. `shapes`: box of its lines or
/// polygons. `bodies`: box of the bodies. `scale`: length of the unit of its file, m; `None` if the set is
/// not from a file.
pub(crate) fn advice(shapes: &Limits, bodies: &Limits, scale: Option<f64>) -> Option<String> {
    let of_bodies = width(bodies);
    let scaled = |factor: f64| -> Limits {
        shapes.each_ref().map(|corner| corner.iter().map(|x| factor * x).collect())
    };
    let unlikeness = |factor: f64| (factor * width(shapes) / of_bodies).ln().abs();
    let is_alike = |factor: f64| unlikeness(factor) <= UNLIKE.ln() && meet(&scaled(factor), bodies);
    if is_alike(1.0) {
        return None;
    }
    let factor = UNITS.into_iter().filter(|&factor| is_alike(factor));
    let factor = factor.min_by(|&a, &b| unlikeness(a).total_cmp(&unlikeness(b)));
    let unit = match (factor, scale) {
        (Some(factor), Some(1.0)) => format!(": if the file has another unit, say scale = {}", brief(factor)),
        (Some(factor), Some(scale)) => {
            format!(
                ": if the unit of the file is another, say scale = {}, not {}",
                brief(factor * scale),
                brief(scale)
            )
        }
        (Some(factor), None) => {
            format!(": coordinates are in metres; multiply those of the set by {}", brief(factor))
        }
        (None, _) if meet(shapes, bodies) => return None,
        (None, _) => String::new(),
    };
    Some(format!("the set is {}, and the bodies are {}{unit}", words(shapes), words(bodies)))
}

fn words([low, high]: &Limits) -> String {
    let corner = |corner: &[f64]| corner.iter().map(|x| brief(*x)).collect::<Vec<_>>().join(", ");
    format!("from [{}] to [{}] m", corner(low), corner(high))
}

fn width([low, high]: &Limits) -> f64 {
    low.iter().zip(high).map(|(low, high)| high - low).fold(0.0, f64::max)
}

fn meet([low, high]: &Limits, [least, most]: &Limits) -> bool {
    (0..low.len()).all(|axis| low[axis] <= most[axis] && least[axis] <= high[axis])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(shapes: [[f64; 2]; 2], scale: Option<f64>) -> Option<String> {
        advice(&shapes.map(Vec::from), &[vec![0.0, 0.0], vec![1.0, 2.0]], scale)
    }

    #[test]
    fn a_unit_is_proposed_where_it_puts_the_lines_into_the_bodies() {
        let advice = of([[0.0, 500.0], [1000.0, 500.0]], Some(1.0)).expect("advice");
        let expected = "the set is from [0, 500] to [1000, 500] m, and the bodies are from [0, 0] to [1, 2] m: if \
                        the file has another unit, say scale = 0.001";
        assert_eq!(advice, expected);
        // The boxes meet, and the lines are far longer than the bodies.
        assert!(of([[-100.0, 0.0], [2000.0, 1000.0]], Some(1.0)).expect("advice").ends_with("scale = 0.001"));
        let small = of([[0.0, 0.005], [0.01, 0.005]], Some(0.001)).expect("advice");
        assert!(small.ends_with("say scale = 0.1, not 0.001"), "{small}");
        let list = of([[0.0, 0.0005], [0.001, 0.0005]], None).expect("advice");
        assert!(list.ends_with("multiply those of the set by 1000"), "{list}");
        let far = of([[50.0, 0.0], [51.0, 1.0]], Some(1.0)).expect("advice");
        assert!(far.ends_with("to [1, 2] m"), "{far}");
        assert_eq!(of([[0.2, 0.2], [0.6, 0.2]], Some(1.0)), None);
    }
}
