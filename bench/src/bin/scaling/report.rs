//! The tables in Markdown.

use std::fmt::Write as _;

use fdem_bench::{Table, grouped, machine, significant};
use fdem_mesh::MOST_ELEMENTS;
use fdem_simulation::{Forecast, RankForecast};

use crate::estimate::Estimate;
use crate::pattern::Pattern;

/// Numbers of ranks of the model.
const RANKS: [usize; 5] = [1, 10, 100, 1_000, 10_000];

/// Elements of each rank in weak scaling, and of all together in strong scaling.
const WEAK: [f64; 3] = [1e4, 1e5, 1e6];
const STRONG: [f64; 4] = [1e6, 1e7, 1e8, 1e9];

/// Efficiencies at which the model bends.
const BENDS: [f64; 3] = [0.5, 0.8, 0.9];

/// Names of elements, and of elements with joints on all faces.
pub(crate) fn name(joined: bool) -> &'static str {
    if joined { "joined" } else { "elastic" }
}

fn count(number: f64) -> String {
    grouped(number.round() as u64)
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn kilobytes(bytes: f64) -> String {
    significant(bytes / 1e3)
}

/// `patterns`, `estimates`: elastic, joined. `timed`: elements of the mesh whose steps were timed.
pub(crate) fn report(patterns: &[Pattern], estimates: &[Estimate], timed: usize, rounds: usize) -> String {
    let mut out = format!("# Scaling of a run on many ranks\n\n{}.\n\n", machine(&[1]));
    let network = estimates[0].network;
    let [latency, bandwidth] =
        [1e6 * network.latency, 1e-9 * network.bandwidth].map(|number| format!("{number:.0}"));
    let elements = grouped(patterns[0].elements as u64);
    let most = grouped(MOST_ELEMENTS as u64);
    let _ = writeln!(
        out,
        "Written by `cargo run --release -p fdem-bench --bin scaling -- --write bench/SCALING.md`. Nothing here ran on many ranks. The counts are exact: they are those that the ranks of a run have at its beginning, \
         and tests compare them with such runs on 2, 3 and 8 ranks. The time of an element is measured on one core. The network is assumed: {latency} µs for a message, {bandwidth} GB/s for each rank. \
         All that follows from these three is a model, and is named so.\n\n\
         ## Communication pattern\n\n\
         A cube of {elements} tetrahedra, cut by the mesher of this project. *Elastic*: neighbours share nodes. *Joined*: a joint on every face, so that each element has separate nodes. \
         A node that goes to two ranks counts twice. *Halo share*: elements in all halos over the elements of the model. *Imbalance*: work of the busiest rank over the mean, as the division weighs it.\n\n{}\n{}",
        shares(patterns),
        messages(patterns)
    );
    let _ = writeln!(
        out,
        "Halo elements for a rank with n own elements, over n^⅔: the constant of the model comes from the rank with most, in the last row of each kind. \
         It is less for larger parts, so the model is cautious about them. *Near others only*: elements of all halos that act on no node of the rank, but lie so near to the outer surface of its part of the body that they might come to touch it.\n\n{}",
        layers(patterns)
    );
    let _ = writeln!(
        out,
        "## Inputs of the model\n\n\
         A rank with n own elements computes n + h n^⅔ of them in a step, on one core. It exchanges messages with k neighbours, b bytes for each element of its halo, and takes part in one agreement of all P ranks: 2 ⌈log₂ P⌉ times the latency. \
         Messages and computing do not overlap. The time of an element is that in the fastest of {rounds} rounds on a mesh of {} tetrahedra, without the time in which other programs had the core.\n\n{}",
        grouped(timed as u64),
        inputs(estimates)
    );
    let _ = writeln!(
        out,
        "## Model: weak scaling\n\nThe same number of elements on each rank; the efficiency is the time of these elements on one core over that of a step on all ranks.\n\n{}",
        weak(estimates)
    );
    let _ = writeln!(
        out,
        "## Model: strong scaling\n\nThe same number of elements on all ranks together. In brackets: how many times as fast as one core. Fewer than 100 elements on a rank are left out.\n\n{}",
        strong(estimates)
    );
    let _ = writeln!(
        out,
        "## Model: where it bends\n\nElements on each of 10,000 ranks at which the efficiency is this, and the parts of a step there.\n\n{}",
        bends(estimates)
    );
    let [elastic, joined] = [0, 1].map(|kind: usize| estimates[kind].memory[1] * 1e9 / 1e12).map(significant);
    let _ = writeln!(
        out,
        "## Limits of the model\n\n\
         - A model file may have {most} elements. Larger rows show the limits by the division and the messages, not by a run that can be started.\n\
         - Rank 0 has the whole model at the beginning, and gives the others their elements. For 10⁹ elements it would need {elastic} TB (elastic) or {joined} TB (joined): this is the first limit that a large run meets.\n\
         - Contacts are left out. A couple that touches costs as much as several elements, and crowds where bodies meet; ranks then get other elements, which takes time that is not counted here.\n\
         - Joints that are inserted or break are sent to neighbours in separate messages, in the steps in which that happens.\n\
         - Cores of one machine share its memory bandwidth and its network card. The time of an element is that of one busy core, on a machine that others use too.\n\
         - Frames and checkpoints are gathered on rank 0.\n\
         - The step waits for the slowest rank. Noise of the machines adds to the agreement."
    );
    out
}

/// The first three cells of a row.
fn head(joined: bool, forecast: &Forecast) -> [String; 2] {
    [name(joined).to_owned(), grouped(forecast.ranks() as u64)]
}

fn rows(patterns: &[Pattern]) -> impl Iterator<Item = (bool, &Forecast)> {
    patterns
        .iter()
        .zip([false, true])
        .flat_map(|(pattern, joined)| pattern.forecasts.iter().map(move |forecast| (joined, forecast)))
}

fn shares(patterns: &[Pattern]) -> Table {
    let headings = [
        "kind",
        "ranks",
        "nodes",
        "own elements, mean",
        "halo, mean",
        "halo, most",
        "halo share",
        "imbalance",
        "bytes per element",
        "memory of a rank, most [MB]",
    ];
    let mut table = Table::new(&headings);
    for (pattern, joined) in patterns.iter().zip([false, true]) {
        for forecast in &pattern.forecasts {
            let memory = forecast.of_ranks.iter().map(|rank| rank.memory).max().unwrap_or_default();
            table.row(head(joined, forecast).into_iter().chain([
                grouped(pattern.nodes as u64),
                count(forecast.mean(|rank| rank.own)),
                count(forecast.mean(|rank| rank.halo)),
                grouped(forecast.most(|rank| rank.halo) as u64),
                percent(forecast.halo_share()),
                format!("{:.3}", forecast.imbalance()),
                count(forecast.sizes.all()),
                significant(memory as f64 / 1e6),
            ]));
        }
    }
    table
}

fn messages(patterns: &[Pattern]) -> Table {
    let headings = [
        "kind",
        "ranks",
        "neighbours, mean",
        "neighbours, most",
        "nodes sent, mean",
        "kB sent, mean",
        "kB sent, most",
        "largest message [kB]",
        "MB of all ranks",
    ];
    let mut table = Table::new(&headings);
    for (joined, forecast) in rows(patterns) {
        let mean = forecast.mean(|rank| rank.bytes);
        table.row(head(joined, forecast).into_iter().chain([
            format!("{:.1}", forecast.mean(|rank| rank.neighbours)),
            grouped(forecast.most(|rank| rank.neighbours) as u64),
            count(forecast.mean(|rank| rank.sent)),
            kilobytes(mean),
            kilobytes(forecast.most(|rank| rank.bytes) as f64),
            kilobytes(forecast.most(|rank| rank.largest) as f64),
            significant(mean * forecast.ranks() as f64 / 1e6),
        ]));
    }
    table
}

fn layers(patterns: &[Pattern]) -> Table {
    let headings = [
        "kind",
        "ranks",
        "halo / n^⅔, mean",
        "halo / n^⅔, most",
        "bytes per halo element, mean",
        "near others only",
    ];
    let mut table = Table::new(&headings);
    for (joined, forecast) in rows(patterns) {
        let layer = forecast.mean(|rank| rank.own).powf(2.0 / 3.0);
        let [own, halo] = [forecast.mean(|rank| rank.own), forecast.mean(|rank| rank.halo)];
        let most = forecast.most(RankForecast::held) as f64 - own;
        let near: usize = forecast.of_ranks.iter().map(|rank| rank.near).sum();
        table.row(head(joined, forecast).into_iter().chain([
            significant(halo / layer),
            significant(most / layer),
            significant(forecast.mean(|rank| rank.bytes) / halo),
            grouped(near as u64),
        ]));
    }
    table
}

fn inputs(estimates: &[Estimate]) -> Table {
    let headings = [
        "kind",
        "ns per element",
        "h",
        "k",
        "b [bytes]",
        "latency [µs]",
        "bandwidth [GB/s]",
        "bytes per element",
        "on rank 0 at the beginning",
    ];
    let mut table = Table::new(&headings);
    for (estimate, joined) in estimates.iter().zip([false, true]) {
        table.row([
            name(joined).to_owned(),
            significant(1e9 * estimate.seconds),
            significant(estimate.halo),
            count(estimate.neighbours),
            significant(estimate.bytes),
            format!("{:.0}", 1e6 * estimate.network.latency),
            format!("{:.0}", 1e-9 * estimate.network.bandwidth),
            count(estimate.memory[0]),
            count(estimate.memory[1]),
        ]);
    }
    table
}

/// Headings: some cells, and the numbers of ranks.
fn by_ranks(first: &[&str]) -> Table {
    let ranks =
        RANKS.map(|ranks| format!("{} rank{}", grouped(ranks as u64), if ranks == 1 { "" } else { "s" }));
    let headings: Vec<&str> = first.iter().copied().chain(ranks.iter().map(String::as_str)).collect();
    Table::new(&headings)
}

fn weak(estimates: &[Estimate]) -> Table {
    let mut table = by_ranks(&["kind", "elements of a rank", "elements on most ranks"]);
    for (estimate, joined) in estimates.iter().zip([false, true]) {
        for own in WEAK {
            let efficiencies = RANKS.map(|ranks| percent(estimate.step(own, ranks).efficiency()));
            let all = own * RANKS[RANKS.len() - 1] as f64;
            table.row([name(joined).to_owned(), count(own), count(all)].into_iter().chain(efficiencies));
        }
    }
    table
}

fn strong(estimates: &[Estimate]) -> Table {
    let mut table = by_ranks(&["kind", "elements"]);
    for (estimate, joined) in estimates.iter().zip([false, true]) {
        for elements in STRONG {
            let efficiencies = RANKS.map(|ranks| {
                let own = elements / ranks as f64;
                if own < 100.0 {
                    return "-".to_owned();
                }
                let efficiency = estimate.step(own, ranks).efficiency();
                format!("{} ({})", percent(efficiency), count(efficiency * ranks as f64))
            });
            table.row([name(joined).to_owned(), count(elements)].into_iter().chain(efficiencies));
        }
    }
    table
}

fn bends(estimates: &[Estimate]) -> Table {
    let headings = [
        "kind",
        "efficiency",
        "elements of a rank",
        "halo elements",
        "step [ms]",
        "own",
        "halo",
        "messages",
        "agreement",
    ];
    let mut table = Table::new(&headings);
    let ranks = RANKS[RANKS.len() - 1];
    for (estimate, joined) in estimates.iter().zip([false, true]) {
        for efficiency in BENDS {
            let own = estimate.elements_at(efficiency, ranks);
            let step = estimate.step(own, ranks);
            table.row(
                [
                    name(joined).to_owned(),
                    format!("{:.0} %", 100.0 * efficiency),
                    count(own),
                    count(estimate.halo(own)),
                    significant(1e3 * step.own / step.efficiency()),
                ]
                .into_iter()
                .chain(step.shares().map(percent)),
            );
        }
    }
    table
}
