//! Reports a run in Markdown, and as bars to draw.

use std::fmt::Write as _;

use fdem_bench::bars::{Bar, Bars};
use fdem_bench::peers::EngineKind;
use fdem_bench::peers::sets::{Group, Set};
use fdem_bench::picture::{Axis, Curve, Panel};
use fdem_bench::{Table, Times, grouped, machine, significant};

use crate::compare::ROUNDED;
use crate::outcome::{Called, Counted, Outcome};
use crate::plan::Plan;

/// Mark of a time whose search found a number of pairs that differs by at most [`ROUNDED`].
const MARK: &str = "\u{2020}";

/// The whole report in Markdown.
pub(crate) fn report(
    plan: &Plan,
    called: &[Called],
    outcomes: &[Outcome],
    counted: &[Counted],
) -> Result<String, std::fmt::Error> {
    let mut text = String::from("# Rows and its peers\n\n");
    writeln!(text, "{}; {}.\n", machine(&plan.threads), flags())?;
    writeln!(
        text,
        "From raw `f64` coordinates in memory to all couples that touch (points: at most the cut-off apart) as pairs of
numbers in memory, the structure included. The couples of every search were compared with those
of the first of its table, by number and a sum over them; of a program by number."
    )?;
    let one = |threads: usize| outcomes.iter().filter(move |outcome| outcome.threads == threads);
    let mut sets = Table::new(&["set", "contents", "bodies", "couples"]);
    for outcome in one(plan.threads[0]) {
        sets.row([
            outcome.set.name.to_owned(),
            outcome.set.title.to_owned(),
            grouped(outcome.n as u64),
            grouped(outcome.couples as u64),
        ]);
    }
    write!(text, "\n{sets}")?;
    if !plan.quick {
        writeln!(
            text,
            "\nMedian of {} rounds in turns, of fewer where a search took more than {} s for them; a search that takes less than 0.3 s runs once
uncounted before each. In brackets: times that of the first search of the table.",
            plan.rounds, plan.budget
        )?;
        if outcomes.iter().flat_map(|outcome| &outcome.searches).any(|search| search.rounded.is_some()) {
            writeln!(
                text,
                "{MARK} computes in `f32` and finds a few pairs more or fewer, at most {ROUNDED:e} of them; see the end."
            )?;
        }
        for &count in &plan.threads {
            for group in Group::ALL {
                let outcomes: Vec<&Outcome> =
                    one(count).filter(|outcome| outcome.set.group == group).collect();
                let Some(first) = outcomes.first().and_then(|outcome| outcome.searches.first()) else {
                    continue;
                };
                let title = format!("## {}, {}", threads(count), group.title());
                writeln!(text, "\n{title}: median [ms]\n")?;
                write!(text, "{}", matrix(called, &outcomes, |times| times.median))?;
                writeln!(text, "\n{title}: `{}` and the fastest peer, medians\n", first.name)?;
                write!(text, "{}", fastest(&outcomes))?;
                writeln!(text, "\n{title}: best round [ms]\n")?;
                write!(text, "{}", matrix(called, &outcomes, |times| times.best))?;
            }
        }
        if plan.threads.len() > 1 {
            writeln!(
                text,
                "\n## Ours, the first of each table: times as fast as on {}\n",
                threads(plan.threads[0])
            )?;
            write!(text, "{}", speedup(plan, outcomes))?;
        }
        writeln!(text, "\n## Memory of `rows`, beyond bodies and couples\n")?;
        write!(text, "{}", memory(outcomes))?;
        if !counted.is_empty() {
            writeln!(text, "\n## Counting: the gas with 12 neighbours, `rows`, {}\n", plan.simd.name())?;
            writeln!(text, "In brackets: times that of the first line.\n")?;
            write!(text, "{}", counts(plan, counted))?;
        }
    }
    writeln!(text, "\n## How they were called\n")?;
    let mut how = Table::new(&["search", "version", "how"]);
    for call in called {
        how.row([call.name.clone(), call.version.clone(), call.how.clone()]);
    }
    write!(text, "{how}")?;
    let mut remarks = String::new();
    for outcome in outcomes {
        for search in &outcome.searches {
            let begin = format!("- {}, {}, {}", outcome.set.name, threads(outcome.threads), search.name);
            if let Err(reason) = &search.times {
                writeln!(remarks, "{begin}: left out: {reason}")?;
            } else if let Some(pairs) = search.rounded {
                writeln!(
                    remarks,
                    "{begin}{MARK}: {} pairs, ours {}",
                    grouped(pairs),
                    grouped(outcome.couples as u64)
                )?;
            }
        }
    }
    if !remarks.is_empty() {
        write!(text, "\n## Left out, or other pairs\n\n{remarks}")?;
    }
    Ok(text)
}

