//! Files, options and outputs that are refused: exit code 2, a message with the problem and its place, no
//! files left behind.

use crate::Bench;

const GOOD: &str = "x,y,radius\n0,0,1\n1,0,1\n";

/// Runs on `content` with outputs that must not appear.
#[track_caller]
fn refused(content: &[u8], options: &[&str], parts: &[&str]) {
    let bench = Bench::new();
    bench.write("in.txt", content);
    bench
        .run(&[&["contacts", "in.txt", "-o", "out.csv", "--json", "out.json"], options].concat())
        .refused_with(parts);
    assert_eq!(bench.files(), ["in.txt"]);
}

#[test]
fn a_malformed_line_is_named_with_its_text() {
    refused(b"x,y,radius\n0,0,1\n5 0.01 0 0\n", &[], &["in.txt:3:", "5 0.01 0 0"]);
    refused(b"x y radius\n0 0 1\n1 abc 1\n", &[], &["in.txt:3:", "'abc'", "column y"]);
    refused(b"x y radius\n0 0 1\n1 0\n", &[], &["in.txt:3:", "expected 3 fields, found 2"]);
    refused(b"x y radius\n0 0 1\n\n# fine\n1 nan 1\n", &[], &["in.txt:5:", "nan"]);
    refused(b"x y radius\n0 0 1\n1 1e999 1\n", &[], &["in.txt:3:", "1e999"]);
    refused(b"x y radius\n0 0 1\n1 0 -1\n", &[], &["in.txt:3:", "-1"]);
    refused(b"id x y radius\n1 0 0 1\n1.5 0 0 1\n", &[], &["in.txt:3:", "1.5"]);
}

#[test]
fn a_decimal_comma_gets_its_hint() {
    refused(b"x;y;radius\n0,5;0;1\n", &[], &["in.txt:2:", "decimal comma"]);
    refused(b"x y radius\n0,5 0 1\n", &[], &["in.txt:2:", "decimal comma"]);
}

#[test]
fn what_is_no_table_is_refused() {
    refused(b"", &[], &["in.txt", "empty"]);
    refused(b"# nothing\n\n", &[], &["in.txt", "comments"]);
    refused(b"\x7fELF\x02\x01\x01\x00\x00\x00\x00rubbish\x00\xff\xfe", &[], &["in.txt", "not a text file"]);
    refused(b"\x1f\x8b\x08\x00rubbish", &[], &["in.txt", "gzip"]);
    refused(b"\x93NUMPY\x01\x00", &[], &["in.txt", "NumPy"]);
    refused(b"x,y,radius\nfoo,bar,baz\n", &["--skip-bad-lines"], &["in.txt", "none of the"]);
}

#[test]
fn a_column_that_is_not_there_lists_those_that_are() {
    refused(b"a,b,c\n0,0,1\n", &[], &["in.txt:1:", "no column for x", "a, b, c"]);
    refused(
        GOOD.as_bytes(),
        &["--columns", "x=x,y=y,radius=size"],
        &["in.txt", "no column 'size'", "x, y, radius"],
    );
    refused(GOOD.as_bytes(), &["--columns", "x,y"], &["in.txt", "--columns lists 2", "3"]);
    refused(b"1 2 3 4 5\n", &[], &["in.txt", "--columns"]);
    refused(b"x [mm],y [mm],radius [m]\n0,0,1\n", &[], &["in.txt:1:", "mm", "convert"]);
    refused(b"id,x,y,r\n4,0,0,1\n5,1,0,1\n4,2,0,1\n", &[], &["in.txt:4:", "id 4", "line 2", "--ignore-ids"]);
}

