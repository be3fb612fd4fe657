//! Files as users have them: delimiters, headers, units, ids, NumPy arrays, and the sample files.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail like tests")]

use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use fdem_io::{
    Centres, Columns, Delimiter, Format, Packing, ReadError, ReadOptions, Role, TypeColumn, Types, read,
};
use npyz::WriterBuilder as _;

fn with(bytes: &[u8], options: &ReadOptions) -> Packing {
    match read(bytes, options, &AtomicU64::new(0)) {
        Ok(packing) => packing,
        Err(error) => panic!("{error}\n{}", String::from_utf8_lossy(bytes)),
    }
}

fn plain(text: &str) -> Packing {
    with(text.as_bytes(), &ReadOptions::default())
}

fn chosen(text: &str, columns: &str) -> Packing {
    let columns: Columns = columns.parse().unwrap();
    with(text.as_bytes(), &ReadOptions { columns: Some(columns), ..ReadOptions::default() })
}

fn delimiter(packing: &Packing) -> Delimiter {
    match packing.source.format {
        Format::Text { delimiter } => delimiter,
        _ => panic!("not text"),
    }
}

fn roles(packing: &Packing) -> Vec<Option<Role>> {
    packing.source.columns.iter().map(|column| column.role).collect()
}

/// All notations of the same two spheres.
#[test]
fn spellings_of_one_packing() {
    use Delimiter::{Blank, Comma, Semicolon, Tab};
    for (text, expected) in [
        ("x,y,z,radius\n1,2,3,0.5\n-1,0,2.5,0\n", Comma),
        ("x , y,\tz , radius\n 1, 2 ,3 ,0.5\n-1,0,2.5,0", Comma),
        ("\"X\",\"Y\",\"Z\",\"R\"\r\n\"1\",\"2\",\"3\",\"0.5\"\r\n-1,0,2.5,0\r\n", Comma),
        ("Radius[m]\tPosX[m] PosY[m] PosZ[m]\r\n 0.5 1 2 3\r\n 0 -1 0 2.5\r\n\r\n", Blank),
        ("X (mm) Y (mm) Z ( mm ) Radius (mm)\n1 2 3 .5\n-1 0 25e-1 0\n", Blank),
        ("\"Pos X\" \"Pos Y\" \"Pos Z\" rad\n1 2 3 +0.5\n-1 0 2.5 0\n", Blank),
        ("Pos X\tPos Y\tPos Z\tRadius\n1\t2\t3\t0.5\n-1\t0\t2.5\t0\n", Tab),
        ("z;y;x;d\n3;2;1;1\n2.5;0;-1;0\n", Semicolon),
        ("\u{feff}x,y,z,r\n1,2,3,0.5\n-1,0,2.5,0\n", Comma),
        ("# made by hand\n\n# x y z radius\n1 2 3 0.5 # the first\n\n# the second\n-1 0 2.5 0\n", Blank),
        ("# radius, x, y, z\n0.5 1 2 3\n0 -1 0 2.5\n", Blank),
        ("#d,x,y,z\n1,1,2,3\n0,-1,0,2.5\n", Comma),
        ("1 2 3 0.5\n-1 0 2.5 0\n", Blank),
        ("x y z r\n1,2,3,0.5\n-1,0,2.5,0\n", Comma),
        ("x,y,z,r\n1 2 3 0.5\n-1 0 2.5 0\n", Blank),
        ("\t1\t2\t3\t0.5\n\t-1\t0\t2.5\t0\n", Blank),
        ("Points:0,Points:1,Points:2,velocity,Radius\n1,2,3,fast,0.5\n-1,0,2.5,,0\n", Comma),
    ] {
        let packing = plain(text);
        assert_eq!(packing.centres, Centres::Three(vec![[1.0, 2.0, 3.0], [-1.0, 0.0, 2.5]]), "{text:?}");
        assert_eq!(packing.radii, Some(vec![0.5, 0.0]), "{text:?}");
        assert_eq!(packing.ids, None, "{text:?}");
        assert_eq!(delimiter(&packing), expected, "{text:?}");
        assert_eq!(packing.source.lines, text.lines().count() as u64, "{text:?}");
        assert_eq!(packing.source.skipped.count, 0, "{text:?}");
    }
}

