//! Files of a mesh at one time: read back byte by byte, for any size, and refused if they could not be read.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::io::{self, ErrorKind, Read};

use fdem_io::{Table, Values, pvd, write_poly_vtp, write_vtu};
use flate2::read::ZlibDecoder;

/// `n` points and `m` triangles between them.
fn written(n: usize, m: usize) -> Vec<u8> {
    let points = Table::new(n)
        .with_components("positions", &["x", "y", "z"], Values::f64(|k| k as f64 / 7.0))
        .with_components("velocity", &["x", "y", "z"], Values::f64(|k| -1e-300 * k as f64))
        .in_unit("m/s");
    let triangles = Table::new(m)
        .with_components("nodes", &["a", "b", "c"], Values::i64(move |k| (k % n.max(1)).cast_signed() as i64))
        .with_components("stress", &["xx", "yy"], Values::f64(|k| if k == 3 { f64::NAN } else { k as f64 }))
        .with("body", Values::i32(|k| -(k.cast_signed() as i32)));
    let mut out = Vec::new();
    let named = [("body: a \"<b>\" & c".to_owned(), vec![0, 6])];
    write_vtu(&mut out, &points, &triangles, 0.125, &named).unwrap();
    out
}

/// The text before the arrays, and the arrays.
fn parts(file: &[u8]) -> (&str, &[u8]) {
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let at = file.windows(mark.len()).position(|window| window == mark).unwrap();
    let end = file.len() - b"\n</AppendedData>\n</VTKFile>\n".len();
    assert_eq!(&file[end..], b"\n</AppendedData>\n</VTKFile>\n");
    (std::str::from_utf8(&file[..at]).unwrap(), &file[at + mark.len()..end])
}

/// The XML element that describes an array, and the bytes of the array.
fn array<'a>(file: &'a [u8], name: &str) -> (&'a str, Vec<u8>) {
    let (head, body) = parts(file);
    let line = head.lines().find(|line| line.contains(&format!("Name=\"{name}\""))).unwrap();
    let offset = line.split("offset=\"").nth(1).unwrap().split('"').next().unwrap();
    let mut at: usize = offset.parse().unwrap();
    let mut word = || {
        at += 8;
        u64::from_le_bytes(body[at - 8..at].try_into().unwrap()) as usize
    };
    let (blocks, size, partial) = (word(), word(), word());
    let sizes: Vec<usize> = (0..blocks).map(|_| word()).collect();
    let mut bytes = Vec::new();
    for (k, compressed) in sizes.iter().enumerate() {
        let before = bytes.len();
        ZlibDecoder::new(&body[at..at + compressed]).read_to_end(&mut bytes).unwrap();
        at += compressed;
        let expected = if k + 1 == blocks && partial > 0 { partial } else { size };
        assert_eq!(bytes.len() - before, expected, "block {k} of {name}");
    }
    (line, bytes)
}

fn floats(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|word| f64::from_le_bytes(word.try_into().unwrap())).collect()
}

fn integers(bytes: &[u8]) -> Vec<i64> {
    bytes.chunks_exact(8).map(|word| i64::from_le_bytes(word.try_into().unwrap())).collect()
}

#[test]
fn every_array_reads_back_bit_for_bit() {
    let file = written(5, 4);
    let (line, points) = array(&file, "Points");
    assert!(line.contains("type=\"Float64\"") && line.contains("NumberOfComponents=\"3\""));
    assert_eq!(floats(&points), (0..15).map(|k| f64::from(k) / 7.0).collect::<Vec<_>>());
    assert_eq!(floats(&array(&file, "velocity").1)[14], -14e-300);
    let (line, stress) = array(&file, "stress");
    assert!(line.contains("ComponentName0=\"xx\" ComponentName1=\"yy\""));
    assert!(floats(&stress)[3].is_nan());
    assert_eq!(floats(&stress)[4..], [4.0, 5.0, 6.0, 7.0]);
    assert_eq!(array(&file, "body").1[12..], (-3_i32).to_le_bytes());
    assert_eq!(integers(&array(&file, "connectivity").1), [0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0, 1]);
    assert_eq!(integers(&array(&file, "offsets").1), [3, 6, 9, 12]);
    assert_eq!(array(&file, "types").1, [5; 4]);
    assert_eq!(floats(&array(&file, "TimeValue").1), [0.125]);
    assert_eq!(integers(&array(&file, "body: a &quot;&lt;b&gt;&quot; &amp; c").1), [0, 6]);
    let (head, _) = parts(&file);
    assert!(head.contains("NumberOfPoints=\"5\" NumberOfCells=\"4\""));
    let unit =
        "<InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">m/s</InformationKey>\n</DataArray>";
    let velocity = head.split("Name=\"velocity\"").nth(1).unwrap();
    assert!(velocity.split("</PointData>").next().unwrap().contains(unit));
    assert_eq!(head.matches("UNITS_LABEL").count(), 1);
}