/// A table with a row per search and a column per set.
fn matrix(called: &[Called], outcomes: &[&Outcome], of: fn(Times) -> f64) -> Table {
    let mut headings = vec!["search"];
    headings.extend(outcomes.iter().map(|outcome| outcome.set.name));
    let mut table = Table::new(&headings);
    let mut names: Vec<&str> = Vec::new();
    // Searches that have a time, or a reason for having none, on one of these sets.
    for call in
        called.iter().filter(|call| outcomes.iter().any(|outcome| outcome.search(&call.name).is_some()))
    {
        if !names.contains(&call.name.as_str()) {
            names.push(&call.name);
        }
    }
    for name in names {
        let cell = |outcome: &&Outcome| match (outcome.times(name), outcome.ours()) {
            (Some(times), Some(ours)) => {
                let mark = if outcome.search(name).is_some_and(|search| search.rounded.is_some()) {
                    MARK
                } else {
                    ""
                };
                format!("{}{mark} ({})", significant(1e3 * of(times)), significant(of(times) / of(ours)))
            }
            _ => "-".to_owned(),
        };
        table.row(std::iter::once(name.to_owned()).chain(outcomes.iter().map(cell)));
    }
    table
}

/// The times of the fastest peer relative to ours.
fn fastest(outcomes: &[&Outcome]) -> Table {
    let avx2 = EngineKind::RowsAvx2.name();
    // Included only if it takes part.
    let has_avx2 = outcomes.iter().any(|outcome| outcome.times(avx2).is_some());
    let headings = [
        "set",
        "ours [ms]",
        "ns per element",
        "ns per couple",
        "fastest peer",
        "its time [ms]",
        "times ours",
        &format!("times {avx2}"),
        &format!("{avx2}, ns per couple"),
    ];
    let columns = if has_avx2 { headings.len() } else { headings.len() - 2 };
    let mut table = Table::new(&headings[..columns]);
    for outcome in outcomes {
        let Some(ours) = outcome.ours() else { continue };
        let rival = outcome.fastest_rival();
        let limited = outcome.times(avx2);
        let shown = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), significant);
        let per_couple = |times: Times| 1e9 * times.median / outcome.couples.max(1) as f64;
        let cells = [
            outcome.set.name.to_owned(),
            significant(1e3 * ours.median),
            significant(1e9 * ours.median / outcome.n as f64),
            significant(per_couple(ours)),
            rival.map_or("-", |(name, _)| name).to_owned(),
            shown(rival.map(|(_, times)| 1e3 * times.median)),
            shown(rival.map(|(_, times)| times.median / ours.median)),
            shown(rival.zip(limited).map(|((_, times), limited)| times.median / limited.median)),
            shown(limited.map(per_couple)),
        ];
        table.row(cells.into_iter().take(columns));
    }
    table
}

/// A table with a row per number of threads and a column per set.
fn speedup(plan: &Plan, outcomes: &[Outcome]) -> Table {
    let mut headings = vec!["threads"];
    headings.extend(plan.sets.iter().map(|set| set.name));
    let mut table = Table::new(&headings);
    for &count in &plan.threads[1..] {
        let ours = |set: &Set, threads: usize| {
            let of = |outcome: &&Outcome| outcome.set.name == set.name && outcome.threads == threads;
            Some(outcomes.iter().find(of)?.ours()?.median)
        };
        let cell = |set: &&Set| match (ours(set, plan.threads[0]), ours(set, count)) {
            (Some(one), Some(many)) => significant(one / many),
            _ => "-".to_owned(),
        };
        table.row(std::iter::once(count.to_string()).chain(plan.sets.iter().map(cell)));
    }
    table
}

