//! Values as bytes, in little-endian order, and back. Messages between ranks are of the same program, so that they need no names and no versions.

/// A value that ranks send to each other.
pub(crate) trait Wire: Sized {
    /// Appends the value to a message.
    fn put(&self, out: &mut Vec<u8>);

    /// Takes the value from the head of a message.
    fn take(bytes: &mut &[u8]) -> Self;
}

/// A message with one value.
pub(super) fn bytes_of(value: &impl Wire) -> Vec<u8> {
    let mut bytes = Vec::new();
    value.put(&mut bytes);
    bytes
}

/// The value of a message.
pub(super) fn value_of<T: Wire>(mut bytes: &[u8]) -> T {
    T::take(&mut bytes)
}

/// Takes so many bytes from the head of a message.
fn head<const K: usize>(bytes: &mut &[u8]) -> [u8; K] {
    let head = bytes.split_off(..K).expect("a message is as long as its values");
    std::array::from_fn(|k| head[k])
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

numbers!(u8, u32, u64, i64, f64);

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

/// Implements [`Wire`] for a structure by its fields, in the order in which they are listed.
macro_rules! wire {
    ([$($parameters:tt)*] $name:ty { $($field:ident),* $(,)? }) => {
        impl<$($parameters)*> crate::ranks::wire::Wire for $name {
            fn put(&self, out: &mut Vec<u8>) {
                let Self { $($field),* } = self;
                $(crate::ranks::wire::Wire::put($field, out);)*
            }

            fn take(bytes: &mut &[u8]) -> Self {
                $(let $field = crate::ranks::wire::Wire::take(bytes);)*
                Self { $($field),* }
            }
        }
    };
}
pub(crate) use wire;
