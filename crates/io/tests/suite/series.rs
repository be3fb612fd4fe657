//! Packings with frames and boxes: one packing gives the same result in every format; errors name frame and
//! line.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

mod formats;
mod mutants;

use std::borrow::Cow;
use std::sync::atomic::AtomicU64;

use fdem_io::{
    Centres, Compression, FileKind, Format, Packing, PackingFormat, ReadError, ReadOptions, Series,
    SimulationBox, read_packing, unpack, unpack_within,
};
use formats::{CENTRES, FILES, RADII, gzip, npz, vtu, zstd};

fn frame(bytes: &[u8], name: &str, frame: usize, options: &ReadOptions) -> Result<Packing, ReadError> {
    Series::open(bytes, name, None)?.read(frame, options, &AtomicU64::new(0))
}

fn only(bytes: impl AsRef<[u8]>) -> Packing {
    read_packing(bytes.as_ref(), "a", &ReadOptions::default(), &AtomicU64::new(0)).unwrap()
}

fn fails(bytes: impl AsRef<[u8]>, name: &str) -> ReadError {
    let series = match Series::open(bytes.as_ref(), name, None) {
        Ok(series) => series,
        Err(error) => return error,
    };
    let read = |frame| series.read(frame, &ReadOptions::default(), &AtomicU64::new(0));
    (0..series.frames()).find_map(|frame| read(frame).err()).expect("a frame that is wrong")
}

#[track_caller]
fn says(bytes: impl AsRef<[u8]>, line: impl Into<Option<u64>>, parts: &[&str]) {
    let error = fails(bytes, "a");
    assert_eq!(error.line(), line.into(), "{error}");
    for part in parts {
        assert!(error.to_string().contains(part), "{part:?} is not in: {error}");
    }
}