/// Bytes per element.
fn memory(outcomes: &[Outcome]) -> Table {
    let mut table = Table::new(&["set", "threads", "bytes", "bytes per element"]);
    for outcome in outcomes {
        if let Some(bytes) = outcome.search(EngineKind::Rows.name()).and_then(|search| search.bytes) {
            table.row([
                outcome.set.name.to_owned(),
                outcome.threads.to_string(),
                grouped(bytes as u64),
                format!("{:.1}", bytes as f64 / outcome.n as f64),
            ]);
        }
    }
    table
}

/// Nanoseconds per element.
fn counts(plan: &Plan, counted: &[Counted]) -> Table {
    let titles: Vec<String> =
        plan.threads.iter().map(|&count| format!("{} [ns per element]", threads(count))).collect();
    let mut headings = vec!["points", "couples", "bytes per element"];
    headings.extend(titles.iter().map(String::as_str));
    let mut table = Table::new(&headings);
    for line in counted {
        let per_element = |line: &Counted, index: usize| 1e9 * line.times[index].median / line.n as f64;
        let cells = (0..plan.threads.len()).map(|index| {
            let (here, first) = (per_element(line, index), per_element(&counted[0], index));
            format!("{} ({})", significant(here), significant(here / first))
        });
        let begin = [
            grouped(line.n as u64),
            grouped(line.couples),
            format!("{:.1}", line.bytes as f64 / line.n as f64),
        ];
        table.row(begin.into_iter().chain(cells));
    }
    table
}

/// The compiler flags of this program.
fn flags() -> String {
    let mut wide = Vec::new();
    if cfg!(target_feature = "avx2") {
        wide.push("avx2");
    }
    if cfg!(target_feature = "avx512f") {
        wide.push("avx512f");
    }
    let profile = "release: opt-level 3, no link-time optimisation, 1 codegen unit";
    if wide.is_empty() {
        format!("{profile}, no target-cpu")
    } else {
        format!("{profile}, compiled for {}", wide.join(" and "))
    }
}

fn threads(count: usize) -> String {
    format!("{count} thread{}", if count == 1 { "" } else { "s" })
}

/// The times on the sets with different size ratios, plotted against the ratio; `None` with fewer than two
/// such sets.
pub(crate) fn by_ratio(outcomes: &[Outcome], threads: usize) -> Option<Panel> {
    let of = |outcome: &&Outcome| outcome.threads == threads && outcome.set.ratio.is_some();
    let outcomes: Vec<&Outcome> = outcomes.iter().filter(of).collect();
    let ratios: Vec<f64> = outcomes.iter().filter_map(|outcome| outcome.set.ratio).collect();
    let mut curves: Vec<Curve> = Vec::new();
    for search in outcomes.iter().flat_map(|outcome| &outcome.searches) {
        if curves.iter().any(|curve| curve.name == search.name) {
            continue;
        }
        let time = |outcome: &&Outcome| Some((outcome.set.ratio?, 1e3 * outcome.times(&search.name)?.median));
        let points: Vec<(f64, f64)> = outcomes.iter().filter_map(time).collect();
        if !points.is_empty() {
            let colour = if search.ours { curves.len().min(1) } else { 2 };
            curves.push(Curve { name: search.name.clone(), colour, hollow: !search.ours, points });
        }
    }
    (ratios.len() > 1 && !curves.is_empty()).then(|| Panel {
        title: "Time against the ratio of sizes, 1,000,000 spheres".to_owned(),
        x: Axis::within("largest / smallest radius", &[1.0, 10.0, 100.0, 1000.0], ratios),
        y: Axis::covering(
            "time [ms]",
            10.0,
            1.0,
            curves.iter().flat_map(|curve| &curve.points).map(|&(_, time)| time),
        ),
        curves,
    })
}

/// The times of one result, the smallest first.
pub(crate) fn bars(outcome: &Outcome) -> Bars {
    let mut bars: Vec<Bar> = Vec::new();
    for search in &outcome.searches {
        if let (Ok(Some(times)), Some(ours)) = (&search.times, outcome.ours()) {
            bars.push(Bar {
                name: search.name.clone(),
                value: 1e3 * times.median,
                remark: format!("ms, {}x", significant(times.median / ours.median)),
                bold: search.ours,
            });
        }
    }
    bars.sort_by(|a, b| a.value.total_cmp(&b.value));
    Bars { title: format!("{}; {}", outcome.set.title, threads(outcome.threads)), bars }
}
