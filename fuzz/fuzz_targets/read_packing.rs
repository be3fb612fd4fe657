//! Any bytes are read or refused without a panic; a packing that is read has the documented properties of
//! `Packing`.

#![no_main]

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU64, Ordering};

use fdem_io::{Centres, Packing, ReadOptions, Skipped, TypeColumn, read, write_packing_csv, write_packing_npy};
use libfuzzer_sys::fuzz_target;

/// Values of `--columns`; the first means no option.
const COLUMNS: [&str; 8] = [
    "",
    "x,y",
    "x,y,z",
    "x,y,z,radius",
    "_,x,y,r",
    "id,x,y,diameter",
    "x=1,y=2,radius=3",
    "x=a,y=b,z=c,id=d",
];

fuzz_target!(|bytes: &[u8]| {
    let Some((&first, file)) = bytes.split_first() else { return };
    let options = ReadOptions {
        columns: COLUMNS[usize::from(first % 8)].parse().ok(),
        skip_bad_lines: first & 8 != 0,
        ignore_ids: first & 16 != 0,
        bodies: ["3", "b"].get(usize::from(first >> 5)).map(|column| column.to_string()),
        types: (first >> 5 == 2).then_some(TypeColumn::Usual),
    };
    let progress = AtomicU64::new(0);
    match read(file, &options, &progress) {
        Ok(packing) => {
            assert_eq!(progress.load(Ordering::Relaxed), file.len() as u64);
            check(&packing, &options);
            check_round_trip(&packing);
        }
        // Every error can be printed.
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});

fn check(packing: &Packing, options: &ReadOptions) {
    let n = packing.centres.len();
    match &packing.centres {
        Centres::Two(centres) => assert!(centres.as_flattened().iter().all(|x| x.is_finite())),
        Centres::Three(centres) => assert!(centres.as_flattened().iter().all(|x| x.is_finite())),
    }
    if let Some(radii) = &packing.radii {
        assert_eq!(radii.len(), n);
        assert!(radii.iter().all(|&radius| radius.is_finite() && radius >= 0.0));
    }
    if let Some(ids) = &packing.ids {
        assert!(!options.ignore_ids);
        assert_eq!(ids.len(), n);
        assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), n, "ids repeat");
    }
    assert_eq!(packing.bodies.as_ref().map(Vec::len), options.bodies.as_ref().map(|_| n));
    let skipped = &packing.source.skipped;
    assert_eq!(packing.row_numbers.is_some(), skipped.count > 0);
    if let Some(rows) = &packing.row_numbers {
        assert_eq!(rows.len(), n);
        assert!(rows.is_sorted_by(|a, b| a < b), "row numbers do not increase");
        assert!(rows.last().is_none_or(|&last| last < n as u64 + skipped.count));
    }
    assert!(options.skip_bad_lines || skipped.count == 0);
    assert_eq!(skipped.first.len() as u64, skipped.count.min(Skipped::KEPT as u64));
    assert!(n as u64 + skipped.count <= packing.source.lines);
}

/// A written packing reads back bit for bit.
fn check_round_trip(packing: &Packing) {
    let radii = packing.radii.as_deref();
    let (mut csv, mut npy) = (Vec::new(), Vec::new());
    write_packing_csv(&mut csv, &packing.centres, radii).expect("a vector takes all");
    write_packing_npy(&mut npy, &packing.centres, radii).expect("a vector takes all");
    for bytes in [csv, npy] {
        let again = read(&bytes, &ReadOptions::default(), &AtomicU64::new(0)).expect("our own format");
        assert_eq!(bits(&again), bits(packing));
    }
}

fn bits(packing: &Packing) -> (Vec<u64>, Option<Vec<u64>>) {
    let bits = |numbers: &[f64]| numbers.iter().map(|x| x.to_bits()).collect();
    let centres = match &packing.centres {
        Centres::Two(centres) => bits(centres.as_flattened()),
        Centres::Three(centres) => bits(centres.as_flattened()),
    };
    (centres, packing.radii.as_deref().map(bits))
}
