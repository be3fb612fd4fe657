//! Elements that are parts of bodies: `--bodies`.

use crate::Bench;

/// Four discs in a row, each touching the next: a body of the first two, the others on their own.
const CHAIN: &str = "x,y,radius,clump\n0,0,0.5,7\n1,0,0.5,7\n2,0,0.5,-3\n3,0,0.5,9000000000\n";

#[test]
fn parts_of_one_body_form_no_couple() {
    let bench = Bench::new();
    bench.write("chain.csv", CHAIN);
    bench.write("plain.txt", "0 0 0.5 7\n1 0 0.5 7\n2 0 0.5 -3\n3 0 0.5 9000000000\n");
    assert_eq!(bench.run(&["contacts", "chain.csv"]).succeeds().rows().len(), 3);
    let of_two_bodies = ["1,2,1.0,0.0", "2,3,1.0,0.0"];
    for (file, column) in [("chain.csv", "clump"), ("chain.csv", "4"), ("plain.txt", "4")] {
        let mut options = vec!["contacts", file, "--bodies", column];
        if file == "plain.txt" {
            // Without it the three columns before would be x y z.
            options.extend(["--columns", "x,y,radius,_"]);
        }
        for more in [&["--engine", "nbs"][..], &["--engine", "rows", "--threads", "2"], &["--verify", "4"]] {
            let run = bench.run(&[&options[..], more, &["--json", "s.json"]].concat()).succeeds();
            assert_eq!(run.rows(), of_two_bodies, "{file} {column}");
            assert!(run.stderr.contains("bodies           3, without"), "{}", run.stderr);
            assert_eq!(bench.json("s.json")["bodies"], 3);
        }
    }
    let run = bench.run(&["contacts", "chain.csv", "--count", "--bodies", "clump"]).succeeds();
    assert_eq!(run.stdout, "2\n");
    bench.run(&["contacts", "chain.csv", "--json", "s.json", "-q"]).succeeds();
    assert!(bench.json("s.json").get("bodies").is_none(), "nobody asked for bodies");
    let run = bench
        .run(&["contacts", "chain.csv", "--bodies", "clump", "--explain", "--json", "e.json"])
        .succeeds();
    assert!(run.stdout.contains("couples   2\n"), "{}", run.stdout);
    assert_eq!(bench.json("e.json")["bodies"], 3);
}

/// Without a header, the column of bodies is not among the counted columns.
#[test]
fn without_a_header_the_other_columns_are_counted() {
    let bench = Bench::new();
    bench.write("five.txt", "0 0 0 0.5 1\n1 0 0 0.5 1\n2 0 0 0.5 2\n");
    assert_eq!(bench.run(&["contacts", "five.txt", "--bodies", "5"]).succeeds().rows(), ["1,2,1.0,0.0"]);
    bench.write("first.txt", "1 0 0 0 0.5\n1 1 0 0 0.5\n2 2 0 0 0.5\n");
    assert_eq!(bench.run(&["contacts", "first.txt", "--bodies", "1"]).succeeds().rows(), ["1,2,1.0,0.0"]);
    // As an array of floats.
    let mut npy = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    npy.extend(format!("{:117}\n", "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 5), }").bytes());
    for number in bench.read("five.txt").split_whitespace() {
        npy.extend(number.parse::<f64>().unwrap().to_le_bytes());
    }
    bench.write("five.npy", &npy);
    assert_eq!(bench.run(&["contacts", "five.npy", "--bodies", "5"]).succeeds().rows(), ["1,2,1.0,0.0"]);
    let last = npy.len() - 8;
    npy[last..].copy_from_slice(&2.5_f64.to_le_bytes());
    bench.write("five.npy", &npy);
    bench.run(&["contacts", "five.npy", "--bodies", "5"]).refused_with(&[
        "five.npy: row 2 (counted from 0)",
        "the body in column 5 is 2.5, not a whole number",
    ]);
}

