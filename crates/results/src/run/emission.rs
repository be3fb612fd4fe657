//! Acoustic emission: joints that break, or that begin to soften and hold, near each other in space and time
//! are one event; magnitudes, and the b-value of their frequencies.
//!
//! Two joints of one kind are linked if their middles, in the undeformed mesh, are no farther apart than a
//! distance, and their times no more than a window: the times when they broke, or when they began to soften
//! if they still hold. All joints that links connect are one event. Its time is that of its first joint, its
//! place the mean of the middles, weighted by their lengths or areas. Its energy is that which its joints
//! have dissipated: their fracture energy if they are broken, and the share of it for their damage if they
//! hold. Each joint is in one event, so that no energy counts twice. The magnitude is that of Gutenberg and
//! Richter,
//! `M = (log₁₀ E - 4.8) · 2/3`, E in J.
//!
//! # Source
//! J. F. Hazzard, R. P. Young, "Dynamic modelling of induced seismicity", Int. J. Rock Mech. Min. Sci. 41
//! (2004) 1365-1376, put cracks that are near in space and time together to one event; their magnitudes
//! follow from the moments of contact forces instead. B. Gutenberg, C. F. Richter, "Magnitude and energy of
//! earthquakes", Ann. Geofis. 9 (1956) 1-15. K. Aki, "Maximum likelihood estimate of b in the formula log N =
//! a - bM and its confidence limits", Bull. Earthq. Res. Inst. 43 (1965) 237-239.

use std::f64::consts::LOG10_E;
use std::fmt::Write;

use fdem_simulation::{Element, Mode, Model, Snapshot};

use crate::run::chart::{Axis, Chart, Curve};
use crate::run::csv::push_number;
use crate::run::plots::Plot;

/// Width of the classes in which magnitudes are counted.
const CLASS: f64 = 0.1;

/// Fewest events for which a b-value is given.
const FEWEST: usize = 50;

/// Default distance of linked joints, over the mean size of all their facets.
const REACH: f64 = 2.0;

/// Why a joint emits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmissionKind {
    /// It broke.
    Break,
    /// It softens, and holds until now.
    Softening,
}

impl EmissionKind {
    /// The word in tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Break => "break",
            Self::Softening => "softening",
        }
    }
}

/// A joint that broke, or softens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmittingJoint<const D: usize> {
    /// Whether it broke, or softens and holds.
    pub kind: EmissionKind,
    /// Time when it broke, or began to soften, s.
    pub time: f64,
    /// Middle of the facet in the undeformed mesh, m.
    pub place: [f64; D],
    /// Energy that it has dissipated, J.
    pub energy: f64,
    /// Length, m, or area, m², of the facet.
    pub measure: f64,
}

/// Limits of distance and time within which two joints are linked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clustering {
    /// Largest distance of linked joints, m. `None`: twice the size of a facet, the mean over all joints.
    pub distance: Option<f64>,
    /// Largest time between linked joints, s. `None`: the time in which a shear wave travels the distance.
    pub window: Option<f64>,
}

/// An event of acoustic emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event<const D: usize> {
    /// Whether its joints broke, or soften and hold.
    pub kind: EmissionKind,
    /// Time of the first joint, s.
    pub time: f64,
    /// Time from the first joint to the last, s.
    pub duration: f64,
    /// Mean place, weighted by length or area, m.
    pub place: [f64; D],
    /// Energy, J.
    pub energy: f64,
    /// Magnitude; `None` without energy, which has none.
    pub magnitude: Option<f64>,
    /// Number of joints.
    pub joints: u64,
    /// Length, m, or area, m².
    pub measure: f64,
}

/// The joints that the run has broken and, with `softening`, those that soften and hold, by time; those of
/// one time in the order of their elements.
pub fn emitting_joints<const D: usize, const N: usize>(
    model: &Model<D, N>,
    snapshot: &Snapshot<D, N>,
    softening: bool,
) -> Vec<EmittingJoint<D>>
where
    [[f64; D]; N]: Element<D, N>,
{
    let mesh = &model.mesh;
    let mut emitting: Vec<EmittingJoint<D>> = Vec::new();
    for crack in snapshot.cracks.iter().filter(|crack| !crack.open_from_start) {
        let (kind, time) = match (crack.time, crack.softens) {
            (Some(time), _) => (EmissionKind::Break, time),
            (None, Some(time)) if softening => (EmissionKind::Softening, time),
            (None, _) => continue,
        };
        let [a, b] = crack.elements.map(|element| element as usize);
        let common = mesh.elements[a].iter().filter(|node| mesh.elements[b].contains(node));
        let mut place = [0.0; D];
        for &node in common {
            for (sum, x) in place.iter_mut().zip(mesh.nodes[node as usize]) {
                *sum += x / D as f64;
            }
        }
        let strength = model.strength_of(crack.elements);
        let per_area = strength.map_or(0.0, |strength| match crack.mode {
            Mode::Tension => strength.energy_i,
            Mode::Shear => strength.energy_ii,
            Mode::Mixed => 0.5 * (strength.energy_i + strength.energy_ii),
        });
        let energy = crack.dissipated * per_area * crack.measure * model.thickness;
        emitting.push(EmittingJoint { kind, time, place, energy, measure: crack.measure });
    }
    emitting.sort_by(|a, b| a.time.total_cmp(&b.time));
    emitting
}

