//! What is written has the promised bytes, and other readers take it.

use std::io::{self, Write};

use fdem_io::{Centres, CoupleRow, write_csv, write_npy, write_packing_csv, write_packing_npy};

fn rows(n: i32) -> impl ExactSizeIterator<Item = CoupleRow> {
    (0..n).map(|k| CoupleRow {
        i: k.into(),
        j: i64::from(-k) - 1,
        distance: 0.1 * f64::from(k),
        overlap: -1e-300 / (f64::from(k) + 3.0),
        shift: [],
    })
}

#[test]
fn couples_as_text() {
    let mut out = Vec::new();
    assert_eq!(write_csv(&mut out, rows(3)).unwrap(), 3);
    let text = String::from_utf8(out).unwrap();
    let expected = "i,j,distance,overlap\n\
        0,-1,0.0,-3.3333333333333334e-301\n1,-2,0.1,-2.5e-301\n2,-3,0.2,-2e-301\n";
    assert_eq!(text, expected);
}

#[test]
fn couples_with_shifts() {
    let rows = [
        CoupleRow { i: 4, j: 9, distance: 0.5, overlap: 0.25, shift: [0, -1, 2] },
        CoupleRow { i: 5, j: 5, distance: 1.0, overlap: 0.0, shift: [1, 0, i32::MIN] },
    ];
    let mut out = Vec::new();
    assert_eq!(write_csv(&mut out, rows.into_iter()).unwrap(), 2);
    assert_eq!(
        String::from_utf8(out).unwrap(),
        "i,j,distance,overlap,sx,sy,sz\n4,9,0.5,0.25,0,-1,2\n5,5,1.0,0.0,1,0,-2147483648\n"
    );

    let mut out = Vec::new();
    write_npy(&mut out, rows.into_iter()).unwrap();
    let mut data = out.as_slice();
    let header = npyz::NpyHeader::from_reader(&mut data).unwrap();
    assert_eq!(
        header.dtype().descr(),
        "[('i', '<i8'), ('j', '<i8'), ('distance', '<f8'), ('overlap', '<f8'), ('sx', '<i4'), ('sy', '<i4'), ('sz', '<i4'), ]"
    );
    assert_eq!(data.len(), 2 * 44);
    let last = <[u8; 4]>::try_from(&data[40..44]).unwrap();
    assert_eq!(i32::from_le_bytes(last), 2);

    let flat = [CoupleRow { i: 0, j: 1, distance: 1.0, overlap: 0.0, shift: [3, 4] }];
    let mut out = Vec::new();
    write_csv(&mut out, flat.into_iter()).unwrap();
    assert_eq!(String::from_utf8(out).unwrap(), "i,j,distance,overlap,sx,sy\n0,1,1.0,0.0,3,4\n");
}

/// More rows than one chunk holds: none is lost or doubled where chunks meet.
#[test]
fn couples_in_many_chunks() {
    const N: i32 = 50_000;
    let mut out = Vec::new();
    assert_eq!(write_csv(&mut out, rows(N)).unwrap(), 50_000);
    let text = String::from_utf8(out).unwrap();
    assert_eq!(text.lines().count(), 50_001);
    for (line, row) in text.lines().skip(1).zip(rows(N)) {
        let fields: Vec<_> = line.split(',').collect();
        assert_eq!(fields[0].parse(), Ok(row.i));
        assert_eq!(fields[1].parse(), Ok(row.j));
        assert_eq!(fields[2].parse(), Ok(row.distance));
        assert_eq!(fields[3].parse(), Ok(row.overlap));
    }
}