/// The centres are exact in every format: they are halves and quarters.
#[test]
fn one_packing_is_the_same_in_every_format() {
    let mut files: Vec<(&str, PackingFormat, Cow<'_, [u8]>)> =
        FILES.iter().map(|&(format, text)| (format.name(), format, text.as_bytes().into())).collect();
    for (kind, bytes) in vtu() {
        files.push((kind, PackingFormat::VtkXml, bytes.into()));
    }
    files.push((
        "npz",
        PackingFormat::Npz,
        npz(&[("positions", &CENTRES.concat(), 3), ("radii", &RADII, 1)]).into(),
    ));
    let axis = |axis: usize| CENTRES.map(|centre| centre[axis]);
    files.push((
        "npz of columns",
        PackingFormat::Npz,
        npz(&[
            ("x", &axis(0), 1),
            ("y", &axis(1), 1),
            ("z", &axis(2), 1),
            ("velocities", &[0.0; 9], 3),
            ("radius", &RADII, 1),
            ("box", &[9.0; 2], 1),
        ])
        .into(),
    ));
    for (name, format, bytes) in files {
        assert_eq!(FileKind::of(&bytes, "a").unwrap(), FileKind::Packing(format), "{name}");
        for bytes in [bytes.to_vec(), gzip(&bytes), zstd(&bytes)] {
            let packing = only(&bytes);
            assert_eq!(packing.centres, Centres::Three(CENTRES.to_vec()), "{name}");
            assert_eq!(packing.radii.as_deref(), Some(&RADII[..]), "{name}");
        }
        // Some or all lines may end as on Windows.
        if !bytes.contains(&0) && format != PackingFormat::VtkXml {
            let text = String::from_utf8(bytes.to_vec()).unwrap();
            let mixed: String = text
                .split_inclusive('\n')
                .enumerate()
                .map(|(at, line)| if at % 2 == 0 { line.replace('\n', "\r\n") } else { line.to_owned() })
                .collect();
            for text in [text.replace('\n', "\r\n"), mixed] {
                assert_eq!(only(&text).centres, Centres::Three(CENTRES.to_vec()), "{name}");
            }
            // Without its last line, a file is cut off or its counts are wrong; a table has no counts.
            let short = &text[..=text.trim_end().rfind('\n').unwrap()];
            if format != PackingFormat::Text {
                let series = Series::open(short.as_bytes(), "a", None).unwrap();
                let read = series.read(0, &ReadOptions::default(), &AtomicU64::new(0));
                assert!(read.is_err(), "{short}");
            }
            let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
            let error = fails(&wide, "a").to_string();
            assert!(error.contains("UTF-16 text") && error.contains("save it as UTF-8"), "{name}: {error}");
        }
    }
}

const DUMP: &str = "ITEM: UNITS\nlj\nITEM: TIME\n0.5\nITEM: TIMESTEP\n1000\nITEM: NUMBER OF ATOMS\n2\n\
                    ITEM: BOX BOUNDS pp ff ss\n-1 3\n0 8\n0 16\n";

#[test]
fn coordinates_of_dumps_are_scaled_unwrapped_or_neither() {
    let dump = |columns: &str, rows: &str| only(format!("{DUMP}ITEM: ATOMS {columns}\n{rows}"));
    let packing = dump("id xs ys zs", "5 0.25 0.5 0.75\n3 1.25 0 0\n");
    assert_eq!(packing.centres, Centres::Three(vec![[0.0, 4.0, 12.0], [4.0, 0.0, 0.0]]));
    assert_eq!(packing.ids, Some(vec![5, 3]));
    assert_eq!((packing.frame.step, packing.frame.time), (Some(1000), Some(0.5)));
    assert_eq!(
        packing.cell,
        Some(SimulationBox {
            origin: [-1.0, 0.0, 0.0],
            edges: [[4.0, 0.0, 0.0], [0.0, 8.0, 0.0], [0.0, 0.0, 16.0]],
            repeats: [true, false, false],
        })
    );
    assert_eq!(dump("xsu ysu zsu", "0.25 0.5 0.75\n1.25 0 0\n").centres, packing.centres);
    let plain = Centres::Three(vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!(dump("xu yu zu", "1 2 3\n4 5 6\n").centres, plain);
    assert_eq!(dump("xs ys zs x y z", "0 0 0 1 2 3\n0 0 0 4 5 6\n").centres, plain, "plain ones come first");
    assert_eq!(dump("c_x x y z diameter", "9 1 2 3 1\n9 4 5 6 3\n").radii, Some(vec![0.5, 1.5]));
    assert_eq!(dump("x y", "1 2\n3 4\n").centres, Centres::Two(vec![[1.0, 2.0], [3.0, 4.0]]));
    let options = ReadOptions { columns: "_,x,y,z,d".parse().ok(), ..ReadOptions::default() };
    let text = format!("{DUMP}ITEM: ATOMS a b c d e\n1 2 3 4 5\n1 2 3 4 5\n");
    assert_eq!(frame(text.as_bytes(), "a", 0, &options).unwrap().radii, Some(vec![2.5, 2.5]));
}

/// The example of the LAMMPS documentation, "Howto triclinic": bounds enclose the tilted box.
#[test]
fn tilted_boxes_are_found_in_their_bounds() {
    let dump = |bounds: &str, row: &str, columns: &str| {
        only(format!(
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS {bounds}\nITEM: ATOMS {columns}\n{row}\n"
        ))
    };
    let packing = dump("xy xz yz pp pp fs\n-2 11 1\n0 14 -2\n0 10 4", "0.5 0.5 0.5", "xs ys zs");
    let cell = packing.cell.unwrap();
    assert_eq!(cell.origin, [0.0, 0.0, 0.0]);
    assert_eq!(cell.edges, [[10.0, 0.0, 0.0], [1.0, 10.0, 0.0], [-2.0, 4.0, 10.0]]);
    assert_eq!(cell.repeats, [true, true, false]);
    assert_eq!(packing.centres, Centres::Three(vec![[4.5, 7.0, 5.0]]));
    let packing = dump("abc origin pp ff pp\n1 2 0 -1\n0 4 0 -2\n0 1 8 -3", "1 1 1", "x y z");
    let cell = packing.cell.unwrap();
    assert_eq!((cell.origin, cell.repeats), ([-1.0, -2.0, -3.0], [true, false, true]));
    assert_eq!(cell.edges, [[1.0, 2.0, 0.0], [0.0, 4.0, 0.0], [0.0, 1.0, 8.0]]);
    let old = dump("\n0 1\n0 1\n0 1", "0 0 0", "x y z");
    assert_eq!(old.cell.unwrap().repeats, [false; 3], "old dumps do not say");
}

#[test]
fn frames_are_read_in_any_order() {
    let frames = |frame: &dyn Fn(usize) -> String| (0..5).map(frame).collect::<Vec<_>>().concat();
    let xyz = frames(&|k| format!("{k}\nstep={} Time={k}.5\n{}", 10 * k, "A 1 2 3\n".repeat(k)));
    let mercury = frames(&|k| format!("{k} {k}.5 0 0 4 4\n{}", "1 2 0 0 0.5 0 0 0\n".repeat(k)));
    let dump = frames(&|k| {
        let rows: Vec<String> = (0..k).map(|id| format!("{id} 1 2 3\n")).collect();
        let bounds = "ITEM: BOX BOUNDS ff ff ff\n0 4\n0 4\n0 4\n";
        let (step, rows) = (10 * k, rows.concat());
        format!("ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{k}\n{bounds}ITEM: ATOMS id x y z\n{rows}")
    });
    for (format, text) in
        [(PackingFormat::Xyz, xyz), (PackingFormat::Mercury, mercury), (PackingFormat::LammpsDump, dump)]
    {
        let series = Series::open(text.as_bytes(), "a.data", None).unwrap();
        assert_eq!((series.format(), series.frames()), (format, 5));
        for k in [3, 0, 4, 1, 2] {
            let packing = series.read(k, &ReadOptions::default(), &AtomicU64::new(0)).unwrap();
            assert_eq!((packing.centres.len(), packing.frame.index), (k, k), "{format}");
            assert_eq!(
                packing.frame.step,
                (format != PackingFormat::Mercury).then_some(10 * i64::try_from(k).unwrap())
            );
            assert_eq!(packing.frame.time, (format != PackingFormat::LammpsDump).then_some(k as f64 + 0.5));
        }
        let error = series.read(5, &ReadOptions::default(), &AtomicU64::new(0)).unwrap_err();
        assert_eq!(error, ReadError::NoFrame { wanted: 5, frames: 5 });
        let one = read_packing(text.as_bytes(), "a", &ReadOptions::default(), &AtomicU64::new(0));
        assert_eq!(one, Err(ReadError::SeveralFrames { frames: 5 }));
    }
}

#[test]
fn mercury_has_two_dimensions_or_three() {
    let packing = only("1 0.25 0 0 4 8\n1 2 0 0 0.5 0 0 7\n");
    assert_eq!(packing.centres, Centres::Two(vec![[1.0, 2.0]]));
    assert_eq!((packing.radii, packing.frame.time), (Some(vec![0.5]), Some(0.25)));
    assert_eq!(packing.cell.unwrap().edges[1], [0.0, 8.0, 0.0]);
    let infinite = only("1 0.25 0 0 inf 8\n1 2 0 0 0.5 0 0 7\n");
    assert_eq!(infinite.cell, None);
}

#[test]
fn extended_xyz_says_what_its_columns_are() {
    let text = "2\nProperties=id:I:1:species:S:1:pos:R:3:velo:R:3:Diameter:R:1 Lattice='4 0 0 1 4 0 0 0 0' pbc=\"T T F\" Origin=\"1 2 3\"\n\
                8 A 1 2 3 0 0 0 1\n9 B 4 5 6 0 0 0 2\n";
    let packing = only(text);
    assert_eq!(packing.source.format, Format::Xyz { extended: true });
    assert_eq!(packing.ids, Some(vec![8, 9]));
    assert_eq!(packing.radii, Some(vec![0.5, 1.0]));
    let cell = packing.cell.unwrap();
    assert_eq!((cell.origin, cell.repeats), ([1.0, 2.0, 3.0], [true, true, false]));
    assert_eq!(cell.edges, [[4.0, 0.0, 0.0], [1.0, 4.0, 0.0], [0.0; 3]]);
    let flat = only("1\nProperties=pos:R:2:r:R:1\n1 2 0.5\n");
    assert_eq!(flat.centres, Centres::Two(vec![[1.0, 2.0]]));
    let plain = only("1\nsome words\nC 1 2 3 0.1 0.2 0.3\n");
    assert_eq!((plain.radii, plain.cell), (None, None));
    let options = ReadOptions { bodies: Some("mol".into()), ..ReadOptions::default() };
    let text = b"2\nProperties=pos:R:3:mol:I:1\n1 2 3 7\n1 2 3 7\n";
    assert_eq!(frame(text, "a", 0, &options).unwrap().bodies, Some(vec![7, 7]));
}

#[test]
fn atom_styles_say_what_the_columns_of_data_files_are() {
    let data = |section: &str, rows: &str| {
        format!(
            "title\n\n2 atoms # so many\n1 atom types\n0 4 xlo xhi\n0 4 ylo yhi\n-1 5 zlo zhi\n1 0 0.5 xy xz yz\n\nMasses\n\n1 1.0\n\n{section}\n\n{rows}\nVelocities\n\n1 0 0 0\n2 0 0 0\n"
        )
    };
    let sphere = only(data("Atoms # sphere", "1 1 1.0 2.5 1 2 3\n2 1 3.0 2.5 4 5 6\n"));
    assert_eq!(sphere.radii, Some(vec![0.5, 1.5]));
    assert_eq!(sphere.source.format, Format::LammpsData { style: Some("sphere".into()) });
    let cell = sphere.cell.unwrap();
    assert_eq!((cell.origin, cell.repeats), ([0.0, 0.0, -1.0], [false; 3]));
    assert_eq!(cell.edges, [[4.0, 0.0, 0.0], [1.0, 4.0, 0.0], [0.0, 0.5, 6.0]]);
    let images = only(data("Atoms  # sphere", "1 1 1.0 2.5 1 2 3 0 0 0\n2 1 3.0 2.5 4 5 6 0 1 0\n"));
    assert_eq!((images.centres, images.radii), (sphere.centres, sphere.radii));
    let full = only(data("Atoms # full", "1 1 1 0.5 1 2 3\n2 1 1 0.5 4 5 6\n"));
    assert_eq!(full.centres, Centres::Three(vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]));
    assert_eq!(full.radii, None);
    let odd = data("Atoms # hybrid sphere ours", "1 1 1 2 3 1.0\n2 1 4 5 6 3.0\n");
    says(&odd, 14, &["atom style 'hybrid sphere ours'", "--columns"]);
    let options = ReadOptions { columns: "id,_,x,y,z,d".parse().ok(), ..ReadOptions::default() };
    assert_eq!(frame(odd.as_bytes(), "a", 0, &options).unwrap().radii, Some(vec![0.5, 1.5]));
    says(
        data("Atoms", "1 1 1 2 3\n2 1 4 5 6\n"),
        14,
        &["the meaning of the columns is not given", "'Atoms # sphere'"],
    );
    says(data("Atoms # sphere", "1 1 1 2 3\n2 1 4 5 6\n"), 14, &["sphere has 7 columns", "first row has 5"]);
    says(data("Atoms # atomic", "1 1 1 2 3\n2 1 4 5 6\n3 1 4 5 6\n"), 18, &["after 2 rows", "more rows"]);
    says(data("Atoms # atomic", "1 1 1 2 3\n"), 17, &["expected row 2 of 2"]);
    let general = "title\n1 atoms\n4 0 0 avec\n0 4 0 bvec\n1 1 4 cvec\n-1 -1 -1 abc origin\nAtoms # atomic\n\n1 1 0 0 0\n";
    assert_eq!(only(general).cell.unwrap().edges[2], [1.0, 1.0, 4.0]);
}

#[test]
fn what_is_wrong_is_said_with_its_line() {
    let head = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 4\n0 4\n0 4\n";
    let atoms = "ITEM: ATOMS id x y z\n";
    says(format!("{head}{atoms}1 0 0 0\n"), 10, &["the file ends after 1 of 2 rows"]);
    says(format!("{head}{atoms}1 0 0 0\n2 0 0\n"), 11, &["expected 4 fields, found 3"]);
    says(format!("{head}{atoms}1 0 0 0\n2 0 nan 0\n"), 11, &["'nan' in column y", "not a finite"]);
    says(format!("{head}{atoms}1 0 0 0\n\n2 0 0 0\n"), 11, &["row 2 of 2", "blank line"]);
    says(format!("{head}{atoms}1 0 0 0\n1 0 0 0\n"), 11, &["id 1 is on line 10 and again on line 11"]);
    says(
        format!("{head}{atoms}1 0 0 0\n2 0 0 0\n3 0 0 0\n"),
        12,
        &["after 2 rows", "'3 0 0 0'", "more rows"],
    );
    says(format!("{head}ITEM: ATOMS id vx vy\n1 0 0\n2 0 0\n"), 9, &["no column for x", "id, vx, vy"]);
    says(head, 8, &["the file ends here", "ITEM"]);
    says("ITEM: TIMESTEP\n0.5\n", 2, &["time step '0.5'"]);
    says("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n-1\n", 4, &["number of atoms '-1'"]);
    says("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ENTRIES\n1\n", 3, &["this is a 'dump local' of pairs"]);
    says(head.replace("pp pp pp", "pp pq pp"), 5, &["'pq' is no kind of boundary"]);
    says(head.replace("pp pp pp", "pp pf pp"), 5, &["'pf' is no kind of boundary"]);
    says(head.replace("0 4\n0 4\n0 4", "0 4\n4 0\n0 4"), 7, &["do not ascend: 4 and 0"]);
    says(head.replace("0 4\n0 4\n0 4", "0 4\n0 inf\n0 4"), 7, &["'inf' is not a finite number"]);
    says(head.replace("0 4\n0 4\n0 4", "0 4 1\n0 4\n0 4"), 6, &["expected two limits"]);

    says("3\n\nA 1 2 3\nB 1 2 3\n", 4, &["the file ends after 2 of 3 rows"]);
    says("1\n\nA 1 2 3\nB 1 2 3\n", 4, &["after 1 row", "'B 1 2 3'"]);
    says("1\n", 1, &["expected a comment"]);
    says("1\n\nA 1 2\n", 3, &["expected 4 fields, found 3"]);
    says("1\nLattice=\"1 2 3\"\nA 1 2 3\n", 2, &["Lattice should be nine numbers"]);
    says("1\nLattice=\"1 0 0 0 1 0 0 0 1\" pbc=\"T T\"\nA 1 2 3\n", 2, &["pbc should be three"]);
    says("1\nProperties=pos:R\n1 2 3\n", 2, &["name:type:count"]);
    says("1\nProperties=pos:R:3:radius:R:1\n1 2 3 -1\n", 3, &["radius -1", "negative"]);
    says("1\nProperties=species:S:1:r:R:1\nA 1\n", 2, &["no column for x"]);

    says("2 0 0 0 0 4 4 4\n1 2 3 0 0 0 0.5 0 0 0 0 0 0 0\n", 2, &["the file ends after 1 of 2 rows"]);
    says("1 0 0 0 4 4\n1 2 0 0 -1 0 0 0\n", 2, &["the radius -1", "negative"]);
}

/// The error names the frame in addition to the line; other frames can still be read.
#[test]
fn a_damaged_frame_is_named() {
    let text = b"1\n\nA 1 2 3\n1\n\nA 1 2 x\n1\n\nA 1 2 3\n2\n\nA 1 2 3\n";
    let series = Series::open(text, "a.xyz", None).unwrap();
    assert_eq!(series.frames(), 4);
    let read = |frame| series.read(frame, &ReadOptions::default(), &AtomicU64::new(0));
    assert!(read(0).is_ok() && read(2).is_ok());
    let error = read(1).unwrap_err();
    assert_eq!(error.line(), Some(6));
    assert_eq!(
        error.to_string(),
        "frame 1 (counted from 0): cannot read 'x' as a number in column z: A 1 2 x"
    );
    assert_eq!(read(3).unwrap_err().to_string(), "frame 3 (counted from 0): the file ends after 1 of 2 rows");
    let skip = ReadOptions { skip_bad_lines: true, ..ReadOptions::default() };
    let packing = frame(b"2\n\nA 1 2 x\nA 1 2 3\n", "a", 0, &skip).unwrap();
    assert_eq!((packing.source.skipped.count, packing.row_numbers), (1, Some(vec![1])));
}

#[test]
fn vtk_without_cells_is_a_packing_and_with_cells_a_mesh() {
    let text = FILES.iter().find(|(format, _)| *format == PackingFormat::Vtk).unwrap().1;
    let cells = text.replace("POINT_DATA", "POLYGONS 1 4\n3 0 1 2\nPOINT_DATA");
    assert!(matches!(FileKind::of(cells.as_bytes(), "a").unwrap(), FileKind::Mesh(_)));
    let forced = Series::open(cells.as_bytes(), "a.vtk", Some(PackingFormat::Vtk)).unwrap();
    let packing = forced.read(0, &ReadOptions::default(), &AtomicU64::new(0)).unwrap();
    assert_eq!(packing.radii.as_deref(), Some(&RADII[..]));
    for (name, factor) in [("Radius", 1.0), ("diameter", 0.5), ("Scale", 0.5), ("radii", 1.0)] {
        let packing = only(text.replace("radius", name));
        assert_eq!(packing.radii, Some(RADII.map(|radius| factor * radius).to_vec()), "{name}");
    }
    assert_eq!(only(text.replace("radius", "mass")).radii, None);
    assert_eq!(only(text).frame.time, Some(2.5));
    says(text.replace("0.5 0.25 1", "0.5 nan 1"), None, &["row 1 (counted from 0)", "radius", "NaN"]);
    says(text.replace("0.5 0.25 1", "0.5 -1 1"), None, &["row 1 (counted from 0)", "negative"]);
    says(
        text.replace("POINT_DATA 3", "POINT_DATA 2")
            .replace("VECTORS velocity float\n0 0 0 0 0 0 0 0 0\n", "")
            .replace("0.5 0.25 1", "0.5 0.25"),
        None,
        &["2 values for 3 points"],
    );
}

#[test]
fn names_count_only_where_the_content_says_nothing() {
    let table = b"x,y,radius\n0,0,1\n";
    for name in ["a.xyz", "a.data", "a.dump", "a.npz", "a.lmp"] {
        assert_eq!(frame(table, name, 0, &ReadOptions::default()).unwrap().radii, Some(vec![1.0]), "{name}");
        let error = fails(b"rubbish\n", name).to_string();
        assert!(
            error.contains("the name stands for") && error.contains("read as a table"),
            "{name}: {error}"
        );
    }
    let error = fails(b"\x00\x01\x02", "a.dump").to_string();
    assert!(
        error.contains("LAMMPS dump") && error.contains("'ITEM:'") && error.contains("not a text file"),
        "{error}"
    );
    for format in PackingFormat::ALL {
        let series = Series::open(b"\x00rubbish", "a", Some(format));
        let read = series.and_then(|series| series.read(0, &ReadOptions::default(), &AtomicU64::new(0)));
        assert!(read.is_err(), "{format}");
    }
}

#[test]
fn archives_of_arrays_that_do_not_fit_are_refused() {
    says(
        npz(&[("positions", &[0.0; 6], 3), ("radii", &[1.0; 3], 1)]),
        None,
        &["array radii has 3 rows, array positions 2"],
    );
    says(npz(&[("a", &[0.0; 6], 3), ("b", &[1.0; 2], 1)]), None, &["no column for x", "a:0"]);
    says(
        npz(&[("positions", &[0.0, 0.0, f64::NAN, 0.0, 0.0, 0.0], 3), ("radii", &[1.0; 2], 1)]),
        None,
        &["row 0", "z", "NaN"],
    );
    let alone = npz(&[("packing", &[1.0, 2.0, 3.0, 0.5], 4)]);
    assert_eq!(only(alone).radii, Some(vec![0.5]));
    let whole = npz(&[("positions", &[0.0; 6], 3), ("radii", &[1.0; 2], 1)]);
    for end in (10..whole.len()).step_by(7) {
        fails(&whole[..end], "a.npz");
    }
}

#[test]
fn compressed_files_are_unpacked_whole_or_refused() {
    let text = "x,y\n0,1\n".repeat(10_000);
    for (compression, packed) in
        [(Compression::Gzip, gzip(text.as_bytes())), (Compression::Zstd, zstd(text.as_bytes()))]
    {
        assert_eq!(Compression::of(&packed), Some(compression));
        let all =
            |bytes: &[u8]| unpack(Cow::Owned(bytes.to_vec()), |_| true).map(|(bytes, _)| bytes.into_owned());
        assert_eq!(all(&packed).unwrap(), text.as_bytes());
        assert_eq!(
            all(&[packed.clone(), packed.clone()].concat()).unwrap(),
            text.repeat(2).as_bytes(),
            "members follow"
        );
        for end in 4..packed.len() {
            let error = all(&packed[..end]).unwrap_err();
            assert!(matches!(error, ReadError::Packed { .. }), "{compression} {end}: {error}");
            assert!(error.to_string().contains(&format!("{compression}-compressed")), "{error}");
        }
        let mut damaged = packed.clone();
        *damaged.last_mut().unwrap() ^= 1;
        assert!(matches!(all(&damaged), Err(ReadError::Packed { .. })), "{compression}: the checksum");
    }
    let skippable = [b"\x50\x2a\x4d\x18\x03\0\0\0abc".to_vec(), zstd(b"x,y\n0,1\n")].concat();
    assert_eq!(unpack(skippable.into(), |_| true).unwrap().0.as_ref(), b"x,y\n0,1\n");
}

/// Text of 8 MB in a few kB: refused by the size that the file states, and while it is unpacked.
#[test]
fn content_beyond_a_limit_is_refused() {
    let text = "x,y\n0,1\n".repeat(1 << 20);
    let text = text.as_bytes();
    let within = |bytes: &[u8], limit| {
        unpack_within(Cow::Owned(bytes.to_vec()), limit, |_| true).map(|(bytes, _)| bytes.len())
    };
    for packed in [gzip(text), zstd(text)] {
        assert_eq!(within(&packed, text.len() as u64).unwrap(), text.len());
        let error = within(&packed, text.len() as u64 - 1).unwrap_err();
        assert!(matches!(error, ReadError::TooLarge { .. }), "{error}");
    }
    // A second member states less than both hold.
    let error = within(&[gzip(text), gzip(b"0,2\n")].concat(), 1 << 20).unwrap_err();
    assert_eq!(error.to_string(), "gzip-compressed content of 2 MB or more: the limit is 1 MB");
}

/// Zeros are compressed to a thousandth of their size.
#[test]
fn what_unpacks_to_rubbish_is_given_up() {
    let zeros = gzip(&vec![0; 64 << 20]);
    let (bytes, _) = unpack(zeros.into(), |start| !start.contains(&0)).unwrap();
    assert!(bytes.len() < 4 << 20, "{}", bytes.len());
}

#[test]
fn yade_names_its_columns_in_a_comment() {
    let packing = only("#format x_y_z_r_matId\n# of a run\n1 2 3 0.5 7\n4 5 6 0.25 7\n");
    assert_eq!(packing.radii, Some(vec![0.5, 0.25]));
    let packing = only("#format id_x_y_z_r_matId\n9 1 2 3 0.5 7\n");
    assert_eq!((packing.ids, packing.radii), (Some(vec![9]), Some(vec![0.5])));
    assert_eq!(only("#format x_y_z_r\n1\t2\t3\t0.5\n").radii, Some(vec![0.5]));
    assert_eq!(only("#format x_y_z_r_attrs\n1 2 3 0.5 7 8 9\n").radii, Some(vec![0.5]));
}