#[test]
fn a_domain_too_wide_for_the_engine_names_the_element_and_what_instead() {
    let row = (0..50).map(|k| format!("{},{k},0,0.5\n", 100 + k));
    let text = format!("id,x,y,radius\n{}777,0,1e12,0.5\n", row.collect::<String>());
    refused(text.as_bytes(), &["--engine", "nbs"], &["id 777 at y = 1e12", "--engine rows"]);
    let bench = Bench::new();
    bench.write("in.txt", &text);
    let run = bench.run(&["contacts", "in.txt"]).succeeds();
    assert_eq!(run.rows().len(), 49);
    assert!(run.stderr.contains("rows: linear"), "{}", run.stderr);
    refused(b"x,y,radius\n0,0,1\n1e200,0,1\n", &[], &["in.txt", "element 1", "overflow", "data row 1"]);
    refused(b"id,x,y,radius\n100,0,0,1\n200,1e200,0,1\n", &[], &["in.txt", "overflow", "id 200"]);
}

#[test]
fn options_that_make_no_sense_are_refused() {
    let options: [(&[&str], &str); 13] = [
        (&["--radius", "-1"], "negative"),
        (&["--radius", "nan"], "not a finite number"),
        (&["--radius", "0,5"], "decimal comma"),
        (&["--tolerance", "inf"], "not a finite number"),
        (&["--engine", "rowz"], "possible values"),
        (&["--radius", "1", "--cutoff", "1"], "cannot be used with"),
        (&["--verify", "-3"], "'-3' is not a whole number"),
        (&["--verify", "0"], "checks nothing"),
        (&["--picture", "p.jpg"], ".svg or .png"),
        (&["--plots", "p"], ".svg or .png"),
        (&["--report", "p.pdf"], ".html"),
        (&["--columns", "x,x"], "--columns"),
        (&["--count"], "cannot be used with"),
    ];
    for (option, part) in options {
        refused(GOOD.as_bytes(), option, &[part]);
    }
}

#[test]
fn an_input_that_cannot_be_opened_is_named() {
    let bench = Bench::new();
    bench.run(&["contacts", "nowhere.csv", "-o", "out.csv"]).refused_with(&["nowhere.csv"]);
    bench.run(&["contacts", ".", "-o", "out.csv"]).refused_with(&["it is a directory"]);
    bench.run(&["contacts"]).refused_with(&["<FILE>"]);
    assert!(bench.files().is_empty());
}

#[test]
fn an_output_that_cannot_be_written_is_named() {
    let bench = Bench::new();
    bench.write("in.csv", GOOD);
    let refused = |options: &[&str], parts: &[&str]| {
        bench.run(&[&["contacts", "in.csv"], options].concat()).refused_with(parts);
        assert_eq!(bench.files(), ["in.csv"]);
    };
    refused(&["-o", "nowhere/out.csv"], &["nowhere/out.csv", "no folder"]);
    refused(
        &["-o", "out.xlsx"],
        &[
            "out.xlsx",
            "its extension must be that of a format: .csv, .npy, .npz, .parquet, .vtp, .graphml or .json",
        ],
    );
    refused(&["-o", "new\nline.txt"], &["new\\nline.txt"]);
    refused(&["-o", "."], &["directory"]);
    refused(&["-o", "in.csv"], &["--output in.csv is the same file as the input"]);
    refused(&["-o", "./in.csv"], &["is the same file as the input"]);
    refused(&["-o", "a.csv", "--json", "a.csv"], &["--json a.csv is the same file as --output"]);
    // Neither exists yet: the names are compared as places.
    refused(&["-o", "a.csv", "--json", "./a.csv"], &["--json ./a.csv is the same file as --output"]);
    let absolute = bench.path("a.svg");
    refused(&["--json", "a.svg", "--picture", absolute.to_str().unwrap()], &["is the same file as --json"]);
    refused(&["-o", "a.csv", "--json", "nowhere/a.json"], &["nowhere/a.json"]);
    assert_eq!(bench.read("in.csv"), GOOD);
}

/// A link to a file that does not exist yet leads there; links in a circle lead nowhere.
#[cfg(unix)]
#[test]
fn links_are_followed_or_refused() {
    use std::os::unix::fs::symlink;
    let bench = Bench::new();
    bench.write("in.csv", GOOD);
    symlink("a.csv", bench.path("b.csv")).unwrap();
    symlink("b.csv", bench.path("a.csv")).unwrap();
    bench.run(&["contacts", "in.csv", "-o", "a.csv"]).refused_with(&["a.csv", "loop"]);
    symlink("real.csv", bench.path("link.csv")).unwrap();
    bench.run(&["contacts", "in.csv", "-o", "link.csv"]).succeeds();
    assert!(bench.path("link.csv").is_symlink());
    assert_eq!(bench.read("real.csv").lines().count(), 2);
}

