//! Errors of bad files: messages name line, column and remedy.

#![allow(clippy::panic, reason = "helpers of tests fail like tests")]

use std::sync::atomic::AtomicU64;

use fdem_io::{ReadError, ReadOptions, Role, read};

fn fails(bytes: impl AsRef<[u8]>, options: &ReadOptions) -> ReadError {
    match read(bytes.as_ref(), options, &AtomicU64::new(0)) {
        Err(error) => error,
        Ok(packing) => panic!("read {packing:?} from {:?}", String::from_utf8_lossy(bytes.as_ref())),
    }
}

fn error(text: &str) -> ReadError {
    fails(text, &ReadOptions::default())
}

/// Texts, each with the line of its error and the required parts of the message.
#[test]
fn rows_that_cannot_be_read() {
    for (text, line, message) in [
        ("x,y,z,r\n1,2,3,4\n1,2,3\n", 3, "expected 4 fields, found 3: 1,2,3"),
        ("1 2 3 4\n\n# c\n5 0.01 0.01 0 0 0.06", 4, "expected 4 fields, found 6: 5 0.01 0.01 0 0 0.06"),
        ("x,y\n1,abc\n", 2, "cannot read 'abc' as a number in column y"),
        ("PosX[m] PosY[m]\n1 2\n1 2.3.4\n", 3, "cannot read '2.3.4' as a number in column PosY[m]"),
        ("1 2 3 0.5O\n", 1, "cannot read '0.5O' as a number in column radius"),
        ("x,y\n1,\n", 2, "column y is empty"),
        ("x,y\n,\n", 2, "column x is empty"),
        ("x,y\n1,NaN\n", 2, "'NaN' in column y is not a finite number"),
        ("x,y\n-inf,1\n", 2, "'-inf' in column x is not a finite number"),
        ("nan 1 2\n", 1, "'nan' in column x is not a finite number"),
        ("x,y\n1,1e400\n", 2, "'1e400' in column y is too large for a 64-bit float"),
        ("x,y,radius\n0,0,-1\n", 2, "the radius -1 is negative"),
        ("x,y,D[m]\n0,0,-1e-3\n", 2, "the diameter -0.001 in column D[m] is negative"),
        ("x,y,id\n0,0,1.5\n", 2, "the id '1.5' in column id is not a whole number"),
        ("x,y,id\n0,0,9223372036854775808\n", 2, "does not fit 64 bits"),
        ("x,y,id\n0,0,1e16\n", 2, "beyond 2^53"),
        ("x y\n0.5 0,2\n", 2, "'0,2' in column y looks like a decimal comma: use a point"),
        ("x;y\n0,5;0,2\n", 2, "'0,5' in column x looks like a decimal comma"),
        ("0,5;0,2;0,1\n", 1, "'0,5' looks like a decimal comma"),
        ("0,5 0,2 0,1\n", 1, "'5 0' looks like a decimal comma"),
        ("0,5\t-0,2\t0,1\t0,01\n", 1, "looks like a decimal comma"),
        ("x,y\n0,5,0,2\n", 2, "expected 2 fields, found 4 (looks like a decimal comma"),
        ("x y\n1 2\n1 2 \u{1b}[31m\n", 3, "found 3: 1 2 \\u{1b}[31m"),
        ("x,y\n0,5 0,2\n", 2, "'0,5' in column x looks like a decimal comma"),
        ("x y note\n1 2 #c\n", 2, "expected 3 fields, found 2"),
        ("note x y\n\"5 6 7\n", 2, "expected 3 fields, found 1"),
        ("x,y\n\"1,2\n", 2, "expected 2 fields, found 1"),
        ("x,y\n1\n2\n", 2, "expected 2 fields, found 1: 1"),
        ("sep=|\nx|y\n", 1, "this separator is not read"),
    ] {
        let error = error(text);
        assert!(matches!(error, ReadError::Malformed { .. }), "{text:?}: {error:?}");
        assert_eq!(error.line(), Some(line), "{text:?}: {error}");
        assert!(error.to_string().contains(message), "{text:?}: {error}");
    }
}

