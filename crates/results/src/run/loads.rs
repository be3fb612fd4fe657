//! Pairs of forces and displacements for the load-displacement plot.

use crate::run::history::History;
use crate::run::unit::split;

/// Force of a boundary and the displacement over which it is plotted.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Load {
    /// Name of the boundary and of the direction.
    pub(crate) name: String,
    /// Displacement, m.
    pub(crate) displacement: Vec<f64>,
    /// Force, N.
    pub(crate) force: Vec<f64>,
}

/// Loads with the name of their displacement.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Loading {
    /// Name of the displacement.
    pub(crate) across: String,
    pub(crate) loads: Vec<Load>,
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// The x and y columns of a boundary or a node, in three dimensions also the z column.
struct Vectors<'a> {
    name: &'a str,
    values: Vec<&'a [f64]>,
}

/// Returns forces and the displacements along them; `None` if the history has no force and displacement that
/// belong together.
pub(crate) fn loading(history: &History) -> Option<Loading> {
    let forces = vectors(history, 'f', "N");
    let displacements = vectors(history, 'u', "m");
    let of_boundary = |name: &str| displacements.iter().find(|moved| moved.name == name);
    let own = forces.iter().filter_map(|force| moved_load(force, of_boundary(force.name)?));
    let loads: Vec<Load> = own.collect();
    if !loads.is_empty() {
        let across = "displacement of the boundary along its load".to_owned();
        return Some(Loading { across, loads });
    }
    let is_node = |moved: &&Vectors<'_>| forces.iter().all(|force| force.name != moved.name);
    let nodes: Vec<&Vectors<'_>> = displacements.iter().filter(is_node).collect();
    supported(&forces, &nodes).or_else(|| without_axes(history))
}

/// Returns columns that belong together, such as `top fx [N]` and `top fy [N]`.
fn vectors<'a>(history: &'a History, letter: char, unit: &str) -> Vec<Vectors<'a>> {
    let first = format!(" {letter}x [{unit}]");
    let columns = history.of_user().filter_map(|(name, x)| {
        let name = name.strip_suffix(&first)?;
        let along = |axis: &str| history.column(&format!("{name} {letter}{axis} [{unit}]"));
        Some(Vectors { name, values: [x, along("y")?].into_iter().chain(along("z")).collect() })
    });
    columns.collect()
}

/// Returns the load of a boundary over its own displacement, along the axis on which it does most work;
/// `None` if it does no work.
fn moved_load(force: &Vectors<'_>, moved: &Vectors<'_>) -> Option<Load> {
    let along = moved.values.iter().zip(&force.values);
    let work: Vec<f64> = along.map(|(moved, force)| work(moved, force).abs()).collect();
    let axis = greatest(work.iter().copied());
    if work[axis] == 0.0 || !work[axis].is_finite() {
        return None;
    }
    let sign = farthest(moved.values[axis]).signum();
    let minus = if sign < 0.0 { "−" } else { "" };
    let turned = |values: &[f64]| values.iter().map(|value| sign * value).collect();
    Some(Load {
        name: format!("{} along {minus}{}", force.name, AXES[axis]),
        displacement: turned(moved.values[axis]),
        force: turned(force.values[axis]),
    })
}

/// Returns the forces of boundaries that do not move over the displacement of the node that moves farthest,
/// along the axis of the largest force.
fn supported(forces: &[Vectors<'_>], nodes: &[&Vectors<'_>]) -> Option<Loading> {
    let peak = |vectors: &Vectors<'_>, axis: usize| farthest(vectors.values[axis]).abs();
    let largest = |axis: usize| forces.iter().map(|force| peak(force, axis)).fold(0.0, f64::max);
    let axes = forces.iter().map(|force| force.values.len()).max()?;
    let axis = greatest((0..axes).map(largest));
    let node = nodes.iter().max_by(|a, b| peak(a, axis).total_cmp(&peak(b, axis)))?;
    let moved = node.values[axis];
    if farthest(moved) == 0.0 || largest(axis) == 0.0 {
        return None;
    }
    let positive = |values: &[f64]| -> Vec<f64> {
        let sign = farthest(values).signum();
        values.iter().map(|value| sign * value).collect()
    };
    let loads = forces.iter().filter(|force| peak(force, axis) > 0.0).map(|force| Load {
        name: format!("{} along {}", force.name, AXES[axis]),
        displacement: positive(moved),
        force: positive(force.values[axis]),
    });
    Some(Loading {
        across: format!("displacement of {} along {}", node.name, AXES[axis]),
        loads: loads.collect(),
    })
}

