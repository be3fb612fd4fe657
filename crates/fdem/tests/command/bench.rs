//! `fdem bench`: its report. No test looks at a time beyond that it is one.

use serde_json::Value;

use crate::Bench;

/// The cells of the table on standard output, without its header and the lines below it.
fn table(stdout: &str) -> Vec<Vec<&str>> {
    let mut lines = stdout.lines();
    let header = lines.next().unwrap();
    for column in ["engine", "simd", "threads", "median ms", "ns/element", "bytes/element", "direct = 1"] {
        assert!(header.contains(column), "{column:?} is not in {header}");
    }
    lines
        .map(|line| line.split_whitespace().collect())
        .take_while(|cells: &Vec<_>| cells.len() == 10)
        .collect()
}

#[test]
fn every_engine_has_a_row_that_can_be_parsed() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "2000", "-o", "gas.csv"]).succeeds();
    let couples = bench.run(&["contacts", "gas.csv", "--count"]).succeeds().stdout;
    let run = bench.run(&["bench", "gas.csv", "--repeat", "2", "--json", "t.json"]).succeeds();
    let rows = table(&run.stdout);
    assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>(), ["rows", "nbs", "direct"]);
    for row in &rows {
        assert_eq!(row[2], "1");
        assert_eq!(row[7].replace(',', ""), couples.trim());
        for cell in [3, 4, 5, 6, 8, 9] {
            assert!(row[cell].parse::<f64>().unwrap() >= 0.0, "{row:?}");
        }
    }
    assert_eq!(rows[2][8..], ["0.0", "1.0"]);

    let json = bench.json("t.json");
    let json = json.as_array().unwrap();
    assert_eq!(json.len(), 3);
    for (row, engine) in json.iter().zip(["rows", "nbs", "direct"]) {
        assert_eq!(row["engine"], engine);
        assert_eq!(row["threads"], 1);
        assert_eq!(row["elements"], 2000);
        assert_eq!(row["couples"].to_string(), couples.trim());
        assert!(row["best_ms"].as_f64().unwrap() <= row["median_ms"].as_f64().unwrap());
        assert!(row.get("refused").is_none());
    }
    assert!(json[0]["simd"].is_string() && json[1]["simd"].is_null());
    // 3 N + n_z + 2 n_x + 2 n_y integers.
    assert!((12.0..16.0).contains(&json[1]["bytes_per_element"].as_f64().unwrap()), "{}", json[1]);
    assert_eq!(json[2]["bytes_per_element"], 0.0);
}

#[test]
fn engines_and_instructions_can_be_chosen() {
    let bench = Bench::new();
    bench.write("row.csv", "x,y\n0,0\n1.75,0\n4.25,0\n");
    let run = bench
        .run(&["bench", "row.csv", "--cutoff", "2", "--engines", "nbs,rows,nbs", "--simd", "portable"])
        .succeeds();
    let rows = table(&run.stdout);
    assert_eq!(
        rows.iter().map(|row| row[..2].to_vec()).collect::<Vec<_>>(),
        [["nbs", "-"], ["rows", "portable"]]
    );
    assert!(rows.iter().all(|row| row[7] == "1" && row[9] == "-"), "{}", run.stdout);
}

#[test]
fn rows_are_timed_with_each_number_of_threads() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "9000", "-o", "gas.csv"]).succeeds();
    let run = bench
        .run(&[
            "bench",
            "gas.csv",
            "--engines",
            "rows,nbs",
            "--threads",
            "1,2",
            "--repeat",
            "1",
            "--json",
            "t.json",
        ])
        .succeeds();
    let rows = table(&run.stdout);
    assert_eq!(
        rows.iter().map(|row| [row[0], row[2]]).collect::<Vec<_>>(),
        [["rows", "1"], ["rows", "2"], ["nbs", "1"]]
    );
    assert!(rows.iter().all(|row| row[7] == rows[0][7]), "{}", run.stdout);
    assert_eq!(bench.json("t.json")[1]["threads"], 2);
}