/// An endless input is not read to its end.
#[cfg(target_os = "linux")]
#[test]
fn an_endless_input_is_no_packing() {
    Bench::new().run(&["contacts", "/dev/zero"]).refused_with(&["/dev/zero:1:", "not a text file"]);
}

/// More couples than memory: an error with a remedy, not an abort.
#[cfg(target_os = "linux")]
#[test]
fn too_many_couples_for_the_memory() {
    let bench = Bench::new();
    bench.write("heap.csv", format!("x,y,radius\n{}", "1,1,1\n".repeat(8_000)));
    for engine in ["rows", "nbs"] {
        let fdem = assert_cmd::cargo::cargo_bin!("fdem").display().to_string();
        let line = format!("ulimit -v 200000 && exec {fdem} contacts heap.csv --engine {engine} -o out.csv");
        let output =
            std::process::Command::new("sh").args(["-c", &line]).current_dir(bench.folder.path()).output();
        let run = crate::Run::of(output.unwrap(), &["under ulimit"]);
        run.refused_with(&["heap.csv", "no memory", "--count"]);
        assert_eq!(bench.files(), ["heap.csv"]);
    }
    let run = bench.run(&["contacts", "heap.csv", "--count"]).succeeds();
    assert_eq!(run.stdout, "31996000\n");
}

/// Wherever memory ends, in reading, sorting or searching: an answer or an error.
#[cfg(target_os = "linux")]
#[test]
fn any_limit_of_memory_ends_in_an_answer_or_an_error() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "60000", "--neighbours", "12", "-o", "gas.npy"]).succeeds();
    let fdem = assert_cmd::cargo::cargo_bin!("fdem").display().to_string();
    let mut ends = [0, 0];
    let least = crate::least_memory();
    for kilobytes in (least..least + 48_000).step_by(500) {
        let line = format!("ulimit -v {kilobytes} && RUST_BACKTRACE=0 exec {fdem} contacts gas.npy --count");
        let run =
            std::process::Command::new("sh").args(["-c", &line]).current_dir(bench.folder.path()).output();
        let run = run.unwrap();
        let message = String::from_utf8_lossy(&run.stderr).into_owned();
        match run.status.code() {
            Some(0) => ends[0] += 1,
            Some(2) => {
                assert!(message.contains("memory"), "{kilobytes}: {message}");
                ends[1] += 1;
            }
            code => panic!("{kilobytes} kB: {code:?}, {message}"),
        }
    }
    assert!(ends[0] > 0 && ends[1] > 0, "answers and errors: {ends:?}");
}

/// More couples than 32 bits count, in less memory than they need. One radius for all, and little memory: no
/// other scene of this size is quicker.
#[cfg(target_os = "linux")]
#[test]
fn more_than_2_to_the_32_couples_for_the_memory() {
    let bench = Bench::new();
    bench.write("heap.csv", format!("x,y,radius\n{}", "1,1,1\n".repeat(92_683)));
    let fdem = assert_cmd::cargo::cargo_bin!("fdem").display().to_string();
    let line = format!("ulimit -v 200000 && exec {fdem} contacts heap.csv --radius 1 -o out.csv");
    let output =
        std::process::Command::new("sh").args(["-c", &line]).current_dir(bench.folder.path()).output();
    crate::Run::of(output.unwrap(), &["under ulimit"]).refused_with(&["heap.csv", "no memory", "--count"]);
    assert_eq!(bench.files(), ["heap.csv"]);
}

