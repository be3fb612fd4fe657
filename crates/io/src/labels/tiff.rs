//! Images in the pages of a TIFF file.

use std::io::{Read, Seek};

use tiff::decoder::{Decoder, DecodingSampleType, Limits};
use tiff::tags::{CompressionMethod, PhotometricInterpretation, Tag};
use tiff::{ColorType, TiffError};

use crate::excerpt;
use crate::labels::error::LabelError;
use crate::labels::image::{LabelImage, Pages, Planes};
use crate::labels::kind::{LabelKind, kind_of};
use crate::npy_header::Scalar;

/// A file whose pages have been checked.
pub(super) struct Stack<R: Read + Seek> {
    decoder: Decoder<R>,
    /// The current page of the decoder.
    at: usize,
    page: Vec<u8>,
}

/// The common properties of all pages.
#[derive(Debug, Clone, PartialEq)]
struct Page {
    width: u32,
    height: u32,
    color: ColorType,
    sample: DecodingSampleType,
}

/// The properties of the image that the pages form.
pub(super) struct Described {
    scalar: Scalar,
    kind: LabelKind,
    shape: Vec<usize>,
}

impl Described {
    pub(super) fn image(self, pages: &mut dyn Pages) -> LabelImage<'_> {
        let Self { scalar, kind, shape } = self;
        let pages_of = if shape.len() == 2 { "1 page".to_owned() } else { format!("{} pages", shape[0]) };
        let format = format!("TIFF file, {pages_of} of {}", scalar.descr);
        LabelImage { planes: Planes::Pages(pages), scalar, kind, shape, reversed: false, format, position: 0 }
    }
}

/// Checks all pages, without reading their labels.
pub(super) fn open<R: Read + Seek>(input: R, size: u64) -> Result<(Stack<R>, Described), LabelError> {
    let failed = |page: usize| move |error: TiffError| LabelError::Page { page, problem: error.to_string() };
    let mut limits = Limits::default();
    // No part of a file is longer than the file.
    limits.intermediate_buffer_size = usize::try_from(size).unwrap_or(usize::MAX);
    let mut decoder = Decoder::new(input).map_err(failed(1))?.with_limits(limits);
    let first = page(&mut decoder, size, 1)?;
    let declared = declared_pages(&mut decoder);
    let mut pages = 1;
    while decoder.more_images() {
        pages += 1;
        decoder.next_image().map_err(failed(pages))?;
        let next = page(&mut decoder, size, pages)?;
        if next != first {
            let problem = format!("it is {}, page 1 is {}", next.shown(), first.shown());
            return Err(LabelError::Page { page: pages, problem });
        }
    }
    if let Some(declared) = declared.filter(|&declared| declared != pages) {
        let problem = format!(
            "its description says that there are {}, but the file has {}: save the stack anew as TIFF or .npy",
            excerpt::count(declared as u64, "page"),
            excerpt::count(pages as u64, "page")
        );
        return Err(LabelError::Page { page: 1, problem });
    }
    decoder.seek_to_image(0).map_err(failed(1))?;
    let (scalar, kind) = first.labels(1)?;
    let (height, width) = (first.height as usize, first.width as usize);
    let shape = if pages == 1 { vec![height, width] } else { vec![pages, height, width] };
    Ok((Stack { decoder, at: 0, page: Vec::new() }, Described { scalar, kind, shape }))
}

