//! Couples, and values such as forces, from a file in place of a search.

use crate::Bench;

const BOX: &str = "ITEM: BOX BOUNDS pp pp pp\n0 10\n0 10\n0 10\n";

fn atoms(step: u32) -> String {
    format!(
        "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n3\n{BOX}ITEM: ATOMS id x y z radius\n3 9.5 1 5 1\n1 1 1 5 1\n\
         2 1 2.5 5 1\n"
    )
}

fn local(step: u32, columns: &str, rows: &[&str]) -> String {
    let count = rows.len();
    let rows = rows.join("\n");
    format!(
        "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ENTRIES\n{count}\n{BOX}ITEM: ENTRIES {columns}\n{rows}\n"
    )
}

const PLAIN: &str = "index c_id[1] c_id[2] c_f[1] c_f[2] c_f[3]";
const ROWS: [&str; 2] = ["1 1 2 1.5 -2 0", "2 1 3 8 0 0"];
const NAMES: [&str; 5] = ["atoms.dump", "--couples", "pairs.dump", "--couple-columns", "_,i,j,fx,fy,fz"];

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("atoms.dump", atoms(7));
    bench.write("pairs.dump", local(7, PLAIN, &ROWS));
    bench
}

/// The second row is turned, because the atom 3 comes first in the packing: its force is that on 3. The
/// couple of 3 and 1 leads through a face.
#[test]
fn couples_of_a_dump_local_have_their_forces() {
    let bench = bench();
    let run = bench.run(&[&["contacts"][..], &NAMES].concat()).succeeds();
    let rows: Vec<_> = run.stdout.lines().collect();
    assert_eq!(
        rows,
        [
            "i,j,distance,overlap,fx,fy,fz,sx,sy,sz",
            "3,1,1.5,0.5,-8.0,0.0,0.0,1,0,0",
            "1,2,1.5,0.5,1.5,-2.0,0.0,0,0,0"
        ]
    );
    assert!(
        run.stderr.contains("engine           none: the couples are those of pairs.dump"),
        "{}",
        run.stderr
    );
    for format in ["npy", "npz", "parquet", "vtp", "graphml", "json"] {
        let output = format!("out.{format}");
        bench.run(&[&["contacts"][..], &NAMES, &["-o", &output]].concat()).succeeds();
        let bytes = std::fs::read(bench.path(&output)).unwrap();
        let holds = |part: &[u8]| bytes.windows(part.len()).any(|window| window == part);
        assert!(holds(b"fx") && holds(b"fz"), "{format}");
    }
    // The last array of records: the force of the first couple.
    let records = std::fs::read(bench.path("out.npy")).unwrap();
    assert!(records.windows(8).any(|bytes| bytes == (-8.0_f64).to_le_bytes()));
}

/// By hand: Σ f l is -12 for xx, and 2.25 and -3 for xy and yy of the other couple, in a volume of 1,000.
#[test]
fn the_stress_of_a_dump_local_is_that_by_hand() {
    let bench = bench();
    let run = bench.run(&[&["contacts"][..], &NAMES, &["--analyse", "--json", "s.json"]].concat()).succeeds();
    let forces = &bench.json("s.json")["analysis"]["forces"];
    assert_eq!(
        forces["stress"],
        serde_json::json!([[-0.012, 0.00225, 0.0], [0.0, -0.003, 0.0], [0.0, 0.0, 0.0]])
    );
    assert_eq!((&forces["mean"], &forces["largest"]), (&5.25.into(), &8.0.into()));
    assert_eq!((&forces["strong"], &forces["strong_pressure_share"]), (&1.into(), &0.8.into()));
    for part in [
        "forces           mean 5.25, largest 8; 1 above the mean, 0.5000 of the couples, which carry 0.8000 of the pressure",
        "tension positive; pressure 0.005; V = 1000\n",
    ] {
        assert!(run.stderr.contains(part), "{part:?} is not in\n{}", run.stderr);
    }
    // Without names of forces there is no stress, and the columns keep their names.
    let ids = ["contacts", "atoms.dump", "--couples", "pairs.dump", "--couple-columns", "i=2,j=c_id[2]"];
    let run = bench.run(&[&ids[..], &["--analyse", "--json", "t.json"]].concat()).succeeds();
    assert_eq!(run.stdout.lines().next(), Some("i,j,distance,overlap,index,c_f[1],c_f[2],c_f[3],sx,sy,sz"));
    assert!(bench.json("t.json")["analysis"].get("forces").is_none());
}

/// A positive `force` repels: it is that of a pressure.
#[test]
fn a_force_along_the_line_of_the_centres_repels() {
    let bench = bench();
    bench.write("pairs.dump", local(7, "patom1 patom2 force", &["2 1 4"]));
    let options = ["contacts", "atoms.dump", "--couples", "pairs.dump", "--analyse", "--json", "s.json"];
    let run = bench.run(&options).succeeds();
    assert_eq!(run.stdout, "i,j,distance,overlap,force,sx,sy,sz\n1,2,1.5,0.5,4.0,0,0,0\n");
    let forces = &bench.json("s.json")["analysis"]["forces"];
    // -4 * 1.5 / 1000.
    assert_eq!(forces["stress"][1], serde_json::json!([0.0, -0.006, 0.0]));
    assert_eq!(forces["pressure"], 0.002);
}