/// A small file with much content is refused before memory is taken for it.
#[test]
fn compressed_content_beyond_the_memory() {
    let bench = Bench::new();
    let rows = format!("x,y,r\n{}", "1,1,1\n".repeat(1 << 19));
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    std::io::Write::write_all(&mut packed, rows.as_bytes()).unwrap();
    bench.write("in.csv.gz", packed.finish().unwrap());
    let run = bench.run(&["contacts", "in.csv.gz", "--max-memory", "5MB", "--count"]);
    run.refused_with(&[
        "in.csv.gz: the content of this gzip file has 4 MB",
        "and 5 MB are allowed: --max-memory",
    ]);
    bench
        .run(&["contacts", "in.csv.gz", "--max-memory", "5", "--count"])
        .refused_with(&["5 bytes are allowed"]);
    assert_eq!(bench.files(), ["in.csv.gz"]);
}

/// A plain file is refused by its size and the length of its rows, before it is read.
#[test]
fn a_file_beyond_the_memory_is_refused_before_it_is_read() {
    let bench = Bench::new();
    let rows = "1,1,1\n".repeat(1 << 19);
    bench.write("in.csv", &rows);
    let run = bench.run(&["contacts", "in.csv", "--radius", "1", "--max-memory", "20MB", "--count"]);
    run.refused_with(&[
        "in.csv: this file has 4 MB; with its elements it may take 29 MB of memory, and 20 MB are allowed: --max-memory",
    ]);
    let run = bench
        .run_with(&["contacts", "-", "--radius", "1", "--max-memory", "20MB", "--count"], rows.as_bytes());
    run.refused_with(&["standard input: this file has ", " MB or more; with its elements it may take "]);
    bench.write("two.xyz", "2\n\nH 0 0 0\nH 1 0 0\n".repeat(50_000));
    let first = ["contacts", "two.xyz", "--cutoff", "1", "--frames", "0"];
    let run = bench.run(&[&first[..], &["--max-memory", "2MB", "--count"]].concat());
    // A file of frames takes its bytes and one frame.
    assert_eq!(run.succeeds().stdout.trim(), "1");
    assert_eq!(bench.files(), ["in.csv", "two.xyz"]);
}

/// Coordinates whose extent is no number any more.
#[test]
fn a_domain_that_is_too_wide_to_draw() {
    let bench = Bench::new();
    bench.write("wide.csv", "x,y,r\n-1.7e308,0,1\n1.7e308,0,1\n");
    let run = bench.run(&["contacts", "wide.csv", "--picture", "p.png"]);
    run.refused_with(&["wide.csv"]);
    assert_eq!(bench.files(), ["wide.csv"]);
}

/// A full disk, on systems that have one to offer.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let bench = Bench::new();
    bench.write("in.csv", GOOD);
    let run = bench.run(&["contacts", "in.csv", "-o", "/dev/full", "--json", "s.json"]);
    run.refused_with(&["cannot write /dev/full", "No space left"]);
    assert_eq!(bench.files(), ["in.csv"]);

    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let output = bench.command(&["contacts", "in.csv", "--json", "s.json"]).stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(bench.files(), ["in.csv"]);
}

/// Standard output that was closed (`>&-`): the couples were lost without a message.
#[cfg(unix)]
#[test]
fn a_closed_standard_output_is_an_error() {
    let bench = Bench::new();
    bench.write("in.csv", GOOD);
    let fdem = assert_cmd::cargo::cargo_bin!("fdem").display().to_string();
    let run = |line: &str| {
        let line = format!("{fdem} {line} >&-");
        let output =
            std::process::Command::new("sh").args(["-c", &line]).current_dir(bench.folder.path()).output();
        crate::Run::of(output.unwrap(), &[&line])
    };
    for line in ["contacts in.csv", "contacts in.csv --count", "generate lattice", "--help", "--version"] {
        run(line).refused_with(&["cannot write standard output: it is closed"]);
    }
    run("contacts in.csv -q -o out.csv").succeeds();
    run("contacts in.csv -q --picture out.svg").succeeds();
    assert_eq!(bench.files(), ["in.csv", "out.csv", "out.svg"]);
}

