//! Results of a run that were damaged or taken away.

use std::fs;

use super::CRASH;
use crate::Bench;

/// A file with other contents, or `None` for no file.
type Damage<'a> = &'a dyn Fn(&[u8]) -> Option<Vec<u8>>;

/// A damaged result is named before the run continues, and nothing is changed.
#[test]
fn damaged_results_of_a_run_are_found_before_it_goes_on() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "0.05e-3"));
    bench.run(&["run", "crash.toml", "-q", "-o", "run"]).succeeds();
    let cut = |whole: &[u8]| Some(whole[..whole.len() / 2].to_vec());
    let flipped = |whole: &[u8]| {
        let mut bytes = whole.to_vec();
        *bytes.last_mut().unwrap() ^= 1;
        Some(bytes)
    };
    // Another digit in the second row.
    let miswritten = |whole: &[u8]| {
        let mut bytes = whole.to_vec();
        let line = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n').nth(1).unwrap().0;
        let digit = line + 1 + bytes[line + 1..].iter().position(|byte| *byte == b',').unwrap() + 1;
        bytes[digit] = if bytes[digit] == b'9' { b'8' } else { b'9' };
        Some(bytes)
    };
    let cases: [(&str, Damage<'_>, &str); 6] = [
        ("history.csv", &miswritten, "rows until the checkpoint have changed"),
        ("history.csv", &cut, "bytes are left"),
        ("history.csv", &|_| None, "it is missing"),
        ("frames/00001.frame", &flipped, "its contents have changed"),
        ("frames/00002.vtu", &cut, "and the run wrote"),
        ("frames/00003_cracks.vtp", &|_| None, "it is missing"),
    ];
    for (name, damage, says) in cases {
        let file = bench.path("run").join(name);
        let whole = fs::read(&file).unwrap();
        match damage(&whole) {
            Some(damaged) => fs::write(&file, damaged).unwrap(),
            None => fs::remove_file(&file).unwrap(),
        }
        let before = bench.read("run/model.toml");
        for arguments in [&["resume", "-q", "run"][..], &["resume", "-q", "run", "--end-time", "0.06e-3"]] {
            bench.run(arguments).refused_with(&[name, says, "`fdem run run/model.toml --from run"]);
        }
        assert_eq!(bench.read("run/model.toml"), before);
        fs::write(&file, whole).unwrap();
    }
    bench.run(&["resume", "-q", "run", "--end-time", "0.06e-3"]).succeeds();
}

/// The frame of the checkpoint and the tables at the end are made again, to the last bit.
#[test]
fn damaged_results_of_the_checkpoint_are_made_again() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "0.05e-3"));
    bench.run(&["run", "crash.toml", "-q", "-o", "run"]).succeeds();
    let last = bench.summary("run")["output"]["frames"].as_u64().unwrap() - 1;
    let frame = format!("run/frames/{last:05}");
    let files = [format!("{frame}.frame"), format!("{frame}_cracks.vtp"), "run/fragments.csv".to_owned()];
    let whole = files.each_ref().map(|name| fs::read(bench.path(name)).unwrap());
    for (name, bytes) in files.iter().zip(&whole) {
        bench.write(name, &bytes[..bytes.len() / 2]);
    }
    let told = bench.run(&["resume", "run"]).succeeds();
    for (name, bytes) in files.iter().zip(&whole) {
        assert!(
            told.stderr.contains(&format!("warning: {name} is not as the checkpoint")),
            "{}",
            told.stderr
        );
        assert!(fs::read(bench.path(name)).unwrap() == *bytes, "{name} differs");
    }
    let again = bench.run(&["resume", "run"]).succeeds();
    assert!(again.stdout.contains("nothing to do"), "{}", again.stdout);
}

/// After a power cut the disk may have a later frame without those before it.
#[test]
fn later_frames_are_removed_also_if_some_are_missing() {
    let bench = Bench::of(&CRASH.replace("0.8e-3", "0.05e-3"));
    bench.run(&["run", "crash.toml", "-q", "-o", "run"]).succeeds();
    let files = [
        "00037.vtu",
        "00040_cracks.vtp",
        "00040_damaged_joints.vtp",
        "00041_contacts.vtp",
        "123456.frame",
        "00050_mine.vtp",
    ];
    for file in files {
        bench.write(&format!("run/frames/{file}"), "cut off");
    }
    bench.run(&["resume", "-q", "run", "--end-time", "0.06e-3"]).succeeds();
    let left = files.map(|file| bench.path("run/frames").join(file).exists());
    assert_eq!(left, [false, false, false, false, false, true], "only files of frames are removed");
    bench.has_all_that_collections_name("run");
    assert!(!bench.read("run/results.pvd").contains("00037.vtu"));
}
