//! No bytes cause a panic; written files read back bit for bit.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail like tests")]

use std::fmt::Write as _;
use std::sync::atomic::AtomicU64;

use fdem_io::{
    Centres, Packing, ReadError, ReadOptions, Table, TypeColumn, Values, read, write_csv, write_packing_csv,
    write_packing_npy,
};
use proptest::prelude::*;

fn all_options() -> Vec<ReadOptions> {
    let mut all = Vec::new();
    for columns in [None, Some("radius,x,y,z"), Some("x=PosX[m],y=2,id=1"), Some("x=3,y=1")] {
        for flags in 0..16 {
            all.push(ReadOptions {
                columns: columns.map(|columns| columns.parse().unwrap()),
                skip_bad_lines: flags & 1 > 0,
                ignore_ids: flags & 2 > 0,
                bodies: (flags & 4 > 0).then(|| "4".to_owned()),
                types: (flags & 8 > 0).then(|| TypeColumn::Named("5".to_owned())),
            });
        }
    }
    all
}

/// Reads in every way and checks the properties of any result.
fn read_every_way(bytes: &[u8]) {
    for options in all_options() {
        match read(bytes, &options, &AtomicU64::new(0)) {
            Ok(packing) => check(&packing, &options),
            Err(error) => {
                let text = error.to_string();
                assert!(!text.contains(char::is_control), "{text:?}");
                assert!(text.len() < 2000, "{text}");
                assert!(error.line().is_none_or(|line| line > 0), "{text}");
            }
        }
    }
}

fn check(packing: &Packing, options: &ReadOptions) {
    let n = packing.centres.len();
    let flat: Vec<f64> = match &packing.centres {
        Centres::Two(centres) => centres.iter().flatten().copied().collect(),
        Centres::Three(centres) => centres.iter().flatten().copied().collect(),
    };
    assert!(flat.iter().all(|value| value.is_finite()));
    if let Some(radii) = &packing.radii {
        assert_eq!(radii.len(), n);
        assert!(radii.iter().all(|radius| radius.is_finite() && *radius >= 0.0));
    }
    if let Some(ids) = &packing.ids {
        let mut sorted = ids.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), n, "ids repeat");
        assert!(!options.ignore_ids);
    }
    assert_eq!(packing.bodies.as_ref().map(Vec::len), options.bodies.as_ref().map(|_| n));
    assert!(options.skip_bad_lines || packing.source.skipped.count == 0);
    assert_eq!(packing.row_numbers.is_some(), packing.source.skipped.count > 0);
    if let Some(numbers) = &packing.row_numbers {
        assert_eq!(numbers.len(), n);
        assert!(numbers.is_sorted_by(|a, b| a < b));
        assert!(numbers.last().is_none_or(|last| *last < n as u64 + packing.source.skipped.count));
    }
    assert!(packing.source.lines >= n as u64 + packing.source.skipped.count);
}

fn float() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>().prop_filter("finite", |value| value.is_finite()),
        (-1000_i32..1000).prop_map(|k| f64::from(k) / 1024.0),
    ]
}

fn spheres() -> impl Strategy<Value = (Centres, Option<Vec<f64>>)> {
    let three = prop::collection::vec([float(), float(), float()], 0..20).prop_map(Centres::Three);
    let two = prop::collection::vec([float(), float()], 0..20).prop_map(Centres::Two);
    prop_oneof![three, two].prop_flat_map(|centres| {
        let radii = prop::collection::vec(float().prop_map(f64::abs), centres.len());
        (Just(centres), prop::option::of(radii))
    })
}

fn bits(centres: &Centres) -> Vec<u64> {
    match centres {
        Centres::Two(centres) => centres.iter().flatten().map(|value| value.to_bits()).collect(),
        Centres::Three(centres) => centres.iter().flatten().map(|value| value.to_bits()).collect(),
    }
}

