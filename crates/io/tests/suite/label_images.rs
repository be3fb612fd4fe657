//! Labelled images: files of other programs give the same labels here, and damaged files are refused with the
//! reason.
//!
//! `labels/make.py` documents the content of the files.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;

use fdem_io::{LabelError, LabelImage, LabelKind, LabelValue, with_label_image};
use zip::write::SimpleFileOptions;

fn file(name: &str) -> Vec<u8> {
    fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/labels").join(name)).unwrap()
}

/// The shape, whether the axes are reversed, and the labels, read `most` planes at a time.
type Content = (Vec<usize>, bool, Vec<i128>);

fn all<L: LabelValue + Into<i128>>(image: &mut LabelImage<'_>, most: usize) -> Result<Content, LabelError> {
    let (mut slab, mut labels) = (Vec::<L>::new(), Vec::new());
    let mut planes = 0;
    loop {
        let read = image.read_planes(most, &mut slab)?;
        if read == 0 {
            break;
        }
        planes += read;
        labels.extend(slab.iter().map(|&label| label.into()));
    }
    assert_eq!(planes, image.shape()[0]);
    Ok((image.shape().to_vec(), image.reversed(), labels))
}

fn read(bytes: Vec<u8>, member: Option<&str>, most: usize) -> Result<(LabelKind, Content), LabelError> {
    with_label_image(Cursor::new(bytes), member, |image| {
        let kind = image.kind();
        let content = match kind {
            LabelKind::U8 => all::<u8>(image, most),
            LabelKind::U16 => all::<u16>(image, most),
            LabelKind::U32 => all::<u32>(image, most),
            LabelKind::U64 => all::<u64>(image, most),
            LabelKind::I32 => all::<i32>(image, most),
            LabelKind::I64 => all::<i64>(image, most),
        };
        content.map(|content| (kind, content))
    })
}

#[track_caller]
fn is_refused(bytes: Vec<u8>, member: Option<&str>, parts: &[&str]) {
    let error = match read(bytes, member, 1) {
        Ok(content) => panic!("read as {content:?}"),
        Err(error) => error.to_string(),
    };
    for part in parts {
        assert!(error.contains(part), "{part:?} is not in: {error}");
    }
}

#[test]
fn files_of_other_programs_are_read() {
    let numbers =
        |factor: i128, offset: i128| (0..60).map(|k| 2 * k * factor + offset).collect::<Vec<i128>>();
    let shape = vec![3, 4, 5];
    for most in [1, 2, 100] {
        for (name, member, kind, expected) in [
            ("plain.npy", None, LabelKind::U16, numbers(1, 0)),
            ("stored.npz", Some("labels"), LabelKind::U16, numbers(1, 0)),
            ("stored.npz", Some("labels.npy"), LabelKind::U16, numbers(1, 0)),
            ("deflated.npz", None, LabelKind::I32, numbers(1, 0)),
            ("stack.tif", None, LabelKind::U16, numbers(1, 0)),
            ("imagej.tif", None, LabelKind::U16, numbers(1, 0)),
            ("big_endian.tif", None, LabelKind::U32, numbers(500, 0)),
            ("lzw.tif", None, LabelKind::U16, numbers(1, 0)),
            ("packbits.tif", None, LabelKind::U8, numbers(1, 0)),
            ("signed.tif", None, LabelKind::I32, numbers(1, -60)),
        ] {
            let content = read(file(name), member, most).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(content, (kind, (shape.clone(), false, expected)), "{name}");
        }
        let page = numbers(1, 0)[..20].to_vec();
        assert_eq!(
            read(file("page.tif"), None, most).unwrap(),
            (LabelKind::U8, (vec![4, 5], false, page.clone()))
        );
        assert_eq!(
            read(file("stored.npz"), Some("other"), most).unwrap(),
            (LabelKind::I64, (vec![4, 5], false, page))
        );
        // The corner of the padded planes.
        let (kind, (padded, _, labels)) = read(file("deflate_tiles.tif"), None, most).unwrap();
        assert_eq!((kind, padded), (LabelKind::U16, vec![3, 24, 25]));
        for (at, label) in labels.into_iter().enumerate() {
            let [z, y, x] = [at / 600, at / 25 % 24, at % 25];
            assert_eq!(label, if y < 4 && x < 5 { 2 * (20 * z + 5 * y + x) as i128 } else { 0 });
        }
    }
}

/// In Fortran order the first axis is the fastest.
#[test]
fn fortran_order_comes_with_its_axes_reversed() {
    let (kind, (shape, reversed, labels)) = read(file("fortran.npy"), None, 2).unwrap();
    assert_eq!((kind, shape, reversed), (LabelKind::I32, vec![5, 4, 3], true));
    for (at, label) in labels.into_iter().enumerate() {
        let [x, y, z] = [at / 12, at / 3 % 4, at % 3];
        assert_eq!(label, 2 * (20 * z + 5 * y + x) as i128);
    }
}

