//! The results of the cases as text and as a page.

use std::fmt::Write;

use fdem_io::numbers::brief;
use fdem_results::page::{STYLE, escape, hash};

use super::{CaseReport, Measure, Outcome, Size};

const STYLE_OF_CASES: &str = ".numbers td:nth-child(1), .numbers th:nth-child(1) { text-align: left; white-space: normal; }\n\
    .case { max-width: 70em; } .case h2 { margin-bottom: 2px; } .case p { margin: 0 0 6px; }\n\
    .failed { color: var(--ring); font-weight: 600; }\n";

/// Headings of the columns.
const HEADS: [&str; 6] = ["quantity", "expected", "found", "error", "bound", "verdict"];

/// The outcomes as lines of text: a line for each case, and below it one for each quantity, in columns.
pub fn table(reports: &[CaseReport]) -> String {
    let rows: Vec<[String; 6]> = std::iter::once(HEADS.map(str::to_owned))
        .chain(reports.iter().flat_map(|report| report.result.iter().flatten()).map(cells))
        .collect();
    let widths: [usize; 6] =
        std::array::from_fn(|k| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0));
    // Writing to a string cannot fail.
    let line = |text: &mut String, row: &[String; 6]| {
        let _ = write!(text, "  {:<width$}", row[0], width = widths[0]);
        for k in 1..5 {
            let _ = write!(text, "  {:>width$}", row[k], width = widths[k]);
        }
        let _ = writeln!(text, "  {}", row[5]);
    };
    let mut text = String::new();
    line(&mut text, &HEADS.map(str::to_owned));
    for report in reports {
        let _ = writeln!(text, "{}. {}", report.case.number, report.case.name);
        match &report.result {
            Ok(outcomes) => outcomes.iter().for_each(|outcome| line(&mut text, &cells(outcome))),
            Err(message) => {
                let _ = writeln!(text, "  FAILED: {message}");
            }
        }
    }
    text
}

/// The outcomes as an HTML page that works offline and has no script.
pub fn html(reports: &[CaseReport], size: Size) -> String {
    let style = format!("{STYLE}{STYLE_OF_CASES}");
    let failed = reports.iter().filter(|report| !report.passed()).count();
    let verdict = if failed == 0 {
        format!("All {} cases passed", reports.len())
    } else {
        format!("<span class=\"failed\">{failed} of {} cases failed</span>", reports.len())
    };
    let models = match size {
        Size::Reduced => "models of reduced size",
        Size::Full => "models of full size",
    };
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src '{}'; base-uri 'none'; form-action 'none'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n\
         <meta name=\"generator\" content=\"fdem\">\n<title>Verification of fdem</title>\n<style>{style}</style>\n</head>\n<body>\n\
         <header><div><h1>Verification of fdem</h1><p class=\"lead\">{verdict}: {models}</p></div></header>\n<main>\n",
        hash(&style),
    );
    for report in reports {
        section(&mut page, report);
    }
    page += "</main>\n<footer><p>Made by <code>fdem validate</code>, version ";
    page += env!("CARGO_PKG_VERSION");
    page += ". This file works offline.</p></footer>\n</body>\n</html>\n";
    page
}

fn section(page: &mut String, report: &CaseReport) {
    let case = report.case;
    let _ = writeln!(
        page,
        "<section class=\"case\">\n<h2>{}. {}</h2>\n<p>{} <span class=\"hint\">{}.</span></p>",
        case.number,
        escape(case.name),
        escape(case.what),
        escape(case.source)
    );
    match &report.result {
        Err(message) => {
            let _ = writeln!(page, "<p class=\"failed\">failed: {}</p>", escape(message));
        }
        Ok(outcomes) => {
            page.push_str("<div class=\"scroll\"><table class=\"numbers\">\n<thead><tr>");
            for head in HEADS {
                let _ = write!(page, "<th scope=\"col\">{head}</th>");
            }
            page.push_str("</tr></thead>\n<tbody>\n");
            for outcome in outcomes {
                page.push_str("<tr>");
                for (k, cell) in cells(outcome).iter().enumerate() {
                    let class = if k == 5 && !outcome.passed() { " class=\"failed\"" } else { "" };
                    let _ = write!(page, "<td{class}>{}</td>", escape(cell));
                }
                page.push_str("</tr>\n");
            }
            page.push_str("</tbody>\n</table></div>\n");
        }
    }
    page.push_str("</section>\n");
}

fn cells(outcome: &Outcome) -> [String; 6] {
    let with_unit = |value: f64| format!("{} {}", brief(value), outcome.unit).trim_end().to_owned();
    let error = |value: f64| match outcome.measure {
        _ if value == 0.0 => "0".to_owned(),
        Measure::Relative if value.abs() < 1e-5 => format!("{:.0e} %", 100.0 * value),
        Measure::Relative => format!("{:.3} %", 100.0 * value),
        Measure::Absolute | Measure::Skipped => format!("{value:.1e}"),
    };
    if outcome.measure == Measure::Skipped {
        return [&outcome.quantity, "", "", "", "", "skipped"].map(str::to_owned);
    }
    [
        outcome.quantity.clone(),
        with_unit(outcome.expected),
        with_unit(outcome.found),
        error(outcome.error),
        error(outcome.bound),
        if outcome.passed() { "passed" } else { "FAILED" }.to_owned(),
    ]
}