const GOOD: [&[u8]; 9] = [
    b"sep=;\nx_mm;y mm;r_in\n1;2;3\n",
    b"\x93NUMPY\x01\x00\x4e\x00{'descr': [('x','>i4'),('y','|u1')], 'fortran_order': True, 'shape': (1,)}   \n\0\0\0\0\0",
    b"Radius[m]\tPosX[m] PosY[m] PosZ[m]\r\n 0.001 -0.039 0.008 -0.080\r\n 0.002 1e-3 2 3\r\n\r\n",
    b"id,PosX[m],\"y\",z,d\n1,0.5,0.25,1,2\n7.0,1,1,1,.5 # c\n",
    b"# a\n# x y z r\n1 2 3 4\n5 6 7 8\n",
    b"1;2;3\n4;5;6\n",
    b"\xef\xbb\xbfX (mm) Y (mm)\n1 2\n",
    b"\x93NUMPY\x01\x00\x3a\x00{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2)}\n\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\0\x40",
    b"\x93NUMPY\x01\x00\x4e\x00{'descr': [('x','>f4'),('y','<f4')], 'fortran_order': True, 'shape': (1,)}   \n\0\0\0\0\0\0\0\0",
];

#[test]
fn the_files_that_are_mutated_are_good() {
    for bytes in GOOD {
        let packing = read(bytes, &ReadOptions::default(), &AtomicU64::new(0));
        assert!(packing.is_ok(), "{}: {packing:?}", String::from_utf8_lossy(bytes));
        read_every_way(bytes);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_bytes_do_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        read_every_way(&bytes);
    }

    /// Bytes with a meaning, so that more of the reader is reached than the check for text.
    #[test]
    fn arbitrary_text_does_not_panic(text in "[-+0-9.eExyzrid#%\", \t;\\[\\](=_\r\n]{0,120}") {
        read_every_way(text.as_bytes());
    }

    #[test]
    fn arbitrary_numpy_headers_do_not_panic(
        version in 0_u8..5,
        text in "(\\{'(descr|shape)': )?[\\[\\](){}',:<>|=0-9fiVUTrueFalsdcp\\\\ ]{0,80}",
        data in prop::collection::vec(any::<u8>(), 0..40),
    ) {
        let mut bytes = b"\x93NUMPY".to_vec();
        bytes.extend([version, 0]);
        bytes.extend((text.len() as u16).to_le_bytes());
        if version > 1 {
            bytes.extend([0, 0]);
        }
        bytes.extend(text.as_bytes());
        bytes.extend(data);
        read_every_way(&bytes);
    }

    /// Valid headers with arbitrary sizes: products overflow, offsets exceed the file.
    #[test]
    fn arbitrary_numpy_sizes_do_not_panic(
        kind in "[fiuVUS]",
        size in prop_oneof![0_u64..20, any::<u64>()],
        shape in prop::collection::vec(prop_oneof![0_u64..6, any::<u64>()], 0..4),
        inner in prop::collection::vec(prop_oneof![0_u64..6, any::<u64>()], 0..3),
        fortran in any::<bool>(),
        record in any::<bool>(),
        data in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let list = |lengths: &[u64]| lengths.iter().fold(String::new(), |list, length| list + &length.to_string() + ",");
        let scalar = format!("'<{kind}{size}'");
        let inner = list(&inner);
        let descr = if record {
            format!("[('x', '<f8'), ('v', {scalar}, ({inner})), ('y', '<f4'), ('position', {scalar}, ({inner}))]")
        } else {
            scalar
        };
        let order = if fortran { "True" } else { "False" };
        let text = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': ({})}}\n", list(&shape));
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.as_bytes());
        bytes.extend(data);
        read_every_way(&bytes);
    }

    #[test]
    fn damaged_good_files_do_not_panic(
        which in 0..GOOD.len(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3), 1..6),
    ) {
        let mut bytes = GOOD[which].to_vec();
        for (place, byte, change) in changes {
            if bytes.is_empty() {
                break;
            }
            let place = place.index(bytes.len());
            match change {
                0 => bytes[place] = byte,
                1 => bytes.insert(place, byte),
                _ => drop(bytes.drain(place..)),
            }
        }
        read_every_way(&bytes);
    }

    #[test]
    fn packings_read_back_bit_for_bit((centres, radii) in spheres()) {
        for text in [true, false] {
            let mut bytes = Vec::new();
            if text {
                write_packing_csv(&mut bytes, &centres, radii.as_deref()).unwrap();
            } else {
                write_packing_npy(&mut bytes, &centres, radii.as_deref()).unwrap();
            }
            let packing = read(&bytes, &ReadOptions::default(), &AtomicU64::new(0)).unwrap();
            prop_assert_eq!(packing.centres.dimensions(), centres.dimensions());
            prop_assert_eq!(bits(&packing.centres), bits(&centres));
            prop_assert_eq!(&packing.radii, &radii);
        }
    }

    /// Quoted fields take the careful parser, bare ones the fast parser.
    #[test]
    fn the_fast_way_agrees_with_the_careful_way(
        rows in prop::collection::vec((any::<i64>(), float(), float(), any::<i64>()), 1..10),
    ) {
        let [mut bare, mut quoted] = ["id,x,y,b\n".to_owned(), "id,x,y,b\n".to_owned()];
        for (id, x, y, body) in rows {
            writeln!(bare, "{id},{x},{y:e},{body}").unwrap();
            writeln!(quoted, "\"{id}\",\"{x}\",\"{y:e}\",\"{body}\"").unwrap();
        }
        let options = ReadOptions { bodies: Some("b".to_owned()), ..ReadOptions::default() };
        let read = |text: &str| read(text.as_bytes(), &options, &AtomicU64::new(0));
        prop_assert_eq!(read(&bare), read(&quoted));
    }

    /// Skipping bad lines gives the same as the file without them.
    #[test]
    fn skipping_is_deleting(
        rows in prop::collection::vec(prop_oneof![
            3 => (float(), float()).prop_map(|(x, y)| (true, format!("{x} {y}"))),
            1 => "[a-z]{1,3}|1 2 3|nan 0|0 1e999|0 0,5".prop_map(|line| (false, line)),
        ], 1..30),
    ) {
        let all: String = rows.iter().map(|(_, line)| line.clone() + "\n").collect();
        let kept: String = rows.iter().filter(|(good, _)| *good).map(|(_, line)| line.clone() + "\n").collect();
        let bad = rows.iter().filter(|(good, _)| !good).count() as u64;
        let skip = ReadOptions { skip_bad_lines: true, ..ReadOptions::default() };
        let read = |text: &str| read(format!("x y\n{text}").as_bytes(), &skip, &AtomicU64::new(0));
        match read(&all) {
            Ok(packing) => {
                prop_assert_eq!(packing.source.skipped.count, bad);
                prop_assert_eq!(packing.centres, read(&kept).unwrap().centres);
            }
            Err(error) => {
                prop_assert!(kept.is_empty());
                let all_bad = matches!(error, ReadError::AllBad { count, .. } if count == bad);
                prop_assert!(all_bad, "{error:?}");
            }
        }
    }

    #[test]
    fn couples_read_back_bit_for_bit(i in any::<i64>(), j in any::<i64>(), distance in float(), overlap in float()) {
        let mut out = Vec::new();
        let table = Table::new(1)
            .with("i", Values::i64(|_| i))
            .with("j", Values::i64(|_| j))
            .with("distance", Values::f64(|_| distance))
            .with("overlap", Values::f64(|_| overlap));
        write_csv(&mut out, &table).unwrap();
        let text = String::from_utf8(out).unwrap();
        let fields: Vec<_> = text.lines().nth(1).unwrap().split(',').collect();
        prop_assert_eq!(fields[0].parse::<i64>().unwrap(), i);
        prop_assert_eq!(fields[1].parse::<i64>().unwrap(), j);
        prop_assert_eq!(fields[2].parse::<f64>().unwrap().to_bits(), distance.to_bits());
        prop_assert_eq!(fields[3].parse::<f64>().unwrap().to_bits(), overlap.to_bits());
    }
}