/// The picture has lines by force, and the page names it.
#[test]
fn force_chains_are_drawn_by_force() {
    let bench = bench();
    let flat = "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS ff ff ff\n0 10\n0 10\n0 10\n\
                ITEM: ATOMS id x y radius\n1 1 1 1\n2 3 1 1\n3 5 1 1\n";
    bench.write("atoms.dump", flat);
    bench.write("pairs.dump", local(7, "id1 id2 fx fy fz", &["1 2 -1 0 0", "2 3 -10 0 0"]));
    let drawn = ["--picture", "p.svg", "--plots", "q.svg", "--report", "r.html"];
    bench.run(&[&["contacts", "atoms.dump", "--couples", "pairs.dump"][..], &drawn].concat()).succeeds();
    let picture = bench.read("p.svg");
    let widths: Vec<f64> = picture
        .split("<path d=")
        .skip(1)
        .map(|path| path.split("stroke-width=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap())
        .collect();
    assert_eq!(widths.len(), 2);
    assert!(widths[1] > 4.0 * widths[0], "{widths:?}");
    assert!(picture.contains("coloured by its force") && picture.contains(">force<"), "{picture}");
    assert!(bench.read("q.svg").contains(">force<"));
    assert!(bench.read("r.html").contains("The largest force is 10."));
}

#[test]
fn couples_that_do_not_fit_are_refused() {
    let bench = bench();
    let refuses = |content: String, names: &str, parts: &[&str]| {
        bench.write("pairs.dump", content);
        let mut options = vec!["contacts", "atoms.dump", "--couples", "pairs.dump"];
        if !names.is_empty() {
            options.extend(["--couple-columns", names]);
        }
        bench.run(&options).refused_with(parts);
    };
    let by_place = "_,i,j,fx,fy,fz";
    refuses(
        local(7, PLAIN, &["1 1 4 0 0 0"]),
        by_place,
        &["pairs.dump:10: no element of atoms.dump has the id 4"],
    );
    refuses(
        local(7, PLAIN, &["1 1 2 0 0 0", "2 1 3 0 0 0", "3 2 1 0 0 0"]),
        by_place,
        &["pairs.dump:12: the couple of 2 and 1 is repeated, first on line 10"],
    );
    refuses(
        local(8, PLAIN, &ROWS),
        by_place,
        &["pairs.dump:2: the packing is of the time step 7", "are of 8"],
    );
    refuses(
        local(7, PLAIN, &ROWS),
        "",
        &["pairs.dump:9: no column is named as the ids i among index c_id[1]"],
    );
    refuses(local(7, PLAIN, &ROWS), "i,j,fx", &["pairs.dump:9: 3 names are given for 6 columns"]);
    refuses(local(7, PLAIN, &ROWS), "i=2,j=3,fx=c_g[1]", &["pairs.dump:9: no column 'c_g[1]'"]);
    refuses(local(7, PLAIN, &ROWS), "i=2,j=3,fx=4", &["pairs.dump:9: there is no column fy"]);
    refuses(
        local(7, PLAIN, &ROWS),
        "i=2,j=3,overlap=4",
        &["pairs.dump:9: the name overlap is that of a column of fdem"],
    );
    refuses(
        local(7, PLAIN, &["1 1 1 0 0 0"]),
        by_place,
        &["pairs.dump:10: the element 1 is a couple with itself"],
    );
    refuses(
        local(7, PLAIN, &["1 1 2 nan 0 0"]),
        by_place,
        &["pairs.dump:10: fx: 'nan' is not a finite number"],
    );
    refuses(
        local(7, PLAIN, &["1 1 1.2e+06 0 0 0"]),
        by_place,
        &["pairs.dump:10: the id '1.2e+06'", "dump_modify format"],
    );
    refuses(local(7, PLAIN, &["1 1 2"]), by_place, &["pairs.dump:10: expected 6 columns"]);
    refuses(atoms(7), by_place, &["pairs.dump:3: this is a dump of atoms"]);
    refuses("i,j\n1,2\n".to_owned(), by_place, &["pairs.dump:1: couples are read from a 'dump local'"]);
    let torn = local(7, PLAIN, &ROWS).replace("ENTRIES\n2", "ENTRIES\n3");
    refuses(torn, by_place, &["pairs.dump:11: the file ends after 2 of 3 rows"]);
    assert_eq!(bench.files(), ["atoms.dump", "pairs.dump"]);
}

/// From a file of many time steps, the one of the packing is read. In a box of half the edge two images are
/// equally near.
#[test]
fn the_time_step_and_the_image_are_those_of_the_packing() {
    let bench = bench();
    let other = local(6, PLAIN, &["1 2 3 0 0 0"]);
    bench.write("pairs.dump", other + &local(7, PLAIN, &ROWS) + &local(8, PLAIN, &[]));
    let run = bench.run(&[&["contacts"][..], &NAMES, &["--count"]].concat()).succeeds();
    assert_eq!(run.stdout, "2\n");
    bench.write("many.dump", atoms(7) + &atoms(8));
    bench
        .run(&[&["contacts", "many.dump"][..], &NAMES[1..]].concat())
        .refused_with(&["one frame", "--frames N"]);
    let run = bench.run(&[&["contacts", "many.dump", "--frames", "1"][..], &NAMES[1..]].concat()).succeeds();
    assert_eq!(run.stdout, "i,j,distance,overlap,fx,fy,fz,sx,sy,sz\n");
    bench.write("atoms.dump", atoms(7).replace("3 9.5", "3 6"));
    bench
        .run(&[&["contacts"][..], &NAMES].concat())
        .refused_with(&["pairs.dump:21: it is not clear which periodic image"]);
}
