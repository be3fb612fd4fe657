//! `fdem contacts --analyse` analyses the network of contacts and shows the result in the summary.

use std::fmt;
use std::sync::atomic::AtomicU64;

use fdem_io::numbers::{brief, grouped};
use fdem_results::analysis::{
    Analysis, AnalysisError, Forces, Frictionless, Options, RadialOptions, Voids, WithoutRattlers,
    analyse_counted,
};
use fdem_results::network::Network;

use crate::command::args::AnalyseArguments;
use crate::command::failure::Failure;

/// Returns the analysis of the network, or `None` without `--analyse`.
pub(crate) fn run<const D: usize>(
    arguments: &AnalyseArguments,
    threads: usize,
    network: &Network<'_, D>,
    name: &str,
    handled: &AtomicU64,
) -> Result<Option<Analysis>, Failure> {
    if !arguments.analyse {
        return Ok(None);
    }
    let inner = match &arguments.inner {
        Some(limits) if limits.0.len() == 2 * D => {
            Some(std::array::from_fn(|axis| [limits.0[2 * axis], limits.0[2 * axis + 1]]))
        }
        Some(limits) => {
            return Err(Failure::Unusable(format!(
                "--inner: a packing in {D}D needs {} numbers, the limits of each axis, not {}",
                2 * D,
                limits.0.len()
            )));
        }
        None => None,
    };
    let radial = match &arguments.rdf {
        Some(numbers) => radial(&numbers.0)?,
        None => RadialOptions::default(),
    };
    let options =
        Options { min_contacts: arguments.rattlers, inner, radial, voids: arguments.voids, threads };
    analyse_counted(network, &options, handled).map(Some).map_err(|error| {
        Failure::Unusable(match error {
            AnalysisError::Region { .. } | AnalysisError::ShearedBox => format!("--inner: {error}"),
            AnalysisError::Radial { .. } => format!("--rdf: {error}"),
            _ => format!("{name}: --analyse: {error}"),
        })
    })
}

/// Reads the numbers of `--rdf`: `R` or `R,BINS`.
fn radial(numbers: &[f64]) -> Result<RadialOptions, Failure> {
    let wrong = |why: String| Err(Failure::Unusable(format!("--rdf: {why}")));
    match numbers {
        [r_max] => Ok(RadialOptions { r_max: Some(*r_max), bins: None }),
        // The analysis refuses too many bins.
        [r_max, bins] if bins.fract() == 0.0 && *bins >= 0.0 => {
            Ok(RadialOptions { r_max: Some(*r_max), bins: Some(*bins as usize) })
        }
        [_, bins] => wrong(format!("{bins} is not a number of bins")),
        _ => wrong(format!(
            "give the largest distance, or that and the number of bins, not {} numbers",
            numbers.len()
        )),
    }
}

/// The numbers of rattlers and of the elements that remain, as a line of the summary.
fn rattlers(rest: &WithoutRattlers) -> String {
    let others = match rest.elements {
        0 => "none remains".to_owned(),
        left => format!("{} remain with {:.4} contacts each", grouped(left), rest.mean),
    };
    format!(
        "{} of {} (removed repeatedly: fewer than {} contacts each); {others}",
        grouped(rest.rattlers),
        grouped(rest.rattlers + rest.elements),
        rest.min_contacts,
    )
}

/// Writes the analysis as lines of the summary.
pub(crate) fn write_lines(out: &mut fmt::Formatter<'_>, analysis: &Analysis, unit: &str) -> fmt::Result {
    let mut line = |label: &str, text: String| writeln!(out, "{label:<16} {text}");
    line("contacts each", distribution(&analysis.coordination.distribution))?;
    let rest = &analysis.without_rattlers;
    line("rattlers", rattlers(rest))?;
    if let Some(Frictionless { min_contacts, elements }) = rest.frictionless {
        let left = grouped(elements);
        line(
            "",
            format!("as with friction; {left} would remain without friction (--rattlers {min_contacts})"),
        )?;
    }
    if let Some(fabric) = &analysis.fabric {
        let first = vector(&fabric.principal_directions[0]);
        line(
            "fabric",
            format!(
                "eigenvalues {}, most contacts along {first}; anisotropy {:.4}",
                fabric.eigenvalues.iter().map(|x| format!("{x:.4}")).collect::<Vec<_>>().join(", "),
                fabric.anisotropy
            ),
        )?;
    }
    let clusters = &analysis.clusters;
    line(
        "clusters",
        format!(
            "{}, the largest of {} elements; {}",
            grouped(clusters.count),
            grouped(clusters.largest),
            percolation(analysis)
        ),
    )?;
    let of_radius = analysis.overlaps.mean_over_radius;
    for (label, spread, part) in
        [("overlaps", &analysis.overlaps.overlaps, of_radius), ("gaps", &analysis.overlaps.gaps, None)]
    {
        if let Some(spread) = spread {
            let part = part.map(|part| format!(", {} of the mean radius", brief(part))).unwrap_or_default();
            line(
                label,
                format!(
                    "{}, {} to {}{unit}, mean {}{unit}{part}",
                    grouped(spread.count),
                    brief(spread.min),
                    brief(spread.max),
                    brief(spread.mean)
                ),
            )?;
        }
    }
    if let Some(forces) = &analysis.forces {
        forces_lines(&mut line, forces)?;
    }
    match (&analysis.packing, &analysis.no_packing) {
        (Some(packing), _) => {
            let sides: Vec<_> = packing
                .region
                .iter()
                .map(|[min, max]| format!("[{}, {}]", brief(*min), brief(*max)))
                .collect();
            line(
                "packing fraction",
                format!(
                    "{:.5} in {}{unit}; at least {:.5} without counting overlaps twice",
                    packing.fraction,
                    sides.join(" x "),
                    packing.fraction_without_overlap
                ),
            )
        }
        (None, reason) => {
            line("packing fraction", format!("none: {}", reason.as_deref().unwrap_or_default()))
        }
    }?;
    match (&analysis.voids, &analysis.no_voids) {
        (Some(voids), _) => voids_lines(&mut line, voids, unit)?,
        (None, Some(reason)) => line("voids", format!("none: {reason}"))?,
        (None, None) => {}
    }
    match (&analysis.radial, &analysis.no_radial) {
        (Some(radial), _) => {
            let peak = radial
                .g
                .iter()
                .zip(&radial.r)
                .fold((0.0, 0.0), |peak: (f64, f64), (&g, &r)| if g > peak.0 { (g, r) } else { peak });
            line(
                "g(r)",
                format!(
                    "up to {}{unit}, largest {:.3} at {}{unit}",
                    brief(radial.r_max),
                    peak.0,
                    brief(peak.1)
                ),
            )
        }
        (None, reason) => line("g(r)", format!("none: {}", reason.as_deref().unwrap_or_default())),
    }
}