#[test]
fn without_z_the_packing_is_flat() {
    for text in ["0 1\n2 3\n", "x,y\n0,1\n2,3\n", "y,x\n1,0\n3,2\n", "# x y\n0 1\n2 3\n"] {
        let packing = plain(text);
        assert_eq!(packing.centres, Centres::Two(vec![[0.0, 1.0], [2.0, 3.0]]), "{text:?}");
        assert_eq!(packing.radii, None, "{text:?}");
    }
    assert_eq!(plain("0 1 2\n").centres, Centres::Three(vec![[0.0, 1.0, 2.0]]));
}

#[test]
fn a_header_without_rows_is_an_empty_packing() {
    let packing = plain("x,y,z,radius\n# nothing\n\n");
    assert_eq!(packing.centres, Centres::Three(vec![]));
    assert_eq!(packing.radii, Some(vec![]));
    assert!(packing.centres.is_empty());
    assert_eq!(plain("x y id").ids, Some(vec![]));
}

#[test]
fn units_and_columns_are_reported() {
    let packing = plain("id,mass[kg],PosX[mm],y (mm),Radius\n4,1,0,0,1\n");
    assert_eq!(packing.source.unit.as_deref(), Some("mm"));
    assert_eq!(roles(&packing), [Some(Role::Id), None, Some(Role::X), Some(Role::Y), Some(Role::Radius)]);
    let names: Vec<_> = packing.source.columns.iter().map(|column| column.name.as_str()).collect();
    assert_eq!(names, ["id", "mass[kg]", "PosX[mm]", "y (mm)", "Radius"]);
    assert_eq!(plain("x,y\n0,0\n").source.unit, None);
    let names: Vec<_> = plain("0 0\n").source.columns.into_iter().map(|column| column.name).collect();
    assert_eq!(names, ["column 1", "column 2"]);
    let array = with(&npy("<f8", &[1, 2], npyz::Order::C, &[0.0, 0.0]), &ReadOptions::default());
    let names: Vec<_> = array.source.columns.into_iter().map(|column| column.name).collect();
    assert_eq!(names, ["column 1", "column 2"]);
}

#[test]
fn units_need_no_brackets() {
    for text in [
        "x_mm,y_mm,radius_mm\n0,1,2\n",
        "X mm;Y mm;radius mm\n0;1;2\n",
        "x mm\ty mm\td mm\n0\t1\t4\n",
        "# pos_x_mm y_mm r_mm\n0 1 2\n",
    ] {
        let packing = plain(text);
        assert_eq!(packing.source.unit.as_deref(), Some("mm"), "{text:?}");
        assert_eq!(packing.centres, Centres::Two(vec![[0.0, 1.0]]), "{text:?}");
        assert_eq!(packing.radii, Some(vec![2.0]), "{text:?}");
    }
    let packing = plain("x,y,r_in,r_out\n0,0,1,2\n");
    assert_eq!((packing.radii, packing.source.unit), (None, None), "an inner radius is not one in inches");
    let packing = chosen("left_mm,top_mm,x\n1,2,3\n", "x=left,y=TOP_MM");
    assert_eq!(packing.centres, Centres::Two(vec![[1.0, 2.0]]));
    assert_eq!(packing.source.unit.as_deref(), Some("mm"));
}

#[test]
fn percent_signs_start_comments() {
    for text in ["% x y r\n1 2 3\n", "%% made by hand\n  % c\nx,y,r\n% c\n1,2,3\n%", "%radius,y,x\n3,2,1\n"] {
        let packing = plain(text);
        assert_eq!(packing.centres, Centres::Two(vec![[1.0, 2.0]]), "{text:?}");
        assert_eq!(packing.radii, Some(vec![3.0]), "{text:?}");
    }
}

#[test]
fn a_first_line_may_name_the_separator() {
    for (text, expected) in [
        ("sep=;\nx;y;r\n1;2;3\n", Delimiter::Semicolon),
        ("\u{feff}SEP=,\r\nx,y,r\r\n1,2,3\r\n", Delimiter::Comma),
        ("\"sep=;\"\nx;y;r\n1;2;3\n", Delimiter::Semicolon),
        ("sep=\t\nx\ty\tnote\tr\n1\t2\t\t3\n", Delimiter::Tab),
        ("sep= \nx y r\n1 2 3\n", Delimiter::Blank),
        ("sep=\nx y r\n1 2 3\n", Delimiter::Blank),
    ] {
        let packing = plain(text);
        assert_eq!(delimiter(&packing), expected, "{text:?}");
        assert_eq!(packing.centres, Centres::Two(vec![[1.0, 2.0]]), "{text:?}");
        assert_eq!(packing.radii, Some(vec![3.0]), "{text:?}");
        assert_eq!(packing.source.lines, 3, "{text:?}");
    }
}