#[test]
fn couples_as_an_array() {
    const N: i32 = 50_000;
    let mut out = Vec::new();
    write_npy(&mut out, rows(N)).unwrap();
    let mut data = out.as_slice();
    let header = npyz::NpyHeader::from_reader(&mut data).unwrap();
    assert_eq!(header.shape(), [50_000]);
    assert_eq!(
        header.dtype().descr(),
        "[('i', '<i8'), ('j', '<i8'), ('distance', '<f8'), ('overlap', '<f8'), ]"
    );
    assert_eq!((out.len() - data.len()) % 64, 0, "the data are aligned");
    assert_eq!(data.len(), 32 * 50_000);
    for (bytes, row) in data.chunks_exact(32).zip(rows(N)) {
        let word = |k: usize| <[u8; 8]>::try_from(&bytes[8 * k..8 * k + 8]).unwrap();
        assert_eq!(i64::from_le_bytes(word(0)), row.i);
        assert_eq!(i64::from_le_bytes(word(1)), row.j);
        assert_eq!(f64::from_le_bytes(word(2)), row.distance);
        assert_eq!(f64::from_le_bytes(word(3)), row.overlap);
    }
}

#[test]
fn packings_as_text() {
    let mut out = Vec::new();
    let centres = Centres::Three(vec![[1.0, -2.5, 1e-7]]);
    write_packing_csv(&mut out, &centres, None).unwrap();
    write_packing_csv(&mut out, &centres, Some(&[0.5])).unwrap();
    write_packing_csv(&mut out, &Centres::Two(vec![]), Some(&[])).unwrap();
    let expected = "x,y,z\n1.0,-2.5,1e-7\nx,y,z,radius\n1.0,-2.5,1e-7,0.5\nx,y,radius\n";
    assert_eq!(String::from_utf8(out).unwrap(), expected);
}

#[test]
fn packings_as_arrays() {
    let shape = |centres: &Centres, radii: Option<&[f64]>| {
        let mut out = Vec::new();
        write_packing_npy(&mut out, centres, radii).unwrap();
        let file = npyz::NpyFile::new(out.as_slice()).unwrap();
        let (shape, descr) = (file.shape().to_vec(), file.dtype().descr());
        (shape, descr, file.into_vec::<f64>().ok())
    };
    let flat = Centres::Two(vec![[1.0, 2.0], [3.0, 4.0]]);
    let solid = Centres::Three(vec![[1.0, 2.0, 3.0]]);
    assert_eq!(shape(&flat, None), (vec![2, 2], "'<f8'".into(), Some(vec![1.0, 2.0, 3.0, 4.0])));
    assert_eq!(shape(&solid, None), (vec![1, 3], "'<f8'".into(), Some(vec![1.0, 2.0, 3.0])));
    assert_eq!(shape(&solid, Some(&[9.0])), (vec![1, 4], "'<f8'".into(), Some(vec![1.0, 2.0, 3.0, 9.0])));
    let fields = "[('x', '<f8'), ('y', '<f8'), ('radius', '<f8'), ]";
    assert_eq!(shape(&flat, Some(&[8.0, 9.0])), (vec![2], fields.into(), None));
}

/// Says it holds rows, and gives none.
struct Liar(usize);

impl Iterator for Liar {
    type Item = CoupleRow;
    fn next(&mut self) -> Option<CoupleRow> {
        None
    }
    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.0, Some(self.0))
    }
}

impl ExactSizeIterator for Liar {}

#[test]
fn lengths_that_disagree_are_refused() {
    let centres = Centres::Two(vec![[0.0, 0.0]]);
    let kind = |result: io::Result<()>| result.map_err(|error| error.kind());
    assert_eq!(
        kind(write_packing_csv(&mut Vec::new(), &centres, Some(&[]))),
        Err(io::ErrorKind::InvalidInput)
    );
    assert_eq!(
        kind(write_packing_npy(&mut Vec::new(), &centres, Some(&[]))),
        Err(io::ErrorKind::InvalidInput)
    );
    assert_eq!(kind(write_npy(&mut Vec::new(), Liar(3))), Err(io::ErrorKind::InvalidInput));
}

#[test]
fn a_full_disk_is_reported() {
    struct Full(usize);
    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0 = self.0.checked_sub(bytes.len()).ok_or(io::ErrorKind::StorageFull)?;
            Ok(bytes.len())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    for room in [0, 300_000] {
        assert_eq!(write_csv(&mut Full(room), rows(50_000)).unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!(write_npy(&mut Full(room), rows(50_000)).unwrap_err().kind(), io::ErrorKind::StorageFull);
    }
}
