//! Numbers of a report as consecutive little-endian arrays.

use serde::Serialize;

/// Arrays in one block of bytes. Each is aligned for its type.
#[derive(Default)]
pub(crate) struct Arrays {
    pub(crate) bytes: Vec<u8>,
    pub(crate) index: Vec<Entry>,
}

/// Name, type and position of an array.
#[derive(Debug, Serialize, PartialEq)]
pub(crate) struct Entry {
    name: &'static str,
    kind: &'static str,
    /// Offset, bytes.
    start: usize,
    /// Number of elements.
    length: usize,
}

macro_rules! append {
    ($($kind:ident),*) => {$(
        /// Appends an array.
        pub(crate) fn $kind(&mut self, name: &'static str, numbers: impl Iterator<Item = $kind>) {
            self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
            let start = self.bytes.len();
            numbers.for_each(|number| self.bytes.extend(number.to_le_bytes()));
            let length = (self.bytes.len() - start) / size_of::<$kind>();
            self.index.push(Entry { name, kind: stringify!($kind), start, length });
        }
    )*};
}

impl Arrays {
    append!(f64, f32, u32, i32, i64);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_array_starts_where_its_type_can_be_read() {
        let mut arrays = Arrays::default();
        arrays.u32("a", [1, 2, 3].into_iter());
        arrays.f64("b", [0.5].into_iter());
        assert_eq!(
            arrays.bytes,
            [&[1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0][..], &0.5_f64.to_le_bytes()].concat()
        );
        assert_eq!(arrays.index[1], Entry { name: "b", kind: "f64", start: 16, length: 1 });
    }
}
