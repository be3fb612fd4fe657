//! Runs that are killed or interrupted, and continue.

use std::fs;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::CRASH;
use crate::{Bench, thorough};

#[test]
fn a_run_killed_at_any_moment_goes_on_to_the_same_end() {
    let bench = Bench::of(CRASH);
    let start = Instant::now();
    bench.run(&["run", "crash.toml", "--output", "whole", "--threads", "1"]).succeeds();
    let usual = start.elapsed();
    let whole = bench.fingerprint("whole");
    let (mut kills, mut resumed, mut state) = (0, 0, 99_u64);
    let enough = if thorough() { 50 } else { 10 };
    while kills < enough {
        // A pseudorandom share of the usual time.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let share = (state >> 40) as f64 / f64::from(1 << 24);
        let patience = Duration::from_secs_f64(usual.as_secs_f64() * share * 0.6);
        let exists = bench.path("cut/checkpoint").exists();
        let mut child = if exists {
            resumed += 1;
            bench.start(&["resume", "cut", "--threads", if kills % 2 == 0 { "1" } else { "2" }])
        } else {
            bench.start(&["run", "crash.toml", "--output", "cut", "--force", "--threads", "1"])
        };
        thread::sleep(patience);
        if child.try_wait().unwrap().is_some() {
            // The run had finished: it has the results of an uninterrupted run. Begin again.
            bench.is_like("cut", &whole);
            fs::remove_dir_all(bench.path("cut")).unwrap();
            continue;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        bench.has_all_that_collections_name("cut");
        kills += 1;
    }
    if bench.path("cut/checkpoint").exists() {
        bench.run(&["resume", "cut"]).succeeds();
        bench.is_like("cut", &whole);
    }
    assert!(resumed > enough * 2 / 5, "most should have been killed after a checkpoint: {resumed}");
}

/// The report of an earlier end is not taken for that of this one.
#[test]
fn a_run_killed_while_it_draws_is_drawn_again() {
    let bench = Bench::of(CRASH);
    bench.run(&["run", "crash.toml", "--output", "whole", "--threads", "1", "-q"]).succeeds();
    let end = bench.summary("whole")["time"].as_f64().unwrap();
    bench
        .run(&[
            "run",
            "crash.toml",
            "--output",
            "cut",
            "-q",
            "--set",
            &format!("model.end_time={}", 0.5 * end),
        ])
        .succeeds();
    let half = bench.summary("cut")["steps"].as_u64().unwrap();
    let mut child = bench.start(&["resume", "cut", "-q", "--threads", "1", "--end-time", &format!("{end}")]);
    let is_drawing = || {
        let text = fs::read_to_string(bench.path("cut/run.json")).unwrap_or_default();
        let json: Value = serde_json::from_str(&text).unwrap_or_default();
        json["status"] == "finished" && json["steps"].as_u64() > Some(half)
    };
    while child.try_wait().unwrap().is_none() && !is_drawing() {
        thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    bench.run(&["resume", "cut", "-q"]).succeeds();
    let steps = |folder: &str| {
        let report = bench.read(&format!("{folder}/report.html"));
        let (_, rest) = report.split_once(" s in ").unwrap();
        rest.split_once(" steps").unwrap().0.to_owned()
    };
    assert_eq!(steps("cut"), steps("whole"));
}

/// A run with a later end that is killed after its last checkpoint and before its summary has the summary and
/// the report of the earlier end.
#[test]
fn a_run_killed_before_its_summary_is_drawn_again() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "0.05e-3"));
    bench.run(&["run", "crash.toml", "-q", "-o", "run"]).succeeds();
    let files = ["run.json", "report.html"].map(|name| bench.path("run").join(name));
    let earlier = files.each_ref().map(|file| fs::read(file).unwrap());
    bench.run(&["resume", "-q", "run", "--end-time", "0.06e-3"]).succeeds();
    let steps = bench.summary("run")["steps"].clone();
    for (file, bytes) in files.iter().zip(&earlier) {
        fs::write(file, bytes).unwrap();
    }
    assert_ne!(bench.summary("run")["steps"], steps);
    bench.run(&["resume", "-q", "run"]).succeeds();
    assert_eq!(bench.summary("run")["steps"], steps);
    assert!(fs::read(&files[1]).unwrap() != earlier[1], "the report is that of the earlier end");
}

#[cfg(unix)]
#[test]
fn an_interrupt_saves_where_the_run_stands() {
    // Long enough to be interrupted, and without checkpoints during the run.
    let model = CRASH
        .replace("0.8e-3", "20e-3")
        .replace("checkpoint_steps = 40", "checkpoint_interval = 1000\nshown_elements = 100");
    let bench = Bench::of(&model);
    let child = bench.start(&["run", "crash.toml", "--output", "cut"]);
    let begun = || bench.path("cut/history.csv").exists() && bench.path("cut/frames/00001.vtu").exists();
    while !begun() {
        thread::sleep(Duration::from_millis(20));
    }
    // The same as `timeout`: to the process and to its group.
    let process = child.id().to_string();
    let sent = Command::new("kill").args(["-TERM", &process]).status().unwrap();
    thread::sleep(Duration::from_millis(20));
    let _ = Command::new("kill").args(["-TERM", &process]).stderr(Stdio::null()).status();
    assert!(sent.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(128 + 15));
    let json = bench.summary("cut");
    assert_eq!(json["status"], "interrupted");
    let steps = json["steps"].as_u64().unwrap();
    assert!(steps > 10, "{json}");
    assert!(bench.path("cut/report.html").exists());
    // The collections end with the last state, between two frames, until the run continues.
    let times = || -> Vec<f64> {
        let text = bench.read("cut/results.pvd");
        let times = text.split("timestep=\"").skip(1).map(|rest| rest.split('"').next().unwrap());
        times.map(|time| time.parse().unwrap()).collect()
    };
    bench.has_all_that_collections_name("cut");
    let (before, now) = (times(), json["time"].as_f64().unwrap());
    // The reader of JSON may miss the last bit of a number.
    let is_now = |time: &f64| (time - now).abs() < 1e-12 * now;
    assert!(is_now(before.last().unwrap()), "{before:?} {now}");
    assert_eq!(json["output"]["frames"], before.len());
    bench.run(&["resume", "-q", "cut", "--end-time", &(now * 1.01).to_string()]).succeeds();
    bench.has_all_that_collections_name("cut");
    let after = times();
    assert!(
        after.starts_with(&before[..before.len() - 1]) && !after.iter().any(is_now),
        "{before:?} {after:?}"
    );
    bench.write("cut/model.toml", model.replace("-20", "-21"));
    bench.run(&["resume", "cut"]).refused_with(&["has changed since this run"]);
}
