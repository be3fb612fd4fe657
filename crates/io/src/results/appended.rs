//! Arrays after the header of a VTK file, each compressed once.

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;

use crate::written::table::{TableColumn, Values};

/// Number of bytes compressed at a time: a multiple of the size of every value.
const BLOCK: usize = 1 << 20;

/// The bytes that follow the `_` of a file.
#[derive(Default)]
pub(super) struct Appended {
    pub(super) bytes: Vec<u8>,
    block: Vec<u8>,
    /// Where meshio puts the second array and those after it as it decodes the file.
    ///
    /// It looks for the next array by its offset in the file, after it has replaced the offsets of the arrays
    /// before by these. If one of them is the same number, it reads one array in the place of another.
    decoded: Vec<usize>,
}

impl Appended {
    /// Adds a column of `rows` rows; returns the XML element that describes it.
    pub(super) fn column(&mut self, column: &TableColumn<'_>, rows: usize) -> io::Result<String> {
        let of_type = column.vtk_type()?;
        let head = announcement(of_type, column.name, column.components, column.unit, self.bytes.len());
        let size = column.values.size();
        self.array(rows * column.width() * size, |bytes, block| {
            column.values.write_le(bytes.start / size..bytes.end / size, block);
        })?;
        Ok(head)
    }

    /// Adds the arrays that say something of the whole file: the time, and named numbers. The result is the
    /// element that announces them.
    pub(super) fn field_data(&mut self, time: f64, named: &[(String, Vec<i64>)]) -> io::Result<String> {
        let mut head = String::from("<FieldData>\n");
        let mut add = |name: &str, values: Values<'_>, count: usize| -> io::Result<()> {
            let column = TableColumn { name: "", components: &[], unit: "", values };
            let array = self.column(&column, count)?;
            let tuples = format!(" Name=\"{}\" NumberOfTuples=\"{count}\"", escaped(name));
            head += &array.replace(" Name=\"\"", &tuples);
            Ok(())
        };
        add("TimeValue", Values::f64(|_| time), 1)?;
        for (name, numbers) in named {
            add(name, Values::i64(|k| numbers[k]), numbers.len())?;
        }
        Ok(head + "</FieldData>\n")
    }

    /// Adds `count` equal bytes.
    pub(super) fn repeated(&mut self, name: &str, byte: u8, count: usize) -> io::Result<String> {
        let head = announcement("UInt8", name, &[], "", self.bytes.len());
        self.array(count, |bytes, block| block.resize(bytes.len(), byte))?;
        Ok(head)
    }

    /// Adds an array. `part` appends the bytes between two places of it.
    fn array(&mut self, size: usize, part: impl Fn(std::ops::Range<usize>, &mut Vec<u8>)) -> io::Result<()> {
        let blocks = size.div_ceil(BLOCK);
        // It decodes to base64, with the size of the array before it.
        let begin = self.decoded.last().copied().unwrap_or(0);
        for number in [blocks, BLOCK, size % BLOCK] {
            self.bytes.extend((number as u64).to_le_bytes());
        }
        // The sizes of blocks precede them and are not known yet.
        let sizes = self.bytes.len();
        self.bytes.resize(sizes + 8 * blocks, 0);
        for block in 0..blocks {
            self.block.clear();
            part(block * BLOCK..size.min((block + 1) * BLOCK), &mut self.block);
            let before = self.bytes.len();
            // Another level has another length, where the end would be mistaken. Level 0 does not compress.
            for level in [1, 2, 6, 0] {
                self.bytes.truncate(before);
                let mut encoder = ZlibEncoder::new(&mut self.bytes, Compression::new(level));
                encoder.write_all(&self.block)?;
                encoder.finish()?;
                if block + 1 < blocks || !self.decoded.contains(&self.bytes.len()) {
                    break;
                }
            }
            let compressed = (self.bytes.len() - before) as u64;
            self.bytes[sizes + 8 * block..sizes + 8 * (block + 1)].copy_from_slice(&compressed.to_le_bytes());
        }
        self.decoded.push(begin + 4 * (8 + size).div_ceil(3));
        Ok(())
    }
}

/// Text for an attribute of XML.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn announcement(of_type: &str, name: &str, components: &[&str], unit: &str, offset: usize) -> String {
    let mut names = String::new();
    for (k, part) in components.iter().enumerate() {
        names = format!("{names} ComponentName{k}=\"{part}\"");
    }
    // Some readers mishandle a stated number of components of 1.
    let count = match components.len() {
        0 | 1 => String::new(),
        count => format!(" NumberOfComponents=\"{count}\""),
    };
    let array = format!(
        "<DataArray type=\"{of_type}\" Name=\"{name}\"{count}{names} format=\"appended\" offset=\"{offset}\""
    );
    if unit.is_empty() {
        return format!("{array}/>\n");
    }
    // The key by which VTK calls the unit of an array.
    format!(
        "{array}>\n<InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">{unit}</InformationKey>\n</DataArray>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No array begins in the file where meshio has put one of those before it.
    #[test]
    fn no_offset_is_taken_for_that_of_another_array() {
        // Bytes that no level makes shorter: the second array then ends where the decoded first one does, for
        // some sizes.
        let random = |k: usize| ((k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as u8;
        let mut mended = 0;
        for first in 220..420 {
            for second in 1..40 {
                let mut body = Appended::default();
                let mut begins = Vec::new();
                for count in [first, second, 5] {
                    begins.push(body.bytes.len());
                    body.array(count, |bytes, block| block.extend(bytes.map(random))).unwrap();
                }
                for (k, begin) in begins.iter().enumerate() {
                    assert!(!body.decoded[..k.saturating_sub(1)].contains(begin), "{first} {second} {k}");
                }
                // The second byte of compressed data encodes the level: 1 for levels 0 and 1.
                mended += begins.iter().filter(|&&begin| body.bytes[begin + 33] != 1).count();
            }
        }
        assert!(mended > 0, "no case had to be mended");
    }
}