#[test]
fn rows_with_another_separator() {
    for (text, line, message) in [
        ("x,y,r\n0,0,1\n1\t0\t1\n", 3, "found 1 (separated by tabs, the lines before by commas): 1\\t0\\t1"),
        ("x,y,r\n0,0,1\n1 0 1\n", 3, "found 1 (separated by blanks, the lines before by commas): 1 0 1"),
        ("x,y,r\n0,0,1\n1;0;1\n", 3, "found 1 (separated by semicolons, the lines before by commas)"),
        // An empty cell between tabs is kept, so that the cells after it do not shift.
        ("x\ty\tnote\tr\n0\t0\tok\t1\n1\t\t7\t3\t1\n", 3, "expected 4 fields, found 5"),
        ("x\ty\tr\n0\t0\t1\n1\t\t1\n", 3, "column y"),
        ("x y r\n0 0 1\n1,0,1\n", 3, "found 1 (separated by commas, the lines before by blanks or tabs)"),
        ("x y r\n0 0 1\n1, 0, 1\n", 3, "column x (separated by commas, the lines before by blanks or tabs)"),
        ("x;y;r\n0;0;1\n1,0,1\n", 3, "found 1 (separated by commas, the lines before by semicolons)"),
        (
            "x y r\n0 0 1\n0,5;0;1\n",
            3,
            "found 1 (separated by semicolons, the lines before by blanks or tabs)",
        ),
    ] {
        let error = error(text);
        assert_eq!(error.line(), Some(line), "{text:?}: {error}");
        assert!(error.to_string().contains(message), "{text:?}: {error}");
        assert!(!error.to_string().contains("decimal"), "{text:?}: {error}");
    }
}

#[test]
fn commas_and_blanks_in_numbers() {
    let decimal = "looks like a decimal comma: use a point";
    let either = "looks like a decimal comma or thousands separator: use a point before decimals";
    let thousands = "looks like a thousands separator: write the digits without it";
    for (text, message) in [
        ("x,y,r\n1 000,2 000,1\n", format!("'1 000' in column x {thousands}")),
        ("1 000,2 000,1\n", format!("'1 000' {thousands}")),
        ("x,y,r\n1 500,2 500,1\n", format!("'1 500' in column x {either}")),
        ("x;y;r\n1,000;2,000;1\n", format!("'1,000' in column x {either}")),
        ("1,000;2,000;1\n", format!("'1,000' {either}")),
        ("x;y;r\n0;1,000,000;1\n", format!("'1,000,000' in column y {thousands}")),
        ("x;y;r\n0;1,25;1\n", format!("'1,25' in column y {decimal}")),
        ("x,y,r\n0,0,1\n0,5 0,2 0,1\n", format!("expected 3 fields, found 4 ({decimal})")),
        ("x,y,r\n0,0,1\n0,5;0,2;0,1\n", format!("expected 3 fields, found 4 ({decimal})")),
        ("x y r\n0 0 1\n1,0,1 2\n", "expected 3 fields, found 2: 1,0,1 2".into()),
    ] {
        let error = error(text).to_string();
        assert!(error.contains(&message), "{text:?}: {error}");
    }
}

#[test]
fn lone_carriage_returns_do_not_join_lines() {
    for (text, line) in [
        ("x y r\n1 2 3\n1 0\r1\n4 5 6\n", 3),
        ("x y r\n# c\r1 0 1\n1 2 3\n", 2),
        ("# c\r1 0 1\n1 2 3\n", 1),
        ("x y\r1 2\n3 4\n5 6\n", 1),
    ] {
        let error = error(text);
        assert!(matches!(error, ReadError::Malformed { .. }), "{text:?}: {error:?}");
        assert_eq!(error.line(), Some(line), "{text:?}: {error}");
        assert!(error.to_string().contains("carriage return without line feed"), "{text:?}: {error}");
    }
    for text in ["x y\r1 2\r3 4\r\n", "x y\r1 2\r3 4\n"] {
        assert!(matches!(error(text), ReadError::Foreign { .. }), "{text:?}");
    }
    let skip = ReadOptions { skip_bad_lines: true, ..ReadOptions::default() };
    let packing = read(b"x y r\n1 2 3\n1 0\r1\n4 5 6\r\r\n", &skip, &AtomicU64::new(0)).unwrap();
    assert_eq!((packing.centres.len(), packing.source.skipped.count), (2, 1));
}

/// A file without line ends: nothing as long as the file is copied for names.
#[test]
fn a_line_as_long_as_a_file_is_no_header() {
    for text in ["1".repeat(2_000_000), format!("# {}\n{}", "a".repeat(2_000_000), "1".repeat(2_000_000))] {
        let error = error(&text);
        assert!(matches!(error, ReadError::Malformed { .. }), "{error:?}");
        let told = error.to_string();
        assert!(told.contains("the line has 2000000 bytes") && told.len() < 300, "{told}");
    }
}

