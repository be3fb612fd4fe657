//! Numbers as bytes, in little-endian order, and back.

use fdem_contact::Real;

/// A message that is being written.
#[derive(Debug, Default)]
pub(crate) struct Writer {
    pub(crate) bytes: Vec<u8>,
}

impl Writer {
    pub(crate) fn u64(&mut self, value: u64) {
        self.bytes.extend_from_slice(&value.to_le_bytes());
    }

    pub(crate) fn u32s(&mut self, values: impl IntoIterator<Item = u32>) {
        values.into_iter().for_each(|value| self.bytes.extend_from_slice(&value.to_le_bytes()));
    }

    pub(crate) fn u64s(&mut self, values: impl IntoIterator<Item = u64>) {
        values.into_iter().for_each(|value| self.bytes.extend_from_slice(&value.to_le_bytes()));
    }

    /// Integers of several components.
    pub(crate) fn shifts<const D: usize>(&mut self, values: impl IntoIterator<Item = [i32; D]>) {
        let values = values.into_iter().flatten();
        values.for_each(|value| self.bytes.extend_from_slice(&value.to_le_bytes()));
    }

    /// Points, without loss.
    pub(crate) fn points<T: Real, const D: usize>(&mut self, points: impl IntoIterator<Item = [T; D]>) {
        for point in points {
            self.bytes.extend_from_slice(point.map(|x| x.to_f64().to_le_bytes()).as_flattened());
        }
    }

    /// Floats, without loss: `f64` holds every `f32`.
    pub(crate) fn reals<T: Real>(&mut self, values: impl IntoIterator<Item = T>) {
        values.into_iter().for_each(|value| self.bytes.extend_from_slice(&value.to_f64().to_le_bytes()));
    }
}

/// A message that is being read. It was written by the same program, so its length is right.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// The next bytes.
    pub(crate) fn part(&mut self, bytes: usize) -> Self {
        Self { rest: self.rest.split_off(..bytes).expect("a message is as long as its contents") }
    }

    fn chunks<const N: usize>(&mut self, count: usize) -> impl ExactSizeIterator<Item = [u8; N]> + 'a {
        let bytes = self.rest.split_off(..count * N).expect("a message is as long as its contents");
        bytes.as_chunks::<N>().0.iter().copied()
    }

    pub(crate) fn u32s(&mut self, count: usize) -> impl ExactSizeIterator<Item = u32> + 'a {
        self.chunks(count).map(u32::from_le_bytes)
    }

    pub(crate) fn u64s(&mut self, count: usize) -> impl ExactSizeIterator<Item = u64> + 'a {
        self.chunks(count).map(u64::from_le_bytes)
    }

    pub(crate) fn reals<T: Real>(&mut self, count: usize) -> impl ExactSizeIterator<Item = T> + 'a {
        self.chunks(count).map(|bytes| T::nearest(f64::from_le_bytes(bytes)))
    }

    pub(crate) fn shifts<const D: usize>(
        &mut self,
        count: usize,
    ) -> impl ExactSizeIterator<Item = [i32; D]> + 'a {
        let bytes = self.rest.split_off(..count * D * 4).expect("a message is as long as its contents");
        let numbers = bytes.as_chunks::<4>().0;
        (0..count).map(move |k| std::array::from_fn(|axis| i32::from_le_bytes(numbers[k * D + axis])))
    }

    pub(crate) fn points<T: Real, const D: usize>(
        &mut self,
        count: usize,
    ) -> impl ExactSizeIterator<Item = [T; D]> + 'a {
        let bytes = self.rest.split_off(..count * D * 8).expect("a message is as long as its contents");
        let points = bytes.as_chunks::<8>().0.as_chunks::<D>().0;
        points.iter().map(|point| point.map(|x| T::nearest(f64::from_le_bytes(x))))
    }
}