#[test]
fn ids_are_exact() {
    let packing = plain("id x y\n9007199254740993 0 0\n7.000000e+00 0 0\n-3 0 0\n9223372036854775807 0 0\n");
    assert_eq!(packing.ids, Some(vec![9_007_199_254_740_993, 7, -3, i64::MAX]));
}

#[test]
fn ignored_ids_may_be_anything() {
    let options = ReadOptions { ignore_ids: true, ..ReadOptions::default() };
    let packing = with(b"id,x,y\n1,0,0\n1,1,0\nseven,2,0\n,3,0\n", &options);
    assert_eq!(packing.ids, None);
    assert_eq!(packing.centres.len(), 4);
    assert_eq!(roles(&packing), [None, Some(Role::X), Some(Role::Y)]);
}

#[test]
fn bodies_are_read_when_asked() {
    let bodies = |column: &str| ReadOptions { bodies: Some(column.to_owned()), ..ReadOptions::default() };
    assert_eq!(plain("x,y,body\n1,2,3\n").bodies, None);
    for (text, column) in [
        ("x,y,Body[-]\n1,2,-3\n4,5,9e3\n", "body"),
        ("x,y,Body\n1,2,-3\n4,5,9000\n", "3"),
        ("\"-3\",1,2\n+9000.0,4,5\n", "1"),
        ("body[kg] x[m] y[m]\n-3 1 2\n9000 4 5", "body"),
    ] {
        let packing = with(text.as_bytes(), &bodies(column));
        assert_eq!(packing.bodies, Some(vec![-3, 9000]), "{text}");
        assert_eq!(packing.centres, Centres::Two(vec![[1.0, 2.0], [4.0, 5.0]]), "{text}");
        assert!(roles(&packing).contains(&Some(Role::Body)), "{text}");
    }
    // Together with columns chosen by the user, and with a column of that name that is an id.
    let columns = Some("y,x,_".parse().unwrap());
    let packing = with(b"2 1 7\n5 4 7\n", &ReadOptions { columns, ..bodies("3") });
    assert_eq!((packing.bodies, packing.ids), (Some(vec![7, 7]), None));
    let packing = with(b"id,x,y\n7,0,0\n7,1,1\n", &ReadOptions { ignore_ids: true, ..bodies("id") });
    assert_eq!((packing.bodies, packing.ids), (Some(vec![7, 7]), None));
    let bytes = npy("<i2", &[2, 3], npyz::Order::Fortran, &[1_i16, 4, 2, 5, -3, 900]);
    assert_eq!(with(&bytes, &bodies("3")).bodies, Some(vec![-3, 900]));
}

#[test]
fn columns_chosen_by_place() {
    let packing = chosen("7 0.5 1 2 glass\n8 0.25 3 4 steel\n", "id,diameter,x,y,_");
    assert_eq!(packing.centres, Centres::Two(vec![[1.0, 2.0], [3.0, 4.0]]));
    assert_eq!(packing.radii, Some(vec![0.25, 0.125]));
    assert_eq!(packing.ids, Some(vec![7, 8]));
    let packing = chosen("Pos X Pos Y size\n1 2 3\n", "x,y,radius");
    assert_eq!(packing.centres, Centres::Two(vec![[1.0, 2.0]]), "blanks in names do not count as columns");
    let packing = chosen("x,y,z\n1,2,3\n", "z,x,y");
    assert_eq!(packing.centres, Centres::Three(vec![[2.0, 3.0, 1.0]]), "the choice overrules the header");
    let packing = chosen("glass 1 2\n", "_,x,y");
    assert_eq!(packing.centres, Centres::Two(vec![[1.0, 2.0]]), "text in a skipped column makes no header");
}

