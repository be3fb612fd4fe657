//! Damaged files of every format are read or refused, without a panic.

use std::borrow::Cow;
use std::sync::atomic::AtomicU64;

use fdem_io::{Centres, FileKind, PackingFormat, ReadError, ReadOptions, Series, unpack};
use proptest::prelude::*;

use super::formats::{CENTRES, FILES, RADII, gzip, npz, vtu, zstd};

fn all() -> Vec<Vec<u8>> {
    let texts = FILES.iter().map(|(_, text)| text.as_bytes().to_vec());
    let twice =
        FILES.iter().filter(|(format, _)| format.has_frames()).map(|(_, text)| text.repeat(2).into_bytes());
    let packed = [gzip(FILES[2].1.as_bytes()), zstd(FILES[5].1.as_bytes())];
    let arrays = npz(&[("positions", &CENTRES.concat(), 3), ("radii", &RADII, 1)]);
    texts
        .chain(twice)
        .chain(vtu().into_iter().map(|(_, bytes)| bytes))
        .chain(packed)
        .chain([arrays])
        .collect()
}

/// Reads a file in several ways and checks the properties of any result.
fn read(bytes: &[u8]) {
    let (bytes, _) = match unpack(Cow::Borrowed(bytes), |_| true) {
        Ok(unpacked) => unpacked,
        Err(error) => return check_error(&error),
    };
    let _ = FileKind::of(&bytes, "a.vtu");
    for format in std::iter::once(None).chain(PackingFormat::ALL.map(Some)) {
        let series = match Series::open(&bytes, "a.dump", format) {
            Ok(series) => series,
            Err(error) => {
                check_error(&error);
                continue;
            }
        };
        assert!(series.frames() > 0);
        for (frame, options) in [
            (0, ReadOptions::default()),
            (
                series.frames() - 1,
                ReadOptions { skip_bad_lines: true, ignore_ids: true, ..ReadOptions::default() },
            ),
            (0, ReadOptions { columns: "_,x,y,z,radius".parse().ok(), ..ReadOptions::default() }),
            (
                0,
                ReadOptions {
                    columns: "x=1,y=2".parse().ok(),
                    bodies: Some("3".into()),
                    ..ReadOptions::default()
                },
            ),
        ] {
            let packing = match series.read(frame, &options, &AtomicU64::new(0)) {
                Ok(packing) => packing,
                Err(error) => {
                    check_error(&error);
                    continue;
                }
            };
            let n = packing.centres.len();
            match &packing.centres {
                Centres::Two(centres) => assert!(centres.as_flattened().iter().all(|x| x.is_finite())),
                Centres::Three(centres) => assert!(centres.as_flattened().iter().all(|x| x.is_finite())),
            }
            let radii = packing.radii.unwrap_or_default();
            assert!(radii.is_empty() || radii.len() == n);
            assert!(radii.iter().all(|&radius| radius.is_finite() && radius >= 0.0));
            assert!(packing.bodies.is_none_or(|bodies| bodies.len() == n));
            let cell = packing
                .cell
                .into_iter()
                .flat_map(|cell| [cell.origin, cell.edges[0], cell.edges[1], cell.edges[2]]);
            assert!(cell.flatten().all(f64::is_finite));
            assert_eq!(packing.frame.index, frame);
        }
    }
}

fn check_error(error: &ReadError) {
    let text = error.to_string();
    assert!(!text.contains(char::is_control), "{text:?}");
    assert!(text.len() < 3000, "{text}");
    assert!(error.line().is_none_or(|line| line > 0), "{text}");
}

#[test]
fn starts_of_every_file_are_read_or_refused() {
    for bytes in all() {
        // A step that is prime to the width of all columns.
        for end in (0..=bytes.len()).step_by(3) {
            read(&bytes[..end]);
        }
    }
}

/// Words with a meaning in some format.
const WORDS: [&str; 20] = [
    "18446744073709551615",
    "-1",
    "0",
    "nan",
    "1e400",
    "ITEM: ATOMS",
    "\n",
    "\r",
    " ",
    "\"",
    ":",
    "=",
    "0x",
    "\u{e9}",
    "#",
    "pp",
    "atoms",
    "Atoms",
    "<",
    "99999999",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 1024, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutants_are_read_or_refused(
        which in any::<prop::sample::Index>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0_u8..5, any::<u8>(), 0_usize..20), 1..4),
    ) {
        let mut files = all();
        let mut bytes = files.swap_remove(which.index(files.len()));
        for (at, kind, byte, length) in changes {
            let at = at.index(bytes.len() + 1);
            let end = (at + length).min(bytes.len());
            let part = bytes[at..end].to_vec();
            match kind {
                0 if at < bytes.len() => bytes[at] = byte,
                1 => drop(bytes.drain(at..end)),
                2 => drop(bytes.splice(at..at, part)),
                3 => drop(bytes.splice(at..end, WORDS[usize::from(byte) % WORDS.len()].bytes())),
                _ => drop(bytes.splice(at..at, WORDS[usize::from(byte) % WORDS.len()].bytes())),
            }
        }
        read(&bytes);
    }
}