#[test]
fn millions_of_columns_are_no_table() {
    let wide = "1,".repeat(3_000_000);
    for text in [wide.clone(), format!("# c\n{wide}\n{wide}\n"), "x ".repeat(10_001)] {
        let error = error(&text);
        assert!(matches!(error, ReadError::TooManyColumns { .. }), "{error:?}");
        assert!(error.to_string().contains("more than 10000 columns"), "{error}");
    }
    assert_eq!(error(&format!("# c\n{wide}\n")).line(), Some(2));
    let error = error(&format!("x,y\n0,0\n{wide}\n"));
    assert!(error.to_string().contains("expected 2 fields, found 3000001"), "{error}");
    let widest = format!("x,y{}\n0,0{}\n", ",v".repeat(9_998), ",1".repeat(9_998));
    assert!(read(widest.as_bytes(), &ReadOptions::default(), &AtomicU64::new(0)).is_ok());
}

#[test]
fn long_lines_are_shortened() {
    let ReadError::Malformed { text, .. } = error(&format!("x y\n1 {}\n", "9x".repeat(10_000))) else {
        panic!("not malformed")
    };
    assert_eq!(text.chars().count(), 81);
}

#[test]
fn headers_that_do_not_serve() {
    for (text, line, message) in [
        ("a,b,c\n1,2,3\n", 1, "no column for x; the columns are: a, b, c"),
        ("\n# c\nx,z\n1,2\n", 3, "no column for y; the columns are: x, z"),
        ("x,y,PosX\n1,2,3\n", 1, "columns x (x) and PosX (x) clash"),
        ("x,y,r,d\n1,2,3,6\n", 1, "columns r (radius) and d (diameter) clash"),
        ("x[mm],y[mm],radius[m]\n1,2,3\n", 1, "column x[mm] is in mm, column radius[m] in m: convert"),
        ("# x(mm) y(m)\n1 2\n", 1, "convert to one unit"),
        ("a\u{1b}[31m,b\n", 1, "the columns are: a\\u{1b}[31m, b"),
        ("1\n2\n", 1, "1 column and no header"),
        (
            "My packing\nx,y,r\n1,2,3\n",
            1,
            "the columns are: My, packing. Say which it is with --columns; or is this line a title? remove it or put # before it",
        ),
        ("1 2 3 4 5\n", 1, "First row: 1 2 3 4 5"),
        ("glass 1 2 3 0.5\n", 1, "5 columns and no header"),
    ] {
        let error = error(text);
        assert_eq!(error.line(), Some(line), "{text:?}: {error}");
        assert!(error.to_string().contains(message), "{text:?}: {error}");
    }
    assert!(!error("a,z\n1,2\n").to_string().contains("title"), "z is known: the line is a header");
    let columns =
        |columns: &str| ReadOptions { columns: Some(columns.parse().unwrap()), ..ReadOptions::default() };
    for (text, chosen, message) in [
        ("x,y,r\n1,2,3\n", "x=PosX,y=y", "no column 'PosX'; the columns are: x, y, r"),
        ("1 2 3\n", "x=PosX,y=2", "no column 'PosX'; the columns are: 1, 2, 3"),
        ("1 2 3\n", "x=1,y=4", "no column '4'"),
        ("a,b\n1,2\n", "x=a,y=1", "--columns makes column a both x and y: give one of them another"),
        ("1 2 3\n", "x,y", "--columns lists 2 columns, found 3: use _"),
        ("a[m],A[mm],b\n1,2,3\n", "x=a,y=b", "'a' could be any of the columns a[m] (1), A[mm] (2)"),
    ] {
        let error = fails(text, &columns(chosen));
        assert_eq!(error.line(), Some(1), "{text:?} {chosen}: {error}");
        assert!(error.to_string().contains(message), "{text:?} {chosen}: {error}");
    }
}

#[test]
fn columns_that_hold_no_bodies() {
    for (text, column, line, message) in [
        ("x,y,b\n1,2,3\n1,2,0.5\n", "b", 3, "the body '0.5' in column b is not a whole number: 1,2,0.5"),
        ("1 2 3\n1 2 1e16\n", "3", 2, "the body 1e16 in column 3 is beyond 2^53"),
        ("x,y,b\n1,2,3\n", "clump", 1, "no column 'clump'; the columns are: x, y, b"),
        ("x,y,b\n1,2,3\n", "y", 1, "--bodies y: this column is the y of the elements"),
        (
            "x,y,id\n1,2,3\n",
            "3",
            1,
            "--bodies id: this column is the id of the elements. If it is not, --ignore-ids",
        ),
        ("1 2 3 4 5 6\n", "6", 1, "5 columns and no header"),
    ] {
        let error = fails(text, &ReadOptions { bodies: Some(column.to_owned()), ..ReadOptions::default() });
        assert_eq!(error.line(), Some(line), "{text:?} {column}: {error}");
        assert!(error.to_string().contains(message), "{text:?} {column}: {error}");
    }
}