#[test]
fn columns_chosen_by_name_or_number() {
    let text = "x,y,PosX[m],PosY[m],size\n9,9,1,2,3\n";
    let packing = chosen(text, "x=PosX[m],y=posy,radius=5");
    assert_eq!(packing.centres, Centres::Two(vec![[1.0, 2.0]]));
    assert_eq!(packing.radii, Some(vec![3.0]));
    assert_eq!(chosen("1 2 3 4 5\n", "x=5,y=4").centres, Centres::Two(vec![[5.0, 4.0]]));
    let packing = chosen("# a b\n1 2\n", "x=b,y=a");
    assert_eq!(
        packing.centres,
        Centres::Two(vec![[2.0, 1.0]]),
        "names in a comment count when they are asked for"
    );
}

#[test]
fn bad_lines_are_left_out_when_asked() {
    let mut text = "x,y,r\n".to_owned();
    for i in 0..30 {
        writeln!(text, "{i},0,1\n{i},oops,1").unwrap();
    }
    let packing = with(text.as_bytes(), &ReadOptions { skip_bad_lines: true, ..ReadOptions::default() });
    assert_eq!(packing.centres, Centres::Two((0..30).map(|i| [f64::from(i), 0.0]).collect()));
    assert_eq!(packing.source.skipped.count, 30);
    assert_eq!(packing.source.skipped.first.len(), 20);
    assert_eq!(packing.source.skipped.first[1].line, 5);
    assert_eq!(packing.source.skipped.first[1].text, "1,oops,1");
    assert!(packing.source.skipped.first[1].problem.contains("'oops'"));
    assert_eq!(packing.source.format.noun(packing.source.skipped.count), "lines");
}

#[test]
fn elements_keep_the_numbers_of_their_rows() {
    let skip = ReadOptions { skip_bad_lines: true, ..ReadOptions::default() };
    let text = b"x y\n# c\n0 0\noops 0\n\n1 0\n2\n3 0\n";
    assert_eq!(with(text, &skip).row_numbers, Some(vec![0, 2, 4]));
    assert_eq!(with(b"x y\n0 0\n1 0\n", &skip).row_numbers, None, "nothing was skipped");
    let array = npy("<f8", &[3, 2], npyz::Order::C, &[f64::NAN, 0.0, 1.0, 1.0, 2.0, 2.0]);
    assert_eq!(with(&array, &skip).row_numbers, Some(vec![1, 2]));
}

#[test]
fn progress_reaches_the_end() {
    let progress = AtomicU64::new(u64::MAX);
    let text = "0 0\n".repeat(10_000);
    read(text.as_bytes(), &ReadOptions::default(), &progress).unwrap();
    assert_eq!(progress.load(Ordering::Relaxed), text.len() as u64);
    let bad = text.clone() + "x\n";
    read(bad.as_bytes(), &ReadOptions::default(), &progress).unwrap_err();
    let stopped = progress.load(Ordering::Relaxed);
    assert!((30_000..bad.len() as u64).contains(&stopped), "{stopped}: reported on the way, not at the end");
}

/// An array as another program would write it.
fn npy<T: npyz::Serialize>(dtype: &str, shape: &[u64], order: npyz::Order, values: &[T]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let dtype = npyz::DType::new_scalar(dtype.parse().unwrap());
    let options = npyz::WriteOptions::new().dtype(dtype).shape(shape).order(order).writer(&mut bytes);
    let mut writer = options.begin_nd().unwrap();
    writer.extend(values).unwrap();
    writer.finish().unwrap();
    bytes
}