#[test]
fn what_is_no_labelled_image_is_refused() {
    is_refused(vec![], None, &["empty"]);
    is_refused(b"x,y,radius\n".to_vec(), None, &["x,y,radi", "NumPy", "TIFF"]);
    is_refused(file("plain.npy"), Some("labels"), &["'labels'", "no archive"]);
    is_refused(file("stored.npz"), None, &["2 arrays", "labels, other"]);
    is_refused(file("stored.npz"), Some("grains"), &["no array 'grains'", "labels, other"]);
    is_refused(file("float.tif"), None, &["page 1", "F32", "whole numbers"]);
    is_refused(file("white_is_zero.tif"), None, &["page 1", "white is zero"]);
    is_refused(file("colour.tif"), None, &["page 1", "RGB", "grey"]);
    is_refused(file("two_sizes.tif"), None, &["page 2", "5 x 3 pixels", "5 x 4"]);
    is_refused(file("imagej_contiguous.tif"), None, &["3 pages", "has 1 page"]);
}

fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let text = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn arrays_that_are_no_images_are_refused() {
    is_refused(npy("'<f4'", "(1, 2)", &[0; 8]), None, &["<f4", "(1, 2)", "integers"]);
    is_refused(npy("'|b1'", "(1, 2)", &[0; 2]), None, &["|b1", "number the bodies first"]);
    is_refused(npy("[('a', '<u2')]", "(2,)", &[0; 4]), None, &["labels are integers"]);
    is_refused(npy("'<u2'", "(2,)", &[0; 4]), None, &["(2,)", "two or three axes"]);
    is_refused(npy("'<u2'", "(1, 1, 1, 1)", &[0; 2]), None, &["two or three axes"]);
    is_refused(npy("'<u2'", "(2, 2)", &[0; 7]), None, &["8 bytes", "found 7", "cut off"]);
    is_refused(npy("'<u2'", "(2, 2)", &[0; 9]), None, &["continues after the 8 bytes"]);
    is_refused(npy("'<u8'", "(4294967296, 4294967296)", &[0; 8]), None, &["no file can hold"]);
    is_refused(npy("'<u8'", "(0, 4294967296, 4294967296)", &[]), None, &["no file can hold"]);
    is_refused(npy("'<u2'", "(1000000, 1000000, 1000)", &[0; 8]), None, &["found 8", "cut off"]);
    is_refused(
        b"\x93NUMPY\x02\x00\xff\xff\xff\xff{'descr'".to_vec(),
        None,
        &["NumPy header", "4294967307 bytes"],
    );
    is_refused(b"\x93NUMPY\x01\x00".to_vec(), None, &["NumPy header", "ends inside"]);
    let (_, (shape, _, labels)) = read(npy("'<u2'", "(0, 3)", &[]), None, 1).unwrap();
    assert_eq!((shape, labels.len()), (vec![0, 3], 0));
}

/// An archive with one member that contains these bytes.
fn archive(method: zip::CompressionMethod, bytes: &[u8]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    archive.start_file("a.npy", SimpleFileOptions::default().compression_method(method)).unwrap();
    archive.write_all(bytes).unwrap();
    archive.finish().unwrap().into_inner()
}

#[test]
fn damaged_archives_are_refused() {
    for method in [zip::CompressionMethod::Stored, zip::CompressionMethod::Deflated] {
        is_refused(archive(method, b"rubbish, and more of it"), None, &["NumPy header", "does not start"]);
        is_refused(archive(method, &npy("'<u2'", "(2, 2)", &[0; 7])), None, &["8 bytes", "found 7"]);
        is_refused(archive(method, &npy("'<u2'", "(2, 2)", &[0; 9])), None, &["continues after"]);
        is_refused(
            archive(method, &npy("'<u2'", "(1000000, 1000000)", &[0; 9])),
            None,
            &["found 9", "cut off"],
        );
        let good = archive(method, &npy("'<u2'", "(2, 2)", &[7; 8]));
        assert_eq!(read(good.clone(), None, 1).unwrap().1.2, [0x0707; 4]);
        // The checksum does not match: the last plane must not be returned unchecked.
        let mut bytes = good.clone();
        let at = bytes.windows(4).rposition(|window| window == b"PK\x01\x02").unwrap() + 16;
        bytes[at] ^= 1;
        is_refused(bytes, None, &["checksum"]);
        is_refused(good[..good.len() / 2].to_vec(), None, &["NumPy archive"]);
    }
}

/// Every byte changed, and the file cut off at every length: an error or an image, no panic, and no memory
/// for data that do not exist.
#[test]
fn damage_anywhere_is_an_error_or_an_image() {
    let mut errors = 0;
    for name in [
        "plain.npy",
        "deflated.npz",
        "stack.tif",
        "lzw.tif",
        "deflate_tiles.tif",
        "packbits.tif",
        "big_endian.tif",
    ] {
        let good = file(name);
        for at in 0..good.len() {
            for change in [0x01, 0x80, 0xff] {
                let mut bytes = good.clone();
                bytes[at] ^= change;
                errors += usize::from(read(bytes, None, 2).is_err());
            }
            errors += usize::from(read(good[..at].to_vec(), None, 2).is_err());
        }
    }
    assert!(errors > 5000, "{errors}");
}

#[test]
fn labels_are_read_as_what_they_are() {
    let asked = with_label_image(Cursor::new(file("plain.npy")), None, |image| {
        assert_eq!(image.format(), "NumPy array of <u2");
        image.read_planes(1, &mut Vec::<i64>::new())
    });
    assert!(matches!(asked, Err(LabelError::Kind { found: LabelKind::U16, asked: LabelKind::I64 })));
}
