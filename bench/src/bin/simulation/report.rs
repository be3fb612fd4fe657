//! The tables of the report.

use std::fmt::Write as _;

use fdem_bench::bodies::{Body, Plane, Space};
use fdem_bench::{Table, grouped, machine, significant};
use fdem_contact::Simd;

use crate::levels;
use crate::limits::Limits;
use crate::outcome::{Outcome, Program};

/// Lower bounds on the bytes that a step moves in any program: per node (position, velocity, read and
/// written, and mass), per element (inverse of its edges, volume, nodes) and per joint (nodes, length,
/// largest opening and sliding, and plastic sliding of both ends).
const NODE: f64 = 72.0;
const ELEMENT: f64 = 52.0;
const JOINT: f64 = 72.0;

/// Additions and multiplications of a step, counted in the equations: stress, energy and forces of an
/// element; traction, forces and work of a joint; motion of a node.
const ELEMENT_WORK: f64 = 120.0;
const JOINT_WORK: f64 = 90.0;
const NODE_WORK: f64 = 30.0;

type Outcomes = [(Body, Outcome)];

/// Settings that hold for all bodies: threads, rounds, instructions.
pub(crate) struct Setting {
    pub(crate) threads: usize,
    pub(crate) rounds: usize,
    /// The vector instructions; `None` for the best that the processor has.
    pub(crate) level: Option<Simd>,
}

pub(crate) fn report(setting: &Setting, limits: &Limits, outcomes: &Outcomes) -> String {
    let &Setting { threads, rounds, level } = setting;
    let numbers = if threads == 1 { vec![1] } else { vec![1, threads] };
    let best = Simd::best();
    let chosen = match level {
        Some(level) if level != best => format!(", chosen for this report: the processor has {best}, too"),
        _ => String::new(),
    };
    let mut out = format!(
        "# Steps of the simulation\n\n{}; {}{chosen}.\n\nMillions of element-steps in a second; medians of {rounds} rounds in which all take turns. \
         Every body takes the same steps in each run: their number in one timing depends on the body and its size alone. \
         Results are compared at the end: they are the same on any number of threads and on all vector instructions.\n\n",
        machine(&numbers),
        levels::name(level)
    );
    let _ = writeln!(out, "{}\n{}", bodies(outcomes), speed(threads, outcomes));
    let _ = writeln!(
        out,
        "Spread: the longest time on one thread without the shortest, over the median. Memory is the peak of the process on one thread, the model included, minus its memory before. \
         Contacts are the mean over the rounds."
    );
    if let Some(table) = before(outcomes) {
        let _ = writeln!(
            out,
            "\n## Against the version before, 1 thread\n\nBoth take the same steps of the same bodies, in turns. How many times as fast this version is: the median over the rounds, and in brackets the least and the most. \
             Contacts are for each element, spreads are those of both versions.\n\n{table}"
        );
    } else {
        out.push('\n');
    }
    let _ =
        writeln!(out, "## Where the time goes, 1 thread\n\n{}\n## Against the bounds\n", shares(outcomes));
    let giga = |rates: [f64; 2]| rates.map(|rate| significant(rate / 1e9));
    let ([one, all], [slow, fast]) = (giga(limits.bytes), giga(limits.operations));
    let measured = if threads == 1 {
        format!("{one} GB/s through memory (triad) and {slow} GFLOP/s")
    } else {
        format!(
            "{one} GB/s through memory on one thread and {all} on {threads} (triad), {slow} and {fast} GFLOP/s"
        )
    };
    let _ = writeln!(
        out,
        "The bounds of this machine: {measured} \
         (additions and multiplications in registers, with the instructions of our build). A step moves at least {NODE} bytes for a node, \
         {ELEMENT} for an element, {JOINT} for a joint, and takes {NODE_WORK}, {ELEMENT_WORK} and {JOINT_WORK} operations; contacts are not counted, and bodies of tetrahedra are left out. \
         In brackets: the time of a step over the bound.\n\n{}",
        bounds(limits, outcomes)
    );
    if let Some(table) = instructions(level, outcomes) {
        let _ = writeln!(
            out,
            "## Vector instructions, 1 thread\n\nElements, whole joints and contacts are computed on them. The last column is that of all other tables. All give the same results.\n\n{table}"
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
    let mut table = Table::new(&["body", "contents"]);
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

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn speed(threads: usize, outcomes: &Outcomes) -> Table {
    let (many, ratio) = (format!("{threads} threads"), format!("{threads} threads / 1"));
    let mut headings = vec!["body", "elements", "steps", "1 thread", "spread"];
    if threads > 1 {
        headings.extend([&*many, &*ratio]);
    }
    headings.extend(["bytes per element", "contacts", "for each element", "broken joints"]);
    let mut table = Table::new(&headings);
    for (body, outcome) in outcomes {
        let mut cells = head(*body, outcome).to_vec();
        cells.extend([
            grouped(outcome.steps),
            millions(outcome.one()),
            outcome.spread(&Program::One).map_or_else(String::new, percent),
        ]);
        if let Some(rate) = outcome.rate(&Program::Many) {
            cells.extend([millions(rate), significant(rate / outcome.one())]);
        }
        let contacts = outcome.contacts[0];
        cells.extend([
            format!("{:.0}", outcome.memory),
            grouped(contacts.round() as u64),
            format!("{:.2}", contacts / outcome.elements as f64),
            grouped(outcome.broken as u64),
        ]);
        table.row(cells);
    }
    table
}

/// A table of the version before; `None` if it was not timed.
fn before(outcomes: &Outcomes) -> Option<Table> {
    let headings =
        ["body", "elements", "before", "now", "times as fast", "contacts", "contacts before", "spreads"];
    let mut table = Table::new(&headings);
    for (body, outcome) in outcomes {
        let [faster, least, most] = outcome.faster()?.map(significant);
        let [now, before] =
            outcome.contacts.map(|contacts| format!("{:.2}", contacts / outcome.elements as f64));
        let spreads = [Program::Before, Program::One].map(|program| outcome.spread(&program).map(percent));
        table.row(head(*body, outcome).into_iter().chain([
            millions(outcome.rate(&Program::Before)?),
            millions(outcome.one()),
            format!("{faster} ({least} to {most})"),
            now,
            before,
            spreads.into_iter().flatten().collect::<Vec<_>>().join(", "),
        ]));
    }
    Some(table)
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
        let percent = outcome.shares.map(percent);
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
        let bound = |rate: f64| format!("{} ({})", millions(rate), significant(rate / outcome.one()));
        table.row(head(*body, outcome).into_iter().chain([
            millions(outcome.one()),
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
            .map(|(_, rate)| format!("{} ({})", millions(rate), significant(outcome.one() / rate)));
        table.row(head(*body, outcome).into_iter().chain([millions(outcome.one())]).chain(theirs));
    }
    Some(format!("\n{table}"))
}

/// A table of vector instructions.
fn instructions(level: Option<Simd>, outcomes: &Outcomes) -> Option<Table> {
    let with = || outcomes.iter().filter(|(_, outcome)| outcome.levels().next().is_some());
    let (_, first) = with().next()?;
    let headings = ["body", "elements"]
        .into_iter()
        .chain(first.levels().map(|(name, _)| name))
        .chain([levels::name(level)]);
    let mut table = Table::new(&headings.collect::<Vec<_>>());
    for (body, outcome) in with() {
        let rates = outcome.levels().map(|(_, rate)| rate).chain([outcome.one()]);
        table.row(head(*body, outcome).into_iter().chain(rates.map(millions)));
    }
    Some(table)
}