impl Clustering {
    /// The distance, m, and the window, s, for these joints. `speed`: of shear waves, m/s.
    pub fn limits<const D: usize>(&self, joints: &[EmittingJoint<D>], speed: f64) -> [f64; 2] {
        let mean = joints.iter().map(|at| at.measure).sum::<f64>() / joints.len().max(1) as f64;
        let size = if D == 3 { mean.sqrt() } else { mean };
        let distance = self.distance.unwrap_or(REACH * size);
        [distance, self.window.unwrap_or(distance / speed)]
    }
}

/// The events, by time. `joints`: by time; `distance`, m, and `window`, s: of linked joints.
///
/// # Cost
/// Proportional to the number of joints and that of joints within a window.
pub fn events<const D: usize>(joints: &[EmittingJoint<D>], [distance, window]: [f64; 2]) -> Vec<Event<D>> {
    // Every joint points to an earlier one of its event, or to itself.
    let mut first: Vec<usize> = (0..joints.len()).collect();
    let root = |first: &mut Vec<usize>, mut at: usize| {
        while first[at] != at {
            first[at] = first[first[at]];
            at = first[at];
        }
        at
    };
    let mut oldest = 0;
    for (now, here) in joints.iter().enumerate() {
        while here.time - joints[oldest].time > window {
            oldest += 1;
        }
        for (before, earlier) in (oldest..now).zip(&joints[oldest..now]) {
            let apart = here.place.iter().zip(earlier.place).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            if here.kind == earlier.kind && apart <= distance * distance {
                let [a, b] = [root(&mut first, before), root(&mut first, now)];
                first[a.max(b)] = a.min(b);
            }
        }
    }
    let mut event_of = vec![usize::MAX; joints.len()];
    let mut events: Vec<Event<D>> = Vec::new();
    for (number, at) in joints.iter().enumerate() {
        let root = root(&mut first, number);
        if root == number {
            event_of[number] = events.len();
            events.push(Event {
                kind: at.kind,
                time: at.time,
                duration: 0.0,
                place: [0.0; D],
                energy: 0.0,
                magnitude: None,
                joints: 0,
                measure: 0.0,
            });
        }
        let event = &mut events[event_of[root]];
        event.duration = at.time - event.time;
        event.energy += at.energy;
        event.measure += at.measure;
        event.joints += 1;
        for axis in 0..D {
            event.place[axis] += at.measure * at.place[axis];
        }
    }
    for event in &mut events {
        event.place = event.place.map(|sum| sum / event.measure);
        event.magnitude = Some(event.energy).filter(|energy| *energy > 0.0).map(magnitude);
    }
    events
}

/// Magnitude of an energy, J.
fn magnitude(energy: f64) -> f64 {
    (libm::log10(energy) - 4.8) / 1.5
}

/// The events as delimited text. The magnitude of an event without energy is an empty field.
pub fn events_csv<const D: usize>(events: &[Event<D>]) -> String {
    let axes = ["x [m]", "y [m]", "z [m]"][..D].join(",");
    let measure = if D == 3 { "area [m²]" } else { "length [m]" };
    let mut text = format!("event,kind,joints,time [s],duration [s],{axes},energy [J],magnitude,{measure}\n");
    for (number, event) in events.iter().enumerate() {
        // Writing to a string does not fail.
        let _ = write!(text, "{number},{},{}", event.kind.word(), event.joints);
        let numbers = [event.time, event.duration].into_iter().chain(event.place);
        for number in numbers.chain([event.energy]) {
            push_number(&mut text, number);
        }
        match event.magnitude {
            Some(magnitude) => push_number(&mut text, magnitude),
            None => text.push(','),
        }
        push_number(&mut text, event.measure);
        text.push('\n');
    }
    text
}

/// The b-value of Gutenberg and Richter, `log₁₀ N = a - b M`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BValue {
    /// The maximum-likelihood estimate `b = log₁₀ e / (mean M - M_c)`.
    pub b: f64,
    /// Standard error of the estimate, `b/√n`.
    pub error: f64,
    /// Magnitude of completeness `M_c`: the lower end of the class of a tenth of a magnitude with most
    /// events, the lowest of equal ones.
    pub completeness: f64,
    /// Number of events from there on.
    pub count: usize,
}