#[test]
fn points_and_lines_read_back_bit_for_bit() {
    let points = |n| {
        Table::new(n)
            .with_components("positions", &["x", "y", "z"], Values::f64(|k| k as f64 / 7.0))
            .with("force", Values::f64(|k| -(k as f64)))
            .in_unit("N")
    };
    let mut file = Vec::new();
    write_poly_vtp(&mut file, &points(3), None, 2.5).unwrap();
    assert!(parts(&file).0.contains("NumberOfPoints=\"3\" NumberOfVerts=\"3\" NumberOfLines=\"0\""));
    assert!(parts(&file).0.contains("<Verts>") && !parts(&file).0.contains("<Lines>"));
    assert_eq!(integers(&array(&file, "connectivity").1), [0, 1, 2]);
    assert_eq!(integers(&array(&file, "offsets").1), [1, 2, 3]);
    assert_eq!(floats(&array(&file, "force").1), [0.0, -1.0, -2.0]);
    assert_eq!(floats(&array(&file, "TimeValue").1), [2.5]);

    let lines = Table::new(2)
        .with_components("ends", &["i", "j"], Values::i64(|k| [0, 1, 1, 2][k]))
        .with("damage", Values::f64(|k| 0.5 * k as f64));
    let mut file = Vec::new();
    write_poly_vtp(&mut file, &points(3), Some(&lines), 0.0).unwrap();
    assert!(parts(&file).0.contains("NumberOfPoints=\"3\" NumberOfVerts=\"0\" NumberOfLines=\"2\""));
    assert_eq!(integers(&array(&file, "connectivity").1), [0, 1, 1, 2]);
    assert_eq!(integers(&array(&file, "offsets").1), [2, 4]);
    assert_eq!(floats(&array(&file, "damage").1), [0.0, 0.5]);

    let faces = Table::new(1).with_components("corners", &["a", "b", "c"], Values::i64(|k| [0, 1, 2][k]));
    let mut file = Vec::new();
    write_poly_vtp(&mut file, &points(3), Some(&faces), 0.0).unwrap();
    assert!(parts(&file).0.contains("NumberOfLines=\"0\"") && parts(&file).0.contains("NumberOfPolys=\"1\""));
    assert_eq!(integers(&array(&file, "connectivity").1), [0, 1, 2]);
    assert_eq!(integers(&array(&file, "offsets").1), [3]);

    let mut out = Vec::new();
    let fours = Table::new(1).with_components("corners", &["a", "b", "c", "d"], Values::i64(|_| 0));
    for (points, lines) in [(Table::new(1), None), (points(3), Some(&fours))] {
        let error = write_poly_vtp(&mut out, &points, lines, 0.0).unwrap_err();
        assert_eq!((error.kind(), out.len()), (ErrorKind::InvalidInput, 0));
    }
}

#[test]
fn arrays_of_several_blocks_and_of_exactly_one_are_whole() {
    // A block has 2²⁰ bytes: 131,072 floats or 2²⁰ types.
    let file = written(131_072, 131_072);
    assert_eq!(floats(&array(&file, "Points").1).len(), 3 * 131_072);
    assert_eq!(integers(&array(&file, "offsets").1).last(), Some(&393_216));
    assert_eq!(array(&file, "types").1.len(), 131_072);
    assert_eq!(file, written(131_072, 131_072), "the same bytes again");
}

#[test]
fn nothing_is_a_mesh_too() {
    let file = written(0, 0);
    for name in ["Points", "velocity", "connectivity", "offsets", "types", "stress", "body"] {
        assert!(array(&file, name).1.is_empty(), "{name}");
    }
    assert_eq!(floats(&array(&file, "TimeValue").1), [0.125]);
}

#[test]
fn columns_that_are_no_mesh_are_refused() {
    let points = || Table::new(3).with_components("positions", &["x", "y", "z"], Values::f64(|k| k as f64));
    let triangles = || Table::new(1).with_components("nodes", &["a", "b", "c"], Values::i64(|_| 0));
    let refused = |points: &Table<'_>, triangles: &Table<'_>| {
        let mut out = Vec::new();
        let error: io::Error = write_vtu(&mut out, points, triangles, 0.0, &[]).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidInput);
        assert!(out.is_empty(), "nothing half written");
        error.to_string()
    };
    assert!(refused(&Table::new(3), &triangles()).contains("without"));
    let flat = Table::new(3).with_components("positions", &["x", "y"], Values::f64(|_| 0.0));
    assert_eq!(refused(&flat, &triangles()), "positions are three floats each");
    let edges = Table::new(1).with_components("nodes", &["a", "b"], Values::i64(|_| 0));
    assert_eq!(refused(&points(), &edges), "the corners of a cell are three or four whole numbers");
    let named = triangles().with("name", Values::text(4, |_| "rock"));
    assert_eq!(refused(&points(), &named), "the array name is of text, which a VTK file cannot have");
}

#[test]
fn a_collection_names_times_and_files_and_nothing_else() {
    let text = pvd([(0.0, "a.vtu"), (1e-7, "b<\"&.vtu")]);
    assert!(text.contains("<DataSet timestep=\"0\" part=\"0\" file=\"a.vtu\"/>"));
    assert!(text.contains("<DataSet timestep=\"0.0000001\" part=\"0\" file=\"b&lt;&quot;&amp;.vtu\"/>"));
    assert!(text.starts_with("<?xml") && text.ends_with("</VTKFile>\n"));
    assert_eq!(pvd([]).matches("DataSet").count(), 0);
}
