//! `fdem validate` runs the verification ladder, case by case.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::Instant;

use crate::command::args::ValidateArguments;
use crate::command::failure::Failure;
use crate::command::output::{Output, print};
use fdem_validate::{Case, CaseReport, Size, cases, html, table};

pub(crate) fn run(arguments: &ValidateArguments) -> Result<(), Failure> {
    if arguments.list {
        return print(&list());
    }
    let size = if arguments.full { Size::Full } else { Size::Reduced };
    let chosen = chosen(&arguments.cases)?;
    let mut output = arguments.html.as_deref().map(|path| Output::open(Some(path))).transpose()?;
    let start = Instant::now();
    let mut reports = Vec::new();
    reports_in_order(&chosen, size, |report| {
        let seconds = start.elapsed().as_secs_f64();
        // A message that cannot be shown is not an error.
        let _ = writeln!(io::stdout(), "{}", table(std::slice::from_ref(&report)).trim_end());
        if !arguments.quiet {
            let _ = writeln!(io::stderr(), "after {seconds:.0} s");
        }
        reports.push(report);
    });
    if let Some(output) = &mut output {
        output.write(|out| out.write_all(html(&reports, size).as_bytes()))?;
    }
    output.map_or(Ok(()), Output::commit)?;
    let failed = reports.iter().filter(|report| !report.passed()).count();
    if failed > 0 {
        return Err(Failure::Wrong(format!("{failed} of {} cases failed", reports.len())));
    }
    let all = if reports.len() == 1 { "the case".to_owned() } else { format!("all {} cases", reports.len()) };
    let _ = writeln!(io::stdout(), "{all} passed");
    Ok(())
}

/// Runs cases on all processors, and passes their reports to `show` in the order of the cases.
fn reports_in_order(cases: &[&'static Case], size: Size, mut show: impl FnMut(CaseReport)) {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let threads = thread::available_parallelism().map_or(1, usize::from).min(cases.len());
    thread::scope(|scope| {
        for _ in 0..threads {
            let (next, sender) = (&next, sender.clone());
            scope.spawn(move || {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some(case) = cases.get(place) else { break };
                    // The receiver lives as long as this scope.
                    let _ = sender.send((place, case.report(size)));
                }
            });
        }
        drop(sender);
        // Reports that have come before one of an earlier case.
        let mut early = BTreeMap::new();
        let mut shown = 0;
        for (place, report) in receiver {
            early.insert(place, report);
            while let Some(report) = early.remove(&shown) {
                show(report);
                shown += 1;
            }
        }
    });
}

/// A line for each case: its number and its name.
fn list() -> String {
    let line = |case: &Case| format!("{:2} {}\n", case.number, case.name);
    cases().iter().map(line).collect()
}

/// Returns the cases with the given numbers, or whose names contain the given words, in letters of any case.
/// Without any it returns all cases.
fn chosen(asked: &[String]) -> Result<Vec<&'static Case>, Failure> {
    if asked.iter().any(|asked| asked.trim().is_empty()) {
        return Err(Failure::Unusable(
            "a case is asked for by its number or by words of its name, not by \"\"".to_owned(),
        ));
    }
    if let Some(unknown) = asked.iter().find(|asked| !cases().iter().any(|case| is(case, asked))) {
        return Err(Failure::Unusable(format!(
            "there is no case '{unknown}', but these:\n{}",
            list().trim_end()
        )));
    }
    Ok(cases().iter().filter(|case| asked.is_empty() || asked.iter().any(|asked| is(case, asked))).collect())
}

fn is(case: &Case, asked: &str) -> bool {
    asked.parse() == Ok(case.number)
        || (asked.parse::<u32>().is_err() && case.name.to_lowercase().contains(&asked.to_lowercase()))
}