impl BValue {
    /// The b-value of some magnitudes. `None` for fewer than 50 from the magnitude of completeness on, or if
    /// they are all alike.
    pub fn of(magnitudes: &[f64]) -> Option<Self> {
        let mut sorted: Vec<f64> =
            magnitudes.iter().copied().filter(|magnitude| magnitude.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let class = |magnitude: f64| (magnitude / CLASS).floor();
        let most = sorted.chunk_by(|a, b| class(*a) == class(*b)).rev().max_by_key(|chunk| chunk.len())?;
        let completeness = CLASS * class(most[0]);
        let counted = &sorted[sorted.partition_point(|&magnitude| class(magnitude) < class(most[0]))..];
        let mean = counted.iter().sum::<f64>() / counted.len() as f64;
        if counted.len() < FEWEST || counted.first() == counted.last() {
            return None;
        }
        let b = LOG10_E / (mean - completeness);
        Some(Self { b, error: b / (counted.len() as f64).sqrt(), completeness, count: counted.len() })
    }
}

/// Plots how many events have at least a magnitude, as a decimal logarithm, and the line of the b-value if
/// there is one. `None` for fewer than two events.
pub fn magnitude_frequency<const D: usize>(events: &[Event<D>]) -> Option<Plot> {
    let mut magnitudes: Vec<f64> = events.iter().filter_map(|event| event.magnitude).collect();
    magnitudes.sort_by(f64::total_cmp);
    let most = *magnitudes.last()?;
    if magnitudes.len() < 2 {
        return None;
    }
    let counts: Vec<f64> =
        (0..magnitudes.len()).map(|k| libm::log10((magnitudes.len() - k) as f64)).collect();
    let value = BValue::of(&magnitudes);
    let line = value.map(|value| {
        let a = libm::log10(value.count as f64);
        let end = (value.completeness + a / value.b).min(most);
        ([value.completeness, end], [a, a - value.b * (end - value.completeness)])
    });
    let name = value.map(|value| format!("b = {:.2} ± {:.2}", value.b, value.error)).unwrap_or_default();
    let mut curves = vec![Curve::plain("events", &magnitudes, &counts)];
    curves.extend(line.as_ref().map(|(across, up)| Curve::plain(&name, across, up)));
    let chart = Chart {
        name: "Magnitudes of acoustic emission",
        description: format!("Cumulative frequency of {} events by magnitude. {name}", magnitudes.len()),
        across: Axis { name: "magnitude M", unit: "" },
        up: Axis { name: "log₁₀ of the number of events with at least M", unit: "" },
        logarithmic: false,
        whole: false,
        curves,
    };
    Some(Plot { name: "acoustic_emission".to_owned(), svg: chart.svg() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn broken(time: f64, x: f64, energy: f64) -> EmittingJoint<2> {
        EmittingJoint { kind: EmissionKind::Break, time, place: [x, 0.0], energy, measure: 0.1 }
    }

    #[test]
    fn breaks_that_are_near_in_space_and_time_are_one_event() {
        let breaks = [
            broken(0.0, 0.0, 1.0),
            broken(0.1, 5.0, 10.0),
            broken(0.9, 1.0, 3.0),
            broken(1.8, 2.0, 4.0),
            broken(3.0, 2.0, 2.0),
        ];
        let found = events(&breaks, [1.0, 1.0]);
        let seen: Vec<_> = found.iter().map(|event| (event.time, event.joints, event.energy)).collect();
        assert_eq!(seen, [(0.0, 3, 8.0), (0.1, 1, 10.0), (3.0, 1, 2.0)]);
        assert!((found[0].place[0] - 1.0).abs() < 1e-12, "{found:?}");
        assert!((found[0].duration - 1.8).abs() < 1e-12 && (found[0].measure - 0.3).abs() < 1e-12);
        // 10^4.8 J are magnitude 0, and 10^1.5 as much is one more.
        assert!((magnitude(libm::pow(10.0, 6.3)) - 1.0).abs() < 1e-12);
        assert_eq!(events(&breaks, [0.5, 1.0]).len(), 5, "too far apart");
        assert_eq!(events(&breaks, [9.0, 0.05]).len(), 5, "too late");
        assert_eq!(events(&breaks, [9.0, 9.0]).len(), 1);
        // A later break may connect two events that were apart.
        let bridge = [broken(0.0, 0.0, 1.0), broken(0.1, 2.0, 1.0), broken(0.2, 1.0, 1.0)];
        assert_eq!(events(&bridge, [1.0, 1.0]).len(), 1);
        assert_eq!(events::<2>(&[], [1.0, 1.0]), []);
        let text = events_csv(&found);
        assert_eq!(text.lines().count(), 4);
        assert!(
            text.starts_with(
                "event,kind,joints,time [s],duration [s],x [m],y [m],energy [J],magnitude,length [m]\n0,break,3,0,"
            ),
            "{text}"
        );
    }

    #[test]
    fn joints_that_soften_are_events_of_their_own() {
        let softening = EmittingJoint { kind: EmissionKind::Softening, ..broken(0.2, 0.1, 0.5) };
        let joints = [broken(0.0, 0.0, 1.0), softening, EmittingJoint { time: 0.3, ..softening }];
        let found = events(&joints, [1.0, 1.0]);
        let seen: Vec<_> =
            found.iter().map(|event| (event.kind.word(), event.joints, event.energy)).collect();
        assert_eq!(seen, [("break", 1, 1.0), ("softening", 2, 1.0)]);
        assert!(events_csv(&found).contains("\n1,softening,2,0.2,"), "{}", events_csv(&found));
    }

    /// A joint of a set that opens without fracture energy.
    #[test]
    fn an_event_without_energy_has_no_magnitude() {
        let found = events(&[broken(0.0, 0.0, 0.0), broken(1.0, 0.0, 2.0)], [1.0, 0.5]);
        assert!(found[0].magnitude.is_none() && found[1].magnitude.is_some());
        let text = events_csv(&found);
        let rows: Vec<&str> = text.lines().collect();
        assert_eq!(rows[1], "0,break,1,0,0,0,0,0,,0.1");
        assert_eq!(rows[1].matches(',').count(), rows[0].matches(',').count());
        assert!(!text.contains("inf"), "{text}");
        assert_eq!(magnitude_frequency(&found), None, "one magnitude is no frequency");
    }

    #[test]
    fn limits_follow_from_the_facets_and_the_waves() {
        let breaks = [broken(0.0, 0.0, 1.0), broken(1.0, 0.0, 1.0)];
        assert_eq!(Clustering::default().limits(&breaks, 2.0), [0.2, 0.1]);
        assert_eq!(Clustering { distance: Some(3.0), window: None }.limits(&breaks, 2.0), [3.0, 1.5]);
        assert_eq!(Clustering { distance: None, window: Some(7.0) }.limits(&breaks, 2.0), [0.2, 7.0]);
    }

    /// Quantiles of the exponential distribution of a known b.
    fn magnitudes(b: f64, count: u32) -> Vec<f64> {
        let share = |k: u32| (f64::from(k) + 0.5) / f64::from(count);
        (0..count).map(|k| -3.0 - libm::log10(1.0 - share(k)) / b).collect()
    }

    #[test]
    fn a_known_b_value_is_found() {
        for b in [0.7, 1.0, 1.6] {
            let found = BValue::of(&magnitudes(b, 2000)).unwrap();
            assert!((found.b - b).abs() < found.error, "{b}: {found:?}");
            assert!((found.completeness + 3.0).abs() < 1e-9 && found.count == 2000, "{found:?}");
            assert!((found.error - found.b / 2000_f64.sqrt()).abs() < 1e-12);
        }
        // Small events that are missed do not count.
        let mut missed = magnitudes(1.0, 2000);
        let mut k = 0;
        missed.retain(|magnitude| {
            k += 1;
            *magnitude >= -2.8 || k % 5 == 0
        });
        let found = BValue::of(&missed).unwrap();
        assert!(
            (found.b - 1.0).abs() < 2.0 * found.error && (found.completeness + 2.8).abs() < 0.11,
            "{found:?}"
        );
        assert_eq!(BValue::of(&magnitudes(1.0, 49)), None);
        assert_eq!(BValue::of(&[1.0; 100]), None);
        assert_eq!(BValue::of(&[]), None);
    }

    #[test]
    fn the_frequencies_are_drawn_with_their_line() {
        let event = |magnitude: f64| Event {
            kind: EmissionKind::Break,
            time: 0.0,
            duration: 0.0,
            place: [0.0; 2],
            energy: 1.0,
            magnitude: Some(magnitude),
            joints: 1,
            measure: 1.0,
        };
        let events: Vec<Event<2>> = magnitudes(1.0, 500).into_iter().map(event).collect();
        let plot = magnitude_frequency(&events).unwrap();
        assert!(plot.svg.contains("b = 1.0"), "{}", plot.svg);
        assert!(magnitude_frequency(&events[..10]).is_some_and(|plot| !plot.svg.contains("b =")));
        assert_eq!(magnitude_frequency(&events[..1]), None);
    }
}
