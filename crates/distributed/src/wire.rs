//! Values as bytes, in little-endian order, and back. Messages between ranks are of the same program, so that
//! they need no names and no versions.

use fdem_contact::Real;

/// A value that ranks send to each other. The macro [`wire!`](crate::wire!) implements it for a structure.
///
/// # Example
/// ```
/// use fdem_distributed::wire::{Wire, bytes_of, value_of};
///
/// #[derive(Debug, PartialEq)]
/// struct Node<const D: usize> {
///     position: [f64; D],
///     elements: Vec<u32>,
/// }
///
/// fdem_distributed::wire!([const D: usize] Node<D> { position, elements });
///
/// let node = Node { position: [0.5, 2.0], elements: vec![3, 4, 7] };
/// assert_eq!(value_of::<Node<2>>(&bytes_of(&node)), node);
/// ```
pub trait Wire: Sized {
    /// Appends the value to a message.
    fn put(&self, out: &mut Vec<u8>);

    /// Takes the value from the head of a message.
    ///
    /// # Panics
    /// If the message is shorter than the value, which would be a bug: messages come from the same program.
    fn take(bytes: &mut &[u8]) -> Self;
}

/// Returns a message with one value.
pub fn bytes_of(value: &impl Wire) -> Vec<u8> {
    let mut bytes = Vec::new();
    value.put(&mut bytes);
    bytes
}

/// Returns the value of a message.
///
/// # Panics
/// If the message is shorter than the value, which would be a bug.
pub fn value_of<T: Wire>(mut bytes: &[u8]) -> T {
    T::take(&mut bytes)
}

/// Appends values whose number the reader knows.
pub(crate) fn put_all<T: Wire>(values: impl IntoIterator<Item = T>, out: &mut Vec<u8>) {
    values.into_iter().for_each(|value| value.put(out));
}

/// Appends points, without loss: `f64` holds every `f32`.
pub(crate) fn put_points<T: Real, const D: usize>(
    points: impl IntoIterator<Item = [T; D]>,
    out: &mut Vec<u8>,
) {
    put_all(points.into_iter().map(|point| point.map(T::to_f64)), out);
}

/// Takes `count` values from the head of a message.
pub(crate) fn take_all<T: Wire>(bytes: &mut &[u8], count: usize) -> impl ExactSizeIterator<Item = T> {
    (0..count).map(|_| T::take(bytes))
}

/// Takes `count` points of [`put_points`] from the head of a message.
pub(crate) fn take_points<T: Real, const D: usize>(
    bytes: &mut &[u8],
    count: usize,
) -> impl ExactSizeIterator<Item = [T; D]> {
    take_all::<[f64; D]>(bytes, count).map(|point| point.map(T::nearest))
}

/// Takes `count` bytes from the head of a message.
pub(crate) fn part<'a>(bytes: &mut &'a [u8], count: usize) -> &'a [u8] {
    bytes.split_off(..count).expect("a message is as long as its values")
}

/// Takes `K` bytes from the head of a message.
#[inline]
fn head<const K: usize>(bytes: &mut &[u8]) -> [u8; K] {
    let (head, rest) = bytes.split_first_chunk().expect("a message is as long as its values");
    *bytes = rest;
    *head
}

macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl Wire for $number {
            #[inline]
            fn put(&self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }

            #[inline]
            fn take(bytes: &mut &[u8]) -> Self {
                Self::from_le_bytes(head(bytes))
            }
        }
    )*};
}

numbers!(u8, u16, u32, i32, u64, i64, f64);

impl Wire for bool {
    fn put(&self, out: &mut Vec<u8>) {
        out.push(u8::from(*self));
    }

    fn take(bytes: &mut &[u8]) -> Self {
        u8::take(bytes) != 0
    }
}

impl<T: Wire, const K: usize> Wire for [T; K] {
    fn put(&self, out: &mut Vec<u8>) {
        for value in self {
            value.put(out);
        }
    }

    fn take(bytes: &mut &[u8]) -> Self {
        std::array::from_fn(|_| T::take(bytes))
    }
}

impl<T: Wire> Wire for Vec<T> {
    fn put(&self, out: &mut Vec<u8>) {
        (self.len() as u64).put(out);
        for value in self {
            value.put(out);
        }
    }

    fn take(bytes: &mut &[u8]) -> Self {
        (0..u64::take(bytes)).map(|_| T::take(bytes)).collect()
    }
}

impl<T: Wire> Wire for Option<T> {
    fn put(&self, out: &mut Vec<u8>) {
        self.is_some().put(out);
        if let Some(value) = self {
            value.put(out);
        }
    }

    fn take(bytes: &mut &[u8]) -> Self {
        bool::take(bytes).then(|| T::take(bytes))
    }
}

impl<A: Wire, B: Wire> Wire for (A, B) {
    fn put(&self, out: &mut Vec<u8>) {
        self.0.put(out);
        self.1.put(out);
    }

    fn take(bytes: &mut &[u8]) -> Self {
        (A::take(bytes), B::take(bytes))
    }
}

impl Wire for String {
    fn put(&self, out: &mut Vec<u8>) {
        self.as_bytes().to_vec().put(out);
    }

    fn take(bytes: &mut &[u8]) -> Self {
        Self::from_utf8_lossy(&Vec::take(bytes)).into_owned()
    }
}

/// Implements [`Wire`](crate::wire::Wire) for a structure by its fields, in the order in which they are
/// listed. Its generic parameters come first, in brackets.
#[macro_export]
macro_rules! wire {
    ([$($parameters:tt)*] $name:ty { $($field:ident),* $(,)? }) => {
        impl<$($parameters)*> $crate::wire::Wire for $name {
            fn put(&self, out: &mut Vec<u8>) {
                let Self { $($field),* } = self;
                $($crate::wire::Wire::put($field, out);)*
            }

            fn take(bytes: &mut &[u8]) -> Self {
                $(let $field = $crate::wire::Wire::take(bytes);)*
                Self { $($field),* }
            }
        }
    };
}