#[test]
fn ids_that_repeat() {
    let error = error("id,x,y\n5,0,0\n# c\n7,0,0\n5,0,0\n7,0,0\n");
    assert_eq!(error, ReadError::DuplicateId { id: 5, first: 2, second: 5 });
    assert_eq!(error.line(), Some(5));
    assert!(error.to_string().contains("--ignore-ids"));
}

#[test]
fn nothing_to_read() {
    assert_eq!(error(""), ReadError::Empty);
    assert_eq!(error("# a\n\n  \n# b"), ReadError::NoRows { lines: 4 });
    assert_eq!(error("\u{feff}\n"), ReadError::NoRows { lines: 1 });
    assert_eq!(
        error("\n").to_string(),
        "only comments and blank lines (1 line): expected one element per row"
    );
    assert_eq!(error("\u{feff}"), ReadError::Empty);
    assert_eq!(error("%\n% x y\n"), ReadError::NoRows { lines: 2 });
    let skip = ReadOptions { skip_bad_lines: true, ..ReadOptions::default() };
    let error = fails("x,y\n1,a\n2\n", &skip);
    assert!(matches!(error, ReadError::AllBad { count: 2, line: Some(2), .. }), "{error:?}");
    assert!(error.to_string().starts_with("none of the 2 rows can be read; the first: cannot"), "{error}");
    let error = fails("x,y\n1,a\n", &skip).to_string();
    assert!(error.starts_with("none of the rows can be read; the only one: cannot"), "{error}");
}

#[test]
fn files_that_are_no_text() {
    for (bytes, message) in [
        (b"\x1f\x8b\x08".as_slice(), "gzip"),
        (b"\x28\xb5\x2f\xfd", "zstd"),
        (b"PK\x03\x04", "zip archive"),
        (b"%PDF-1.7\n", "PDF"),
        (b"\xff\xfex\x00", "UTF-16"),
        (b"\xfe\xff\x00x", "UTF-16"),
        (b"\xff\xfe\x00\x00x\x00\x00\x00", "UTF-32"),
        (b"\x00\x00\xfe\xff\x00\x00\x00x", "UTF-32"),
        (b"\x89HDF\r\n", "HDF5"),
        (b"# vtk DataFile Version 3.0\n", "VTK"),
        (b"ITEM: TIMESTEP\n0\n", "LAMMPS"),
        (b"x y\r1 2\r3 4\r", "carriage returns"),
    ] {
        let error = fails(bytes, &ReadOptions::default());
        assert!(matches!(error, ReadError::Foreign { .. }), "{error:?}");
        assert!(error.to_string().contains(message), "{error}");
    }
    for (bytes, line, offset) in [
        (b"x y\n1 2\n\x00\x00".as_slice(), 3, 8),
        (b"x y\n1 2\nabc\xb5\n", 3, 11),
        (b"\x00\xff", 1, 0),
        (b"\x01\x02\x03\x04\x05\x06\x07\x08\x0e\x0f", 1, 0),
    ] {
        match fails(bytes, &ReadOptions::default()) {
            ReadError::NotText { line: l, offset: o, .. } => assert_eq!((l, o), (line, offset)),
            error => panic!("{error:?}"),
        }
    }
    let error = fails(b"x[\xb5m],y\n1,2\n", &ReadOptions::default()).to_string();
    assert!(error.contains("0xB5, which is not UTF-8, at byte 2: "), "{error}");
    assert!(error.contains("save it as UTF-8"), "{error}");
    let error = fails(b"ab\xb5\x00", &ReadOptions::default()).to_string();
    assert!(!error.contains("save"), "{error}");
}

/// A NumPy file with this header.
fn npy(descr: &str, order: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let text = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend(data);
    bytes
}