/// Writes the forces and the stress in the units of the file, which are not known.
fn forces_lines(line: &mut impl FnMut(&str, String) -> fmt::Result, forces: &Forces) -> fmt::Result {
    let (Some(mean), Some(largest), Some(share)) = (forces.mean, forces.largest, forces.strong_share) else {
        return line("forces", "none: there are no couples".to_owned());
    };
    let carried = match forces.strong_pressure_share {
        Some(share) => format!(", which carry {share:.4} of the pressure"),
        None => String::new(),
    };
    let strong = grouped(forces.strong);
    line(
        "forces",
        format!(
            "mean {}, largest {}; {strong} above the mean, {share:.4} of the couples{carried}",
            brief(mean),
            brief(largest)
        ),
    )?;
    match (&forces.stress, forces.pressure) {
        (Some(stress), Some(pressure)) => {
            let row = |row: &Vec<f64>| {
                let entries: Vec<_> = row.iter().map(|&entry| brief(entry)).collect();
                format!("[{}]", entries.join(", "))
            };
            let rows: Vec<_> = stress.iter().map(row).collect();
            line(
                "stress",
                format!(
                    "{}, tension positive; pressure {}; V = {}",
                    rows.join(", "),
                    brief(pressure),
                    brief(forces.measure)
                ),
            )
        }
        _ => line("stress", "none: the domain has no area or volume".to_owned()),
    }
}

/// Writes the local void ratios and the sizes of pores.
fn voids_lines(line: &mut impl FnMut(&str, String) -> fmt::Result, voids: &Voids, unit: &str) -> fmt::Result {
    let left_out = match (voids.at_border, voids.hidden) {
        (0, 0) => String::new(),
        (border, 0) => format!("; {} at the border left out", grouped(border)),
        (border, hidden) => {
            format!("; {} at the border and {} hidden ones left out", grouped(border), grouped(hidden))
        }
    };
    match &voids.void_ratio {
        Some(ratio) => line(
            "void ratio",
            format!(
                "of each of {}: {} to {}, mean {}{left_out}",
                grouped(ratio.count),
                brief(ratio.min),
                brief(ratio.max),
                brief(ratio.mean)
            ),
        ),
        None => line("void ratio", format!("of none{left_out}")),
    }?;
    let share = format!("{:.4} of {} points are in voids", voids.porosity, grouped(voids.samples));
    match &voids.pores {
        Some(pores) => line(
            "pores",
            format!(
                "{share}; distance to the nearest surface: mean {}{unit}, largest {}{unit}",
                brief(pores.mean),
                brief(pores.max)
            ),
        ),
        None => line("pores", share),
    }
}

/// Number of elements with each number of contacts, as `0: 12, 1: 345, …`.
fn distribution(counts: &[u64]) -> String {
    /// Most entries that are shown: more do not fit on a line.
    const MOST: usize = 14;
    let mut parts: Vec<_> = counts.iter().enumerate().filter(|(_, count)| **count > 0).collect();
    let more = parts.len().saturating_sub(MOST);
    parts.truncate(MOST);
    let mut text: Vec<_> = parts.iter().map(|(k, count)| format!("{k}: {}", grouped(**count))).collect();
    if more > 0 {
        text.push(format!("… up to {}", counts.len() - 1));
    }
    text.join(", ")
}

fn vector(components: &[f64]) -> String {
    let numbers: Vec<_> = components.iter().map(|x| format!("{x:.3}")).collect();
    format!("[{}]", numbers.join(", "))
}

fn percolation(analysis: &Analysis) -> String {
    let axes = |periodic: bool| {
        let along = analysis.clusters.percolation.iter().filter(|along| along.percolates);
        let names = along.filter(|along| along.periodic == periodic).map(|along| ["x", "y", "z"][along.axis]);
        names.collect::<Vec<_>>().join(", ")
    };
    match (axes(true), axes(false)) {
        (around, faces) if around.is_empty() && faces.is_empty() => "none percolates".to_owned(),
        (around, faces) if faces.is_empty() => format!("percolates around the box along {around}"),
        (around, faces) if around.is_empty() => format!("percolates from face to face along {faces}"),
        (around, faces) => {
            format!("percolates around the box along {around}, from face to face along {faces}")
        }
    }
}