#[test]
fn arrays_of_every_float_and_order() {
    use npyz::Order::{C, Fortran};
    let expected = Centres::Three(vec![[1.0, 2.0, 3.0], [-1.0, 0.5, 0.0]]);
    let by_row = [1.0, 2.0, 3.0, 0.25, -1.0, 0.5, 0.0, 0.0];
    let by_column = [1.0, -1.0, 2.0, 0.5, 3.0, 0.0, 0.25, 0.0];
    for (order, values) in [(C, by_row), (Fortran, by_column)] {
        for dtype in ["<f8", ">f8", "<f4", ">f4"] {
            let bytes = if dtype.ends_with('8') {
                npy(dtype, &[2, 4], order, &values)
            } else {
                npy(dtype, &[2, 4], order, &values.map(|value| value as f32))
            };
            let packing = with(&bytes, &ReadOptions::default());
            assert_eq!(packing.centres, expected, "{dtype} {order:?}");
            assert_eq!(packing.radii, Some(vec![0.25, 0.0]), "{dtype} {order:?}");
            assert_eq!(packing.source.format, Format::Npy { dtype: dtype.into() });
            assert_eq!(packing.source.lines, 2);
        }
    }
    let packing = with(&npy("<f4", &[1, 2], C, &[0.1_f32, 1e-45]), &ReadOptions::default());
    assert_eq!(
        packing.centres,
        Centres::Two(vec![[f64::from(0.1_f32), f64::from(1e-45_f32)]]),
        "widened exactly"
    );
    let packing = with(&npy::<f64>("<f8", &[0, 3], C, &[]), &ReadOptions::default());
    assert_eq!(packing.centres, Centres::Three(vec![]));
}

#[test]
fn arrays_with_chosen_columns() {
    let columns = Some("id,_,x,y,diameter".parse().unwrap());
    let bytes = npy("<f8", &[1, 5], npyz::Order::C, &[7.0, f64::NAN, 1.0, 2.0, 3.0]);
    let packing = with(&bytes, &ReadOptions { columns, ..ReadOptions::default() });
    assert_eq!(packing.centres, Centres::Two(vec![[1.0, 2.0]]));
    assert_eq!(packing.radii, Some(vec![1.5]));
    assert_eq!(packing.ids, Some(vec![7]));
}

/// A structured array with this descr and one row of `data`; the header is written as NumPy writes it.
fn record(descr: &str, rows: usize, data: &[u8]) -> Vec<u8> {
    let text = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': ({rows},), }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn types_are_read_when_asked() {
    let types = |column| ReadOptions { types: Some(column), ..ReadOptions::default() };
    let named = |column: &str| types(TypeColumn::Named(column.to_owned()));
    let found = |names: [&str; 2], of: [u32; 3]| {
        Some(Types { names: names.map(str::to_owned).to_vec(), of: of.to_vec() })
    };
    assert_eq!(plain("x,y,type\n1,2,H\n").types, None);
    let text = "x,y,type,Element\n1,2,7,\"C a\"\n3,4,8,H # b\n5,6,8,C a\n";
    let packing = with(text.as_bytes(), &types(TypeColumn::Usual));
    assert_eq!(packing.types, found(["C a", "H"], [0, 1, 0]));
    assert_eq!(roles(&packing), [Some(Role::X), Some(Role::Y), None, Some(Role::Type)]);
    assert_eq!(with(text.as_bytes(), &named("type")).types, found(["7", "8"], [0, 1, 1]));
    // A file without names, with a column of bodies.
    let packing =
        with(b"H 1 2 4\nC 1 3 4\nC 2 3 4\n", &ReadOptions { bodies: Some("2".into()), ..named("1") });
    assert_eq!((packing.types, packing.bodies), (found(["H", "C"], [0, 1, 1]), Some(vec![1, 1, 2])));
    assert_eq!(packing.centres, Centres::Two(vec![[2.0, 4.0], [3.0, 4.0], [3.0, 4.0]]));
    // Whole numbers of an array, plain or with named fields.
    let bytes = npy("<f8", &[3, 3], npyz::Order::C, &[0.0, 0.0, 2.0, 1.0, 1.0, -1.0, 2.0, 2.0, 2.0]);
    assert_eq!(with(&bytes, &named("3")).types, found(["2", "-1"], [0, 1, 0]));
    let error = read(&bytes, &types(TypeColumn::Usual), &AtomicU64::new(0)).unwrap_err().to_string();
    assert!(error.contains("no column element, species, type") && error.contains("1, 2, 3"), "{error}");
    let data: Vec<u8> = (0..3).flat_map(|k: u8| [k, k, u8::from(k == 1)]).collect();
    let bytes = record("[('type', '|u1'), ('x', '|u1'), ('y', '|u1')]", 3, &data);
    let packing = with(&bytes, &types(TypeColumn::Usual));
    assert_eq!(
        packing.types.map(|types| (types.names.join(" "), types.of)),
        Some(("0 1 2".into(), vec![0, 1, 2]))
    );
}