/// The properties of the current page.
fn page<R: Read + Seek>(decoder: &mut Decoder<R>, size: u64, number: usize) -> Result<Page, LabelError> {
    let bad = |problem: String| LabelError::Page { page: number, problem };
    let failed = |error: TiffError| bad(error.to_string());
    let (width, height) = decoder.dimensions().map_err(failed)?;
    let color = decoder.colortype().map_err(failed)?;
    let tag = |decoder: &mut Decoder<R>, tag| decoder.find_tag_unsigned::<u16>(tag).map_err(failed);
    let photometric =
        tag(decoder, Tag::PhotometricInterpretation)?.and_then(PhotometricInterpretation::from_u16);
    if !matches!(color, ColorType::Gray(_)) {
        return Err(bad(format!("it is {color:?}: labels are grey")));
    }
    // The decoder inverts these numbers.
    if photometric == Some(PhotometricInterpretation::WhiteIsZero) {
        return Err(bad(
            "white is zero in it, so that labels are upside down: save it with black as zero".to_owned()
        ));
    }
    let layout = decoder.image_buffer_layout().map_err(failed)?;
    let sample =
        layout.sample_type.ok_or_else(|| bad(format!("its numbers are {color:?}, which are not read")))?;
    // The largest number of bytes that one byte of the file can expand to.
    let compression = tag(decoder, Tag::Compression)?;
    let most = match compression.map(CompressionMethod::from_u16_exhaustive) {
        None | Some(CompressionMethod::None) => 1,
        Some(CompressionMethod::PackBits) => 64,
        Some(CompressionMethod::Deflate | CompressionMethod::OldDeflate) => 1032,
        // A code of 12 bits represents a string of at most 4096 bytes.
        Some(CompressionMethod::LZW) => 2731,
        Some(other) => return Err(bad(format!("it is compressed by {other:?}, which is not read"))),
    };
    if layout.len as u64 > size.saturating_mul(most) {
        return Err(bad(format!(
            "it claims {width} x {height} pixels, more than the {size} bytes of the file can hold: it is damaged"
        )));
    }
    Ok(Page { width, height, color, sample })
}

/// The number of pages stated by `ImageJ`: for large stacks it writes only the header of the first page, and
/// the others follow without headers.
fn declared_pages<R: Read + Seek>(decoder: &mut Decoder<R>) -> Option<usize> {
    let text = decoder.get_tag_ascii_string(Tag::ImageDescription).ok()?;
    text.starts_with("ImageJ=").then_some(())?;
    text.lines().find_map(|line| line.trim().strip_prefix("images=")?.parse().ok())
}

impl Page {
    fn shown(&self) -> String {
        format!("{} x {} pixels of {:?}", self.width, self.height, self.sample)
    }

    /// The type of the labels.
    fn labels(&self, page: usize) -> Result<(Scalar, LabelKind), LabelError> {
        let (kind, size) = match self.sample {
            DecodingSampleType::U8 => ('u', 1),
            DecodingSampleType::U16 => ('u', 2),
            DecodingSampleType::U32 => ('u', 4),
            DecodingSampleType::U64 => ('u', 8),
            DecodingSampleType::I8 => ('i', 1),
            DecodingSampleType::I16 => ('i', 2),
            DecodingSampleType::I32 => ('i', 4),
            DecodingSampleType::I64 => ('i', 8),
            _ => ('f', 0),
        };
        let sign = if kind == 'u' { "out a sign" } else { " a sign" };
        let descr = format!("{} bits with{sign}", 8 * size);
        let scalar = Scalar { kind, size, big_endian: cfg!(target_endian = "big"), descr };
        let whole = matches!(self.color, ColorType::Gray(8 | 16 | 32 | 64));
        let kind = kind_of(&scalar).filter(|_| whole).ok_or_else(|| {
            let problem = format!(
                "its numbers are {:?} of {:?}: labels are whole numbers of 8, 16, 32 or 64 bits",
                self.sample, self.color
            );
            LabelError::Page { page, problem }
        })?;
        Ok((scalar, kind))
    }
}

impl<R: Read + Seek> Pages for Stack<R> {
    fn read(&mut self, page: usize) -> Result<&[u8], LabelError> {
        let failed = |error: TiffError| LabelError::Page { page: page + 1, problem: error.to_string() };
        while self.at < page {
            self.decoder.next_image().map_err(failed)?;
            self.at += 1;
        }
        let bytes = self.decoder.image_buffer_layout().map_err(failed)?.len;
        if self.page.len() != bytes {
            self.page.clear();
            self.page.try_reserve_exact(bytes).map_err(|_| LabelError::NoMemory { bytes })?;
            self.page.resize(bytes, 0);
        }
        self.decoder.read_image_bytes(&mut self.page).map_err(failed)?;
        Ok(&self.page)
    }
}