fn floats(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

#[test]
fn arrays_that_do_not_serve() {
    let huge = "(18446744073709551615, 4)";
    let cases: [(Vec<u8>, &str); 20] = [
        (b"\x93NUMPY".to_vec(), "NumPy header: the file ends inside the header"),
        (npy("'<f8'", "None", "(1, 2)", &floats(&[0.0; 2])), "NumPy header"),
        (
            npy("'<c8'", "False", "(1, 2)", &floats(&[0.0; 2])),
            "the array of shape (1, 2) is <c8: expected float16, float32, float64 or an integer",
        ),
        (npy("'<f16'", "False", "(1, 2)", &[0; 32]), "is <f16"),
        (npy("'<f8'", "False", "(2,)", &floats(&[0.0; 2])), "shape (2,), dtype <f8: expected (n, 2)"),
        (npy("'<f8'", "False", "(1, 1, 2)", &floats(&[0.0; 2])), "shape (1, 1, 2)"),
        (npy("'<f8'", "False", "()", &floats(&[0.0])), "shape ()"),
        (npy("'<f8'", "False", "(1, 5)", &floats(&[0.0; 5])), "5 columns and no header"),
        (npy("'<f8'", "False", "(2, 0)", &[]), "shape (2, 0)"),
        (
            npy("'<f8'", "False", "(2, 2)", &floats(&[0.0; 3])),
            "should take 32 bytes (shape (2, 2)), found 24",
        ),
        (
            npy("'<f8'", "False", "(1, 2)", &floats(&[0.0; 3])),
            "should take 16 bytes (shape (1, 2)), found 24: the file continues after the array",
        ),
        (npy("'|u1'", "False", "(1, 1)", &[]), "1 column and no header"),
        (npy("[]", "False", "(0,)", &[]), "the dtype has no named fields"),
        (npy("[('', '|V8')]", "False", "(0,)", &[]), "the dtype has no named fields"),
        (npy("'<f8'", "False", huge, &floats(&[0.0; 4])), "cut off"),
        (npy("'<f8'", "True", huge, &floats(&[0.0; 4])), "cut off"),
        (npy("[('x', '<f8'), ('y', '<f8')]", "False", "(1, 1)", &floats(&[0.0; 2])), "shape (1, 1)"),
        (
            npy("[('x', '<f8'), ('v', '<f8')]", "False", "(1,)", &floats(&[0.0; 2])),
            "no column for y; the columns are: x, v",
        ),
        (
            npy("[('x', '<f8'), ('y', '<M8')]", "False", "(1,)", &floats(&[0.0; 2])),
            "field y of the array of shape (1,) is <M8",
        ),
        (npy("[('x', '<f8'), ('y', '<f8', (99,))]", "False", "(0,)", &[]), "field y"),
    ];
    for (bytes, message) in cases {
        let error = fails(bytes, &ReadOptions::default());
        assert!(error.to_string().contains(message), "{error} does not say {message}");
        assert_eq!(error.line(), None);
    }
}

#[test]
fn rows_of_an_array_that_cannot_be_read() {
    let bytes = npy("'<f8'", "False", "(2, 4)", &floats(&[0.0, 0.0, 0.0, 1.0, 0.0, f64::NAN, 0.0, 1.0]));
    let error = fails(bytes, &ReadOptions::default());
    assert!(matches!(error, ReadError::BadRow { row: 1, .. }), "{error:?}");
    assert!(error.to_string().contains("row 1 (counted from 0): y (column 2) is NaN"), "{error}");

    let bytes = npy("'<f8'", "False", "(1, 4)", &floats(&[0.0, 0.0, 0.0, -1.0]));
    let error = fails(&bytes, &ReadOptions::default());
    assert!(error.to_string().contains("the radius -1"), "{error}");
    let error = fails(&bytes, &ReadOptions { skip_bad_lines: true, ..ReadOptions::default() });
    assert!(matches!(error, ReadError::AllBad { count: 1, line: None, .. }), "{error:?}");

    let data: Vec<u8> = [0, (1_i64 << 53) + 1].iter().flat_map(|value| value.to_le_bytes()).collect();
    let error = fails(npy("'<i8'", "False", "(1, 2)", &data), &ReadOptions::default());
    let message = "y (column 2) is 9007199254740993, which a 64-bit float cannot hold exactly";
    assert!(error.to_string().contains(message), "{error}");

    let row = floats(&[0.0, 0.0]);
    let data: Vec<u8> =
        [5_i64, 6, 5].iter().flat_map(|id| [id.to_le_bytes().to_vec(), row.clone()].concat()).collect();
    let bytes = npy("[('id', '<i8'), ('x', '<f8'), ('y', '<f8')]", "False", "(3,)", &data);
    let error = fails(bytes, &ReadOptions::default());
    assert_eq!(error, ReadError::DuplicateIdRow { id: 5, first: 0, second: 2 });
}

#[test]
fn a_missing_role_is_carried_by_the_error() {
    let ReadError::MissingColumn { role, present, title, .. } = error("a,y\n1,2\n") else {
        panic!("not missing")
    };
    assert_eq!(role, Role::X);
    assert!(!title);
    assert_eq!(present, ["a", "y"]);
}