/// Returns forces over the first displacement, from columns whose names do not end with an axis.
fn without_axes(history: &History) -> Option<Loading> {
    let says =
        |name: &str| [" fx", " fy", " fz", " ux", " uy", " uz"].iter().any(|axis| name.ends_with(axis));
    let plain = |wanted: &'static str| {
        let columns = history.of_user().map(|(name, values)| (split(name), values));
        columns.filter(move |((name, unit), _)| *unit == wanted && !says(name))
    };
    let ((across, _), displacement) = plain("m").next()?;
    let loads: Vec<Load> = plain("N")
        .map(|((name, _), force)| Load {
            name: name.to_owned(),
            displacement: displacement.to_vec(),
            force: force.to_vec(),
        })
        .collect();
    (!loads.is_empty()).then(|| Loading { across: across.to_owned(), loads })
}

/// Returns the place of the first of the greatest values.
fn greatest(values: impl Iterator<Item = f64>) -> usize {
    let (place, _) = values.enumerate().fold((0, f64::NEG_INFINITY), |(most, best), (place, value)| {
        if value > best { (place, value) } else { (most, best) }
    });
    place
}

/// Returns the finite value that is farthest from 0.
fn farthest(values: &[f64]) -> f64 {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    finite.fold(0.0, |far: f64, value| if value.abs() > far.abs() { value } else { far })
}

/// Returns the work of a force, by the trapezoidal rule.
fn work(displacement: &[f64], force: &[f64]) -> f64 {
    let parts = displacement.windows(2).zip(force.windows(2));
    parts.map(|(u, f)| 0.5 * (f[0] + f[1]) * (u[1] - u[0])).filter(|part| part.is_finite()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::history::{HistoryWriter, Row};

    /// Name of a column, and its value over time.
    type Column<'a> = (&'a str, fn(f64) -> f64);

    fn history(columns: &[Column<'_>]) -> History {
        let mut text = Vec::new();
        let names: Vec<String> = columns.iter().map(|(name, _)| (*name).to_owned()).collect();
        let mut writer = HistoryWriter::new(&mut text, 2, &names).unwrap();
        for k in 0..=10_u8 {
            let time = f64::from(k);
            let values = columns.iter().map(|(_, value)| value(time)).collect();
            writer.row(&Row { time, values, ..Row::default() }).unwrap();
        }
        History::read(&text).unwrap()
    }

    #[test]
    fn a_platen_that_comes_down_is_loaded_along_its_motion() {
        let history = history(&[
            ("side ux [m]", |t| 9.0 * t),
            ("top fx [N]", |_| 5e9),
            ("top fy [N]", |t| -2.0 * t),
            ("top ux [m]", |_| 0.0),
            ("top uy [m]", |t| -0.1 * t),
            ("bottom fx [N]", |_| 1.0),
            ("bottom fy [N]", |t| 2.0 * t),
            ("bottom ux [m]", |_| 0.0),
            ("bottom uy [m]", |t| 0.1 * t),
            ("base fx [N]", |_| 1.0),
            ("base fy [N]", |t| 2.0 * t),
            ("base ux [m]", |_| 0.0),
            ("base uy [m]", |_| 0.0),
        ]);
        let Loading { across, loads } = loading(&history).unwrap();
        assert_eq!(across, "displacement of the boundary along its load");
        let names: Vec<&str> = loads.iter().map(|load| load.name.as_str()).collect();
        assert_eq!(names, ["top along −y", "bottom along y"], "a base at rest has no curve");
        for load in &loads {
            assert_eq!((load.force[10], load.displacement[10]), (20.0, 1.0));
        }
    }

    #[test]
    fn a_shear_box_is_loaded_along_its_motion_not_along_its_largest_force() {
        let history = history(&[
            ("box fx [N]", |t| 3.0 * t),
            ("box fy [N]", |_| -500.0),
            ("box ux [m]", |t| 0.1 * t),
            ("box uy [m]", |t| 1e-5 * t),
        ]);
        assert_eq!(loading(&history).unwrap().loads[0].name, "box along x");
    }

    #[test]
    fn forces_at_rest_are_over_the_displacement_of_a_node_on_their_axis() {
        let history = history(&[
            ("base fx [N]", |_| 0.1),
            ("base fy [N]", |t| 7.0 * t),
            ("base ux [m]", |_| 0.0),
            ("base uy [m]", |_| 0.0),
            ("a ux [m]", |t| 50.0 * t),
            ("a uy [m]", |t| -0.1 * t),
            ("b ux [m]", |_| 0.0),
            ("b uy [m]", |t| -0.3 * t),
        ]);
        let Loading { across, loads } = loading(&history).unwrap();
        assert_eq!(across, "displacement of b along y");
        assert_eq!((loads[0].force[10], loads[0].displacement[10]), (70.0, 3.0));
    }

    #[test]
    fn what_does_not_belong_together_is_not_plotted() {
        assert_eq!(loading(&history(&[("a ux [m]", |t| t), ("load [N]", |t| t)])), None);
        assert_eq!(loading(&history(&[("load [N]", |t| t)])), None);
        let plain = history(&[("opening [m]", |t| t), ("load [N]", |t| t)]);
        assert_eq!(loading(&plain).unwrap().across, "opening");
    }
}
