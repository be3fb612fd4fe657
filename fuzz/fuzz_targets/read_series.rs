//! Any bytes, compressed or not, are read as a series or refused without a panic; a packing that is read has
//! the documented properties of `Packing`.

#![no_main]

use std::sync::atomic::AtomicU64;

use fdem_io::{Centres, FileKind, PackingFormat, ReadOptions, Series, TypeColumn, unpack};
use libfuzzer_sys::fuzz_target;

/// Names for content that does not show its format.
const NAMES: [&str; 4] = ["a.dump", "a.data", "a.vtu", "a"];
/// More decompressed bytes would only take time.
const MOST: usize = 1 << 20;

fuzz_target!(|bytes: &[u8]| {
    let [first, second, file @ ..] = bytes else { return };
    let Ok((file, _)) = unpack(file.into(), |_| false) else { return };
    if file.len() > 2 * MOST {
        return;
    }
    let name = NAMES[usize::from(first % 4)];
    let _ = FileKind::of(&file, name);
    let format = PackingFormat::ALL.get(usize::from(first >> 2) % 16).copied();
    let series = match Series::open(&file, name, format) {
        Ok(series) => series,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let options = ReadOptions {
        columns: ["_,x,y,z,radius", "x=1,y=2", ""][usize::from(second % 3)].parse().ok(),
        skip_bad_lines: second & 8 != 0,
        ignore_ids: second & 16 != 0,
        bodies: (second & 32 != 0).then(|| "3".to_owned()),
        types: (second & 64 != 0).then_some(TypeColumn::Usual),
    };
    for frame in [0, series.frames() / 2, series.frames() - 1] {
        match series.read(frame, &options, &AtomicU64::new(0)) {
            Ok(packing) => {
                let n = packing.centres.len();
                let centres = match &packing.centres {
                    Centres::Two(centres) => centres.as_flattened(),
                    Centres::Three(centres) => centres.as_flattened(),
                };
                assert!(centres.iter().all(|x| x.is_finite()));
                assert!(packing.radii.is_none_or(|radii| radii.len() == n));
                assert!(packing.cell.is_none_or(|cell| cell.edges.as_flattened().iter().all(|x| x.is_finite())));
                assert_eq!(packing.frame.index, frame);
            }
            // Every error can be printed.
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
});