#[test]
fn levels_are_timed_where_sizes_are_unlike() {
    let bench = Bench::new();
    let sizes = ["--sizes", "power:0.5:50:-2.5"];
    bench.run(&[&["generate", "gas", "-n", "20000", "-o", "gas.csv"], &sizes[..]].concat()).succeeds();
    let run = bench.run(&["bench", "gas.csv", "--repeat", "1"]).succeeds();
    let rows = table(&run.stdout);
    assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>(), ["rows", "multilevel", "nbs", "direct"]);
    assert!(rows.iter().all(|row| row[7] == rows[0][7]), "{}", run.stdout);
    let run = bench.run(&["bench", "gas.csv", "--repeat", "1", "--engines", "cgrid,rows"]).succeeds();
    let others = table(&run.stdout);
    assert_eq!(others.iter().map(|row| row[0]).collect::<Vec<_>>(), ["cgrid", "rows"]);
    assert!(others.iter().all(|row| row[7] == rows[0][7]), "{}", run.stdout);
    let told = bench.run(&["contacts", "gas.csv", "--explain", "--engine", "cgrid"]).succeeds();
    assert!(told.stdout.starts_with("engine    cgrid: requested"), "{}", told.stdout);
    assert!(told.stdout.contains("\nlevel "), "{}", told.stdout);
    let [by_default, by_cells] = ["auto", "cgrid"]
        .map(|engine| bench.run(&["contacts", "gas.csv", "--engine", engine]).succeeds().stdout);
    assert!(by_default == by_cells);
    let told = bench.run(&["contacts", "gas.csv", "--explain", "--json", "t.json"]).succeeds();
    assert!(told.stdout.starts_with("engine    multilevel: sizes from "), "{}", told.stdout);
    let levels = bench.json("t.json")["levels"].as_array().unwrap().len();
    assert!(levels > 1 && told.stdout.lines().filter(|line| line.starts_with("level ")).count() == levels);
    let work = &bench.json("t.json")["work"];
    let work = work.as_array().unwrap();
    assert_eq!(work.len(), levels * (levels + 1) / 2);
    let sum = |key: &str| work.iter().map(|of| of[key].as_u64().unwrap()).sum::<u64>();
    assert_eq!(sum("couples").to_string(), rows[0][7].replace(',', ""));
    let predicted = work.iter().map(|of| of["predicted_candidates"].as_f64().unwrap()).sum::<f64>();
    let counted = sum("candidates") as f64;
    assert!((0.3 * counted..3.0 * counted).contains(&predicted), "{predicted} predicted, {counted} counted");
    assert!(told.stdout.contains("\n  2 in 1 ") && told.stdout.ends_with('\n'), "{}", told.stdout);
}

#[test]
fn an_engine_that_refuses_has_a_row_that_says_so_and_the_others_go_on() {
    let bench = Bench::new();
    bench.write("wide.csv", "id,x,y,z,r\n5,0,0,0,1\n6,1,0,0,1\n7,1e12,0,0,1\n");
    let run = bench.run(&["bench", "wide.csv", "--json", "t.json"]).succeeds();
    let rows = table(&run.stdout);
    assert_eq!(rows[1][..5], ["nbs", "-", "1", "refused", "-"]);
    assert!(rows[0][7] == "1" && rows[2][7] == "1", "{}", run.stdout);
    let why = run.stdout.lines().last().unwrap();
    assert!(why.starts_with("nbs refused: the domain is ") && why.contains("id 7"), "{why}");
    let json = bench.json("t.json");
    assert_eq!(json[1]["median_ms"], Value::Null);
    assert!(json[1]["refused"].as_str().unwrap().contains("id 7"));
}

#[test]
fn direct_is_left_out_of_large_packings_unless_asked_for() {
    let bench = Bench::new();
    bench.run(&["generate", "lattice", "-n", "50001", "--dims", "2", "-o", "large.npy"]).succeeds();
    let run = bench.run(&["bench", "large.npy", "--radius", "0.5", "--repeat", "1"]).succeeds();
    assert_eq!(table(&run.stdout).len(), 2);
    assert!(
        run.stderr.contains("direct is left out: comparing all pairs of 50,001 elements"),
        "{}",
        run.stderr
    );
}

#[test]
fn no_elements_take_no_time_per_element() {
    let bench = Bench::new();
    bench.write("none.csv", "x,y,radius\n");
    let run = bench.run(&["bench", "none.csv"]).succeeds();
    assert!(table(&run.stdout).iter().all(|row| row[5..9] == ["-", "-", "0", "-"]), "{}", run.stdout);
}

#[test]
fn bad_input_and_options_are_refused_as_elsewhere() {
    let bench = Bench::new();
    bench.write("row.csv", "x,y\n0,0\n1,0\n");
    bench.write("bad.csv", "x,y,r\n0,0,1\nabc,0,1\n");
    bench.run(&["bench", "row.csv"]).refused_with(&["row.csv: no column for radius", "--cutoff"]);
    bench.run(&["bench", "bad.csv"]).refused_with(&["bad.csv:3: cannot read 'abc'"]);
    bench.run(&["bench", "bad.csv", "--skip-bad-lines"]).succeeds();
    bench.run(&["bench", "nowhere.csv"]).refused_with(&["cannot read nowhere.csv"]);
    bench
        .run(&["bench", "row.csv", "--cutoff", "1", "--repeat", "0"])
        .refused_with(&["0 runs measure nothing"]);
    bench
        .run(&["bench", "row.csv", "--cutoff", "1", "--engines", "auto"])
        .refused_with(&["auto", "rows, multilevel, cgrid, nbs, direct"]);
    bench.run(&["bench", "row.csv", "--cutoff", "1", "--radius", "1"]).refused_with(&["--radius"]);
    bench.run(&["bench", "row.csv", "--cutoff", "1e300"]).refused_with(&["row.csv: cut-off 1e300"]);
    bench
        .run(&["bench", "row.csv", "--cutoff", "1", "--json", "row.csv"])
        .refused_with(&["--json row.csv is the same file as the input"]);
    let foreign = if cfg!(target_arch = "aarch64") { "avx2" } else { "neon" };
    bench.run(&["bench", "row.csv", "--cutoff", "1", "--simd", foreign]).refused_with(&["--simd", foreign]);
    bench
        .run(&["bench", "row.csv", "--cutoff", "1", "--threads", "-1"])
        .refused_with(&["'-1' is not a whole number"]);
    assert_eq!(bench.files(), ["bad.csv", "row.csv"]);
}