#[test]
fn arrays_with_named_fields() {
    let descr = "[('name', '<U2'), ('id', '>u2'), ('radius', '<f4'), ('', '|V3'), ('position', '>f8', (3,))]";
    let mut data = vec![0xff; 8];
    data.extend(513_u16.to_be_bytes());
    data.extend(0.5_f32.to_le_bytes());
    data.extend([0xff; 3]);
    data.extend([1.0_f64, 2.0, 3.0].iter().flat_map(|value| value.to_be_bytes()));
    let packing = with(&record(descr, 1, &data), &ReadOptions::default());
    assert_eq!(packing.centres, Centres::Three(vec![[1.0, 2.0, 3.0]]));
    assert_eq!(packing.radii, Some(vec![0.5]));
    assert_eq!(packing.ids, Some(vec![513]));
}

#[test]
fn bad_rows_of_an_array_are_left_out_when_asked() {
    let values = [0.0, 0.0, f64::INFINITY, 0.0, 2.0, 2.0];
    let bytes = npy("<f8", &[3, 2], npyz::Order::C, &values);
    let packing = with(&bytes, &ReadOptions { skip_bad_lines: true, ..ReadOptions::default() });
    assert_eq!(packing.centres, Centres::Two(vec![[0.0, 0.0], [2.0, 2.0]]));
    assert_eq!(packing.source.skipped.count, 1);
    assert_eq!(packing.source.skipped.first[0].line, 1);
    assert_eq!(packing.source.format.noun(1), "row");
}

#[test]
fn arrays_of_integers() {
    let bytes = npy("<i4", &[2, 3], npyz::Order::C, &[1_i32, 2, 3, -4, 5, 6]);
    let packing = with(&bytes, &ReadOptions::default());
    assert_eq!(packing.centres, Centres::Three(vec![[1.0, 2.0, 3.0], [-4.0, 5.0, 6.0]]));
    let bytes = npy("<i8", &[1, 2], npyz::Order::Fortran, &[1_i64 << 60, -7]);
    let packing = with(&bytes, &ReadOptions::default());
    assert_eq!(packing.centres, Centres::Two(vec![[1_152_921_504_606_846_976.0, -7.0]]));
    let packing =
        with(&record("[('x_mm', '|u1'), ('y_mm', '>i2')]", 1, &[200, 255, 254]), &ReadOptions::default());
    assert_eq!(packing.centres, Centres::Two(vec![[200.0, -2.0]]));
    assert_eq!(packing.source.unit.as_deref(), Some("mm"));
}

/// A file of the round robin data, or `None` with a note if the data are not available.
fn sample(path: &str) -> Option<Vec<u8>> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/roundrobin").join(path);
    match std::fs::read(&path) {
        Ok(bytes) => Some(bytes),
        Err(error) => {
            eprintln!("SKIPPED: {}: {error}", path.display());
            None
        }
    }
}

#[test]
fn sample_of_a_drum() {
    let Some(bytes) = sample("drum/PartCoordinates.txt") else { return };
    let packing = with(&bytes, &ReadOptions::default());
    assert_eq!(packing.centres.len(), 38_000);
    assert_eq!(packing.centres.dimensions(), 3);
    assert_eq!(packing.source.unit.as_deref(), Some("m"));
    let radii = packing.radii.unwrap();
    assert!(radii.iter().all(|radius| [0.001, 0.002].contains(radius)));
    let Centres::Three(centres) = packing.centres else { panic!("not 3D") };
    assert_eq!(centres[0], [-0.009_441_591_507, -0.020_774_941_75, -0.084_200_703_94]);
}

#[test]
fn sample_with_a_stray_last_line() {
    let Some(bytes) = sample("penetration/25KParticles.txt") else { return };
    let error = read(&bytes, &ReadOptions::default(), &AtomicU64::new(0)).unwrap_err();
    let problem = "expected 4 fields, found 6".to_owned();
    assert_eq!(error, ReadError::Malformed { line: 25_002, text: "5 0.01 0.01 0 0 0.06".into(), problem });
    let packing = with(&bytes, &ReadOptions { skip_bad_lines: true, ..ReadOptions::default() });
    assert_eq!(packing.centres.len(), 25_000);
    assert_eq!(packing.source.skipped.count, 1);
    assert_eq!(packing.source.lines, 25_003);
}
