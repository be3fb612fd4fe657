//! The summary at the end of a run.

use fdem_io::numbers::{brief, grouped};
use fdem_results::Fragments;
use fdem_simulation::Energies;

use crate::command::run::account::{Account, PARTS};
use crate::command::run::engine::Engine;
use crate::command::run::ranks::in_ranks;
use crate::command::run::results::Results;

/// The summary of a run: names and texts of its lines. `frames`: number of frames; `more`: lines after those
/// of cracks and fragments; `open`: the joints that are open from the start, in words.
pub(crate) fn summary<const D: usize, const N: usize>(
    run: &dyn Engine<D, N>,
    status: &str,
    account: &Account,
    frames: usize,
    fragments: &Fragments<D>,
    open: Option<String>,
    more: Vec<(&'static str, String)>,
) -> Vec<(&'static str, String)>
where
    [[f64; D]; N]: Results<D, N>,
{
    let (counts, energies) = (run.counts(), run.energies());
    let elements = run.elements();
    let busy = account.busy();
    let shares: Vec<String> = PARTS
        .iter()
        .zip(account.parts)
        // Parts that the model does not have take no time: messages of one process, spheres, joints.
        .filter(|(_, seconds)| *seconds >= SHOWN * busy)
        .map(|(name, seconds)| format!("{name} {:.0} %", 100.0 * seconds / busy.max(1e-9)))
        .collect();
    let cracks: Vec<String> = ["tension", "shear", "both"]
        .into_iter()
        .zip(run.crack_lengths())
        .filter(|(_, length)| *length > 0.0)
        .map(|(name, measure)| format!("{} {} by {name}", brief(measure), <[[f64; D]; N]>::CRACKED.1))
        .collect();
    let mut facts = vec![
        ("status", status.to_owned()),
        (
            "time",
            format!(
                "{} s in {} steps of {} s",
                brief(run.time()),
                grouped(run.steps()),
                brief(run.time_step())
            ),
        ),
        (
            "cracks",
            if cracks.is_empty() {
                "none".to_owned()
            } else {
                format!("{} joints broken: {}", grouped(counts.broken as u64), cracks.join(", "))
            },
        ),
    ];
    if elements > 0 {
        let mesh = format!("{} elements, {} nodes", grouped(elements as u64), grouped(counts.nodes as u64));
        facts.insert(1, ("mesh", mesh));
    } else {
        facts.retain(|(name, _)| *name != "cracks");
    }
    if counts.spheres > 0 {
        let [spheres, contacts] = [counts.spheres, counts.sphere_contacts].map(|count| count as u64);
        let deepest = run.deepest_overlap().map(|(share, sphere)| {
            format!("; the deepest overlap was {} % of a radius, of sphere {sphere}", brief(100.0 * share))
        });
        let numbers = format!("{}, {}", counted(spheres, "sphere"), counted(contacts, "contact"));
        facts.insert(1, ("spheres", numbers + &deepest.unwrap_or_default()));
    }
    if counts.waiting_spheres > 0 {
        let waiting = counted(counts.waiting_spheres as u64, "sphere");
        facts.push(("waiting", format!("{waiting} of insertions, which found no room")));
    }
    facts.extend(open.map(|open| ("open joints", open)));
    if elements > 0 {
        facts.push(("fragments", in_words(fragments)));
    }
    facts.extend(more);
    facts.extend([
        ("energies (J)", of_energies(&energies)),
        (
            "balance",
            format!("{} J, {:.2e} of the exchanged energy", brief(energies.balance()), energies.error()),
        ),
    ]);
    // Spheres find their contacts by themselves.
    if elements > 0 {
        facts.push((
            "detection",
            format!(
                "{}, {} contacts at the end",
                match account.detections {
                    1 => "once".to_owned(),
                    times => format!("{} times", grouped(times)),
                },
                grouped(counts.contacts as u64)
            ),
        ));
    }
    facts.extend([
        (
            "run time",
            format!(
                "{busy:.1} s on {} thread{}: {}",
                run.threads(),
                if run.threads() == 1 { "" } else { "s" },
                shares.join(", ")
            ),
        ),
        (
            "output",
            format!(
                "{:.1} % of the run ({}, {})",
                100.0 * account.share(),
                counted(frames as u64, "frame"),
                counted(account.checkpoints, "checkpoint")
            ),
        ),
    ]);
    facts.extend(in_ranks(&run.traffic()).map(|text| ("ranks", text)));
    facts
}

/// Share of the time of a run below which a part is not shown.
const SHOWN: f64 = 0.005;

/// Share of the largest energy below which another is rounding.
const ROUNDING: f64 = 1e-12;

/// The terms of the energy balance that are not zero: those present or dissipated add up to those supplied,
/// but for the error of the balance.
fn of_energies(energies: &Energies) -> String {
    let terms = energies.terms();
    let largest = terms.iter().fold(0.0, |largest: f64, term| largest.max(term.value.abs()));
    let shown = terms.iter().filter(|term| term.value.abs() > ROUNDING * largest || term.value.is_nan());
    let shown: Vec<String> = shown.map(|term| format!("{} {}", term.key, brief(term.value))).collect();
    if shown.is_empty() { "none".to_owned() } else { shown.join(", ") }
}

/// `2 frames` and `1 frame`.
fn counted(number: u64, what: &str) -> String {
    format!("{} {what}{}", grouped(number), if number == 1 { "" } else { "s" })
}

/// Describes the fragments of the bodies that count.
fn in_words<const D: usize>(fragments: &Fragments<D>) -> String {
    let count = fragments.count();
    let number = grouped(count.number);
    match fragments.sizes().size(0.5) {
        Some(half) if count.number > 1 => format!(
            "{number}, the largest has {:.2} % of the mass; half of the mass passes {} m",
            100.0 * count.largest,
            brief(half)
        ),
        _ => number,
    }
}