/// An element and its image are of one body, and so are two parts that touch across a face.
#[test]
fn images_are_of_the_body_of_their_element() {
    let bench = Bench::new();
    bench.write("ends.csv", "x,y,radius,body\n0.25,2,0.5,1\n3.5,2,0.5,1\n0.25,3,0.5,2\n");
    let options = ["contacts", "ends.csv", "--box", "0,4,0,4", "--periodic", "x", "--verify", "3"];
    assert_eq!(bench.run(&options).succeeds().stdout.lines().count(), 1 + 2);
    let run = bench.run(&[&options[..], &["--bodies", "body"]].concat()).succeeds();
    assert_eq!(run.stdout.lines().skip(1).collect::<Vec<_>>(), ["0,2,1.0,0.0,0,0"]);
    let small = ["contacts", "ends.csv", "--box", "0,1,0,4", "--periodic", "x", "--verify", "3"];
    let all = bench.run(&small).succeeds();
    assert!(all.stdout.contains("\n0,0,1.0,0.0,1,0\n"), "{}", all.stdout);
    let run = bench.run(&[&small[..], &["--bodies", "body"]].concat()).succeeds();
    let same = |row: &str| row.starts_with("0,0,") || row.starts_with("1,1,") || row.starts_with("0,1,");
    let kept: Vec<_> =
        all.stdout.lines().skip(1).filter(|row| !same(row) && !row.starts_with("2,2,")).collect();
    assert_eq!(run.stdout.lines().skip(1).collect::<Vec<_>>(), kept);
    assert!(!kept.is_empty());
}

/// The result equals filtering the file afterwards, at any number of threads.
#[test]
fn bodies_of_a_gas() {
    let bench = Bench::new();
    bench.run(&["generate", "gas", "-n", "3000", "--neighbours", "12", "-o", "gas.csv"]).succeeds();
    let text = bench.read("gas.csv");
    let bodies = text.lines().enumerate().map(|(line, row)| match line {
        0 => format!("{row},part\n"),
        _ => format!("{row},{}\n", line * line % 7),
    });
    bench.write("parts.csv", bodies.collect::<String>());
    let all = bench.run(&["contacts", "gas.csv"]).succeeds();
    let body = |id: &str| (id.parse::<usize>().unwrap() + 1).pow(2) % 7;
    let expected: Vec<_> = all
        .rows()
        .into_iter()
        .filter(|row| {
            let ids: Vec<_> = row.split(',').take(2).collect();
            body(ids[0]) != body(ids[1])
        })
        .collect();
    for more in [["--threads", "1"], ["--threads", "3"], ["--engine", "direct"], ["--verify", "100"]] {
        let run = bench.run(&[&["contacts", "parts.csv", "--bodies", "part"][..], &more].concat()).succeeds();
        assert!(run.rows() == expected, "{more:?}");
        assert!(run.stderr.contains("bodies           4, "), "{}", run.stderr);
    }
}

#[test]
fn columns_that_hold_no_bodies_are_refused() {
    let bench = Bench::new();
    bench.write("in.csv", "id,x,y,r,body\n0,0,0,1,1\n1,1,0,1,1.5\n2,1,0,1,99999999999999999999\n3,1,0,1,\n");
    let refused = |column: &str, parts: &[&str]| {
        bench.run(&["contacts", "in.csv", "--bodies", column, "-o", "out.csv"]).refused_with(parts);
    };
    refused("body", &["in.csv:3: the body '1.5' in column body is not a whole number: 1,1,0,1,1.5"]);
    refused("5", &["in.csv:3: the body '1.5' in column body"]);
    refused("clump", &["in.csv:1: no column 'clump'; the columns are: id, x, y, r, body"]);
    refused("6", &["no column '6'"]);
    refused("0", &["no column '0'"]);
    refused("x", &["in.csv:1: --bodies x: this column is the x of the elements"]);
    refused("id", &["--bodies id", "--ignore-ids"]);
    let run = bench
        .run(&["contacts", "in.csv", "--bodies", "body", "--skip-bad-lines", "--json", "s.json"])
        .succeeds();
    for part in [
        "skipped 3 bad lines",
        "the body 99999999999999999999 in column body does not fit",
        "the body '' in column body is not",
    ] {
        assert!(run.stderr.contains(part), "{part:?} is not in\n{}", run.stderr);
    }
    assert_eq!(bench.json("s.json")["bodies"], 1);
    // A column that cannot be ids may be bodies.
    bench.write("named.csv", "id,x,y,r\n4,0,0,1\n4,1,0,1\n5,2,0,1\n");
    let run = bench.run(&["contacts", "named.csv", "--bodies", "id", "--ignore-ids"]).succeeds();
    assert_eq!(run.rows(), ["0,2,2.0,0.0", "1,2,1.0,1.0"]);
    bench.write("headless.txt", "0 0 1 1\n1 0 1 x\n");
    bench
        .run(&["contacts", "headless.txt", "--bodies", "4", "--radius", "1"])
        .refused_with(&["headless.txt:2: the body 'x' in column 4 is not a whole number"]);
}
