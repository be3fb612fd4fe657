//! Compressed files: recognised by their first bytes, decompressed as a stream.

use std::borrow::Cow;
use std::io::Read;

use flate2::bufread::MultiGzDecoder;
use ruzstd::decoding::StreamingDecoder;

use crate::compression::Compression;
use crate::error::ReadError;

const GZIP: &[u8] = b"\x1f\x8b";
const ZSTD: &[u8] = b"\x28\xb5\x2f\xfd";
/// The second to fourth byte of a skippable frame of zstd; the first is 0x50 to 0x5f.
const SKIPPABLE: &[u8] = b"\x2a\x4d\x18";
/// The largest window that the program zstd decompresses without an option.
const MOST_WINDOW: u64 = 1 << 27;
/// Number of bytes decompressed between two checks of the memory.
const PIECE: usize = 1 << 18;
/// Number of bytes that are decompressed before content that cannot be read is given up: a small file may
/// expand to terabytes of zeros.
const TRIAL: usize = 1 << 20;

impl Compression {
    /// The compression, from the first bytes of a file; `None` if it is not compressed.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(GZIP) {
            return Some(Self::Gzip);
        }
        (bytes.starts_with(ZSTD) || skipped(bytes).is_some()).then_some(Self::Zstd)
    }
}

/// Decompresses gzip and zstd, including several members or frames in one file; other bytes are returned as
/// they are.
///
/// `wanted` is called with the first 2^20 decompressed bytes, or all if there are fewer, and decides whether
/// to continue. If not, only these bytes are returned.
///
/// # Cost
/// Time and memory proportional to the output. Memory is allocated piece by piece as content arrives,
/// whatever a header claims. Windows of zstd may have up to 128 MiB.
///
/// # Errors
/// [`ReadError::Packed`] if the data are damaged or cut off, or a checksum does not match;
/// [`ReadError::NoMemory`].
///
/// # Example
/// ```
/// let (bytes, compression) = fdem_io::unpack(b"x,y\n0,1\n".as_slice().into(), |_| true)?;
/// assert_eq!((bytes.as_ref(), compression), (b"x,y\n0,1\n".as_slice(), None));
/// # Ok::<(), fdem_io::ReadError>(())
/// ```
pub fn unpack(
    bytes: Cow<'_, [u8]>,
    wanted: impl Fn(&[u8]) -> bool,
) -> Result<(Cow<'_, [u8]>, Option<Compression>), ReadError> {
    unpack_within(bytes, u64::MAX, wanted)
}

/// [`unpack`] with a limit on the number of decompressed bytes.
///
/// The size that a file states, as gzip does at its end and zstd in its header, is compared with the limit
/// before memory is taken. A file that states less than it holds is refused when its content exceeds the
/// limit.
///
/// # Errors
/// The errors of [`unpack`]; [`ReadError::TooLarge`].
///
/// # Example
/// ```
/// use fdem_io::{ReadError, unpack_within};
///
/// // 28 B5 2F FD starts a frame of zstd, whose header states 1,000,000 bytes.
/// let frame = b"\x28\xb5\x2f\xfd\xa0\x40\x42\x0f\x00";
/// let error = unpack_within(frame.as_slice().into(), 1000, |_| true).unwrap_err();
/// assert!(matches!(error, ReadError::TooLarge { bytes: 1_000_000, limit: 1000, .. }));
/// ```
pub fn unpack_within(
    bytes: Cow<'_, [u8]>,
    limit: u64,
    wanted: impl Fn(&[u8]) -> bool,
) -> Result<(Cow<'_, [u8]>, Option<Compression>), ReadError> {
    let Some(compression) = Compression::of(&bytes) else { return Ok((bytes, None)) };
    let mut out = Unpacked { bytes: Vec::new(), compression, wanted, tried: false, limit };
    match compression {
        Compression::Gzip => {
            // The size of the last member, modulo 2^32.
            if let Some(size) = bytes.last_chunk::<4>() {
                out.check_limit(u64::from(u32::from_le_bytes(*size)))?;
            }
            out.take(&mut MultiGzDecoder::new(&*bytes))?;
        }
        Compression::Zstd => zstd(&bytes, &mut out)?,
    }
    Ok((Cow::Owned(out.bytes), Some(compression)))
}

/// The output so far.
struct Unpacked<W> {
    bytes: Vec<u8>,
    compression: Compression,
    wanted: W,
    tried: bool,
    /// Most bytes.
    limit: u64,
}

impl<W: Fn(&[u8]) -> bool> Unpacked<W> {
    /// Reads the whole input; returns false if the content is not needed.
    fn take(&mut self, input: &mut dyn Read) -> Result<bool, ReadError> {
        loop {
            let from = self.bytes.len();
            let no_memory = |_| ReadError::NoMemory { bytes: from as u64 + PIECE as u64 };
            self.bytes.try_reserve(PIECE).map_err(no_memory)?;
            let read = input.take(PIECE as u64).read_to_end(&mut self.bytes);
            let read = read.map_err(|error| self.damaged(error.to_string()))?;
            if !self.tried && self.bytes.len() >= TRIAL {
                self.tried = true;
                if !(self.wanted)(&self.bytes) {
                    return Ok(false);
                }
            }
            if read == 0 {
                return Ok(true);
            }
            self.check_limit(self.bytes.len() as u64)?;
        }
    }

    fn check_limit(&self, bytes: u64) -> Result<(), ReadError> {
        let &Self { compression, limit, .. } = self;
        if bytes > limit { Err(ReadError::TooLarge { compression, bytes, limit }) } else { Ok(()) }
    }

    fn damaged(&self, problem: impl Into<String>) -> ReadError {
        let problem = crate::excerpt::line(problem.into().as_bytes());
        ReadError::Packed { compression: self.compression, unpacked: self.bytes.len() as u64, problem }
    }
}

fn zstd<W: Fn(&[u8]) -> bool>(mut rest: &[u8], out: &mut Unpacked<W>) -> Result<(), ReadError> {
    while !rest.is_empty() {
        if let Some(length) = skipped(rest) {
            rest = rest.get(length..).ok_or_else(|| out.damaged("it is cut off"))?;
            continue;
        }
        let decoder = StreamingDecoder::new_with_max_window_size(rest, MOST_WINDOW);
        let mut decoder = decoder.map_err(|error| out.damaged(error.to_string()))?;
        // 0 if the header states no size.
        out.check_limit((out.bytes.len() as u64).saturating_add(decoder.decoder.content_size()))?;
        if !out.take(&mut decoder)? {
            return Ok(());
        }
        let (after, frame) = decoder.into_parts();
        let (told, found) = (frame.get_checksum_from_data(), frame.get_calculated_checksum());
        if told.is_some_and(|told| Some(told) != found) {
            return Err(out.damaged("the checksum does not fit"));
        }
        rest = after;
    }
    Ok(())
}

/// The length of the skippable frame that starts here, if any.
fn skipped(bytes: &[u8]) -> Option<usize> {
    let header = bytes.get(..8)?;
    let length: [u8; 4] = header[4..].try_into().ok()?;
    let skippable = header[0] & 0xf0 == 0x50 && &header[1..4] == SKIPPABLE;
    skippable.then_some(8 + u32::from_le_bytes(length) as usize)
}