/// Without MPI, every process of a launcher would do the whole work and write the same file.
#[cfg(not(feature = "mpi"))]
#[test]
fn a_launcher_of_mpi_is_noticed_without_mpi() {
    let bench = Bench::new();
    bench.write("in.csv", GOOD);
    let mut command = bench.command(&["contacts", "in.csv", "-o", "out.csv"]);
    let output = command.env("OMPI_COMM_WORLD_SIZE", "4").output().unwrap();
    let run = crate::Run::of(output, &["contacts", "under mpirun"]);
    run.refused_with(&["an MPI launcher has started 4 processes", "built without MPI", "--features mpi"]);
    assert_eq!(bench.files(), ["in.csv"]);

    let alone =
        bench.command(&["contacts", "in.csv", "-o", "out.csv"]).env("OMPI_COMM_WORLD_SIZE", "1").output();
    crate::Run::of(alone.unwrap(), &["contacts", "alone"]).succeeds();
    assert_eq!(bench.files(), ["in.csv", "out.csv"]);
}

/// Help that cannot be printed was a success.
#[cfg(target_os = "linux")]
#[test]
fn help_on_a_full_disk_is_an_error() {
    let bench = Bench::new();
    for arguments in [&["--help"][..], &["contacts", "--help"], &["--version"]] {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let output = bench.command(arguments).stdout(full).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.starts_with("error: cannot write standard output: "), "{message}");
    }
    assert_eq!(bench.run(&["--version"]).code, Some(0));
    assert_eq!(bench.run(&["--nothing"]).code, Some(2));
}

/// Partial files of a killed command are removed by the next one; files of a command that still runs are not.
#[cfg(unix)]
#[test]
fn the_next_command_removes_what_a_killed_one_left() {
    use std::io::Write;
    use std::process::Stdio;
    let bench = Bench::new();
    bench.write("in.csv", GOOD);
    let waiting = |output: &str| {
        let before = bench.files().len();
        let mut command = bench.command(&["contacts", "-", "-o", output]);
        let mut child = command.stdin(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        child.stdin.as_mut().unwrap().write_all(GOOD.as_bytes()).unwrap();
        let started = std::time::Instant::now();
        // Its lock and its partial file.
        while bench.files().len() < before + 2 {
            assert!(started.elapsed().as_secs() < 60, "the output was never opened");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        child
    };
    let mut killed = waiting("a.csv");
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert_eq!(bench.files().len(), 3, "{:?}", bench.files());
    bench.run(&["contacts", "in.csv", "-o", "b.csv"]).succeeds();
    assert_eq!(bench.files(), ["b.csv", "in.csv"]);

    let mut alive = waiting("a.csv");
    bench.run(&["contacts", "in.csv", "-o", "c.csv"]).succeeds();
    assert_eq!(bench.files().len(), 5, "{:?}", bench.files());
    drop(alive.stdin.take());
    assert!(alive.wait().unwrap().success());
    assert_eq!(bench.files(), ["a.csv", "b.csv", "c.csv", "in.csv"]);
}

/// An interrupt while the couples are written removes the partial files.
#[cfg(unix)]
#[test]
fn an_interrupt_leaves_nothing_behind() {
    for (signal, code) in [("-INT", 130), ("-TERM", 143), ("-HUP", 129), ("-QUIT", 131)] {
        interrupted_by(signal, code);
    }
}

#[cfg(unix)]
fn interrupted_by(signal: &str, code: i32) {
    use std::io::Write;
    use std::process::Stdio;
    let bench = Bench::new();
    // The program has opened its output, and waits for an input that never ends.
    let mut command = bench.command(&["contacts", "-", "-o", "out.csv"]);
    let mut child = command.stdin(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(GOOD.as_bytes()).unwrap();
    let started = std::time::Instant::now();
    while bench.files().is_empty() {
        assert!(started.elapsed().as_secs() < 60, "the output was never opened");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let kill = std::process::Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    assert_eq!(child.wait().unwrap().code(), Some(code));
    assert!(bench.files().is_empty(), "{:?}", bench.files());
}
