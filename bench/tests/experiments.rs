//! Each experiment once, at a small size: nothing is timed.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::process::Command;

/// Runs a program of this crate, which checks its own results.
fn quick(program: &str) {
    let output = Command::new(program).arg("--quick").output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&text));
}

#[test]
fn fluid() {
    quick(env!("CARGO_BIN_EXE_fluid"));
}

#[test]
fn paper() {
    quick(env!("CARGO_BIN_EXE_paper"));
}

#[test]
fn simulation() {
    quick(env!("CARGO_BIN_EXE_simulation"));
}

#[test]
fn scaling() {
    quick(env!("CARGO_BIN_EXE_scaling"));
}
