//! The types of elements, such as chemical species: names, of which a file has few.

use std::collections::BTreeMap;

/// The type of each element.
///
/// # Shapes
/// `of`: `n` numbers below the length of `names`.
///
/// # Example
/// ```
/// use std::sync::atomic::AtomicU64;
/// use fdem_io::{ReadOptions, TypeColumn, read_packing};
///
/// let options = ReadOptions { types: Some(TypeColumn::Usual), ..ReadOptions::default() };
/// let packing = read_packing(b"3\n\nH 0 0 0\nC 1 0 0\nH 2 0 0\n", "a.xyz", &options, &AtomicU64::new(0))?;
/// let types = packing.types.unwrap();
/// assert_eq!((types.names, types.of), (vec!["H".to_owned(), "C".to_owned()], vec![0, 1, 0]));
/// # Ok::<(), fdem_io::ReadError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Types {
    /// The names as the file spells them, all different, in the order in which they occur. Whole numbers of
    /// an array are written in decimal.
    pub names: Vec<String>,
    /// The number of the name of each element.
    pub of: Vec<u32>,
}

/// The type of one row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum TypeOfRow<'a> {
    /// A field of text.
    Name(&'a [u8]),
    /// A number of an array.
    Number(i64),
}

impl Default for TypeOfRow<'_> {
    fn default() -> Self {
        Self::Number(0)
    }
}

/// Types that are being read.
#[derive(Debug, Default)]
pub(crate) struct TypesOfRows {
    types: Types,
    numbers: BTreeMap<String, u32>,
}

impl TypesOfRows {
    pub(crate) fn new(of: Vec<u32>) -> Self {
        Self { types: Types { names: Vec::new(), of }, numbers: BTreeMap::new() }
    }

    pub(crate) fn push(&mut self, row: TypeOfRow<'_>) {
        let number = match row {
            // The input is valid UTF-8, so nothing is lost.
            TypeOfRow::Name(name) => self.number(&String::from_utf8_lossy(name)),
            TypeOfRow::Number(number) => self.number(&number.to_string()),
        };
        self.types.of.push(number);
    }

    /// The number of a name, which is new or not.
    fn number(&mut self, name: &str) -> u32 {
        if let Some(&number) = self.numbers.get(name) {
            return number;
        }
        let number = self.types.names.len() as u32;
        self.types.names.push(name.to_owned());
        self.numbers.insert(name.to_owned(), number);
        number
    }

    pub(crate) fn into_types(self) -> Types {
        self.types
    }
}
