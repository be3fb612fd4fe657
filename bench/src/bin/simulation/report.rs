//! The tables of the report.

use std::fmt::Write as _;

use fdem_bench::bodies::{Body, Plane, Space};
use fdem_bench::{Table, grouped, machine, significant};
use fdem_simulation::Simd;

use crate::case::Outcome;
use crate::limits::Limits;

/// Lower bounds on the bytes that a step moves in any program: per node (position, velocity, read and written, and mass), per element
/// (inverse of its edges, volume, nodes) and per joint (nodes, length, largest opening and sliding, and plastic sliding of both ends).
const NODE: f64 = 72.0;
const ELEMENT: f64 = 52.0;
const JOINT: f64 = 72.0;

/// Additions and multiplications of a step, counted in the equations: stress, energy and forces of an element; traction, forces and work of
/// a joint; motion of a node.
const ELEMENT_WORK: f64 = 120.0;
const JOINT_WORK: f64 = 90.0;
const NODE_WORK: f64 = 30.0;

type Outcomes = [(Body, Outcome)];

pub(crate) fn report(threads: usize, rounds: usize, limits: &Limits, outcomes: &Outcomes) -> String {
    let mut out = format!(
        "# Steps of the simulation\n\n{}; {}.\n\nMillions of element-steps in a second; medians of {rounds} rounds in which all take turns. \
         Results are compared at the end: they are the same on any number of threads and on all vector instructions.\n\n",
        machine(&[1, threads]),
        Simd::best()
    );
    let _ = writeln!(out, "{}\n{}", bodies(outcomes), speed(threads, outcomes));
    let _ = writeln!(
        out,
        "Memory is the most that the process had on one thread, the model included, without what it had before. Contacts are the mean over the rounds.\n\n\
         ## Where the time goes, 1 thread\n\n{}\n## Against the bounds\n",
        shares(outcomes)
    );
    let giga = |rates: [f64; 2]| rates.map(|rate| significant(rate / 1e9));
    let ([one, all], [slow, fast]) = (giga(limits.bytes), giga(limits.operations));
    let _ = writeln!(
        out,
        "The bounds of this machine: {one} GB/s through memory on one thread and {all} on {threads} (triad), {slow} and {fast} GFLOP/s \
         (additions and multiplications in registers, with the instructions of our build). A step moves at least {NODE} bytes for a node, \
         {ELEMENT} for an element, {JOINT} for a joint, and takes {NODE_WORK}, {ELEMENT_WORK} and {JOINT_WORK} operations; contacts are not counted, and bodies of tetrahedra are left out. \
         In brackets: the time of a step over the bound.\n\n{}",
        bounds(limits, outcomes)
    );
    if let Some(table) = instructions(outcomes) {
        let _ = writeln!(
            out,
            "## Vector instructions, 1 thread\n\nElements and whole joints are computed on the best that the processor has. All give the same results.\n\n{table}"
        );
    }
    let driven = [
        Body::Plane(Plane::Bar),
        Body::Plane(Plane::Disc),
        Body::Plane(Plane::Joined),
        Body::Space(Space::Cube),
        Body::Space(Space::CubeJoined),
    ];
    let others: String = driven.into_iter().filter_map(|body| others(body, outcomes)).collect();
    if !others.is_empty() {
        let _ = writeln!(
            out,
            "## Other programs, 1 thread\n\nThe same meshes, linear triangles and tetrahedra, explicit central differences. \
             In brackets: how many times as long as ours they take.\n{others}"
        );
    }
    out
}

fn bodies(outcomes: &Outcomes) -> Table {
    let mut table = Table::new(&["body", "what"]);
    for body in Body::all().filter(|body| outcomes.iter().any(|(other, _)| other == body)) {
        table.row([body.name().to_owned(), body.what().to_owned()]);
    }
    table
}

/// The first two cells of a row.
fn head(body: Body, outcome: &Outcome) -> [String; 2] {
    [body.name().to_owned(), grouped(outcome.elements as u64)]
}

fn millions(rate: f64) -> String {
    significant(rate / 1e6)
}

fn speed(threads: usize, outcomes: &Outcomes) -> Table {
    let (many, ratio) = (format!("{threads} threads"), format!("{threads} threads / 1"));
    let headings =
        ["body", "elements", "1 thread", &many, &ratio, "bytes per element", "contacts", "broken joints"];
    let mut table = Table::new(&headings);
    for (body, outcome) in outcomes {
        table.row(head(*body, outcome).into_iter().chain([
            millions(outcome.rate(0)),
            millions(outcome.rate(1)),
            significant(outcome.rate(1) / outcome.rate(0)),
            format!("{:.0}", outcome.memory),
            grouped(outcome.contacts.round() as u64),
            grouped(outcome.broken as u64),
        ]));
    }
    table
}

fn shares(outcomes: &Outcomes) -> Table {
    let mut table = Table::new(&[
        "body",
        "elements",
        "bulk",
        "joints",
        "detection",
        "contact",
        "integration",
        "detections",
    ]);
    for (body, outcome) in outcomes {
        let percent = outcome.shares.map(|share| format!("{:.1} %", 100.0 * share));
        table.row(head(*body, outcome).into_iter().chain(percent).chain([grouped(outcome.detections)]));
    }
    table
}

fn bounds(limits: &Limits, outcomes: &Outcomes) -> Table {
    let mut table = Table::new(&["body", "elements", "1 thread", "bytes", "operations"]);
    for (body, outcome) in outcomes {
        let Body::Plane(plane) = body else { continue };
        let joined = plane.has_joints();
        let (nodes, joints) = if joined { (3.0, 1.5) } else { (0.5, 0.0) };
        let bytes = limits.bytes[0] / (ELEMENT + nodes * NODE + joints * JOINT);
        let work = limits.operations[0] / (ELEMENT_WORK + nodes * NODE_WORK + joints * JOINT_WORK);
        let bound = |rate: f64| format!("{} ({})", millions(rate), significant(rate / outcome.rate(0)));
        table.row(head(*body, outcome).into_iter().chain([
            millions(outcome.rate(0)),
            bound(bytes),
            bound(work),
        ]));
    }
    table
}

/// A table of the other programs; `None` if there were none.
fn others(body: Body, outcomes: &Outcomes) -> Option<String> {
    let with =
        || outcomes.iter().filter(|(other, outcome)| *other == body && outcome.others().next().is_some());
    let (_, first) = with().next()?;
    let names = first.others().map(|(name, _)| name);
    let headings: Vec<&str> = ["body", "elements", "fdem"].into_iter().chain(names).collect();
    let mut table = Table::new(&headings);
    for (body, outcome) in with() {
        let theirs = outcome
            .others()
            .map(|(_, rate)| format!("{} ({})", millions(rate), significant(outcome.rate(0) / rate)));
        table.row(head(*body, outcome).into_iter().chain([millions(outcome.rate(0))]).chain(theirs));
    }
    Some(format!("\n{table}"))
}

/// A table of vector instructions.
fn instructions(outcomes: &Outcomes) -> Option<Table> {
    let with = || outcomes.iter().filter(|(_, outcome)| outcome.slower().next().is_some());
    let (_, first) = with().next()?;
    let best = Simd::best().to_string();
    let headings =
        ["body", "elements"].into_iter().chain(first.slower().map(|(name, _)| name)).chain([&*best]);
    let mut table = Table::new(&headings.collect::<Vec<_>>());
    for (body, outcome) in with() {
        let rates = outcome.slower().map(|(_, rate)| rate).chain([outcome.rate(0)]);
        table.row(head(*body, outcome).into_iter().chain(rates.map(millions)));
    }
    Some(table)
}
