//! The errors of this crate. Every variant carries the problem, its place and the limit.

use std::fmt;

use crate::simd::level::Simd;

/// The reason why a set of elements, or a search over it, was refused before anything was computed.
///
/// Input is never clamped, dropped or capped silently: either the answer is exact, or there is one of these
/// errors.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A coordinate of a centre or of a box corner is NaN or infinite.
    NonFiniteCoordinate {
        /// Zero-based number of the element.
        index: usize,
        /// Zero-based axis: 0 is x.
        axis: usize,
        /// The offending value.
        value: f64,
    },
    /// A coordinate is so large that squared distances overflow
    /// ([`Real::MAX_MAGNITUDE`](crate::Real::MAX_MAGNITUDE)).
    CoordinateTooLarge {
        /// Zero-based number of the element.
        index: usize,
        /// Zero-based axis: 0 is x.
        axis: usize,
        /// The offending value.
        value: f64,
        /// Largest magnitude that is accepted.
        limit: f64,
    },
    /// The cut-off is negative, NaN, infinite or larger than
    /// [`Real::MAX_MAGNITUDE`](crate::Real::MAX_MAGNITUDE).
    InvalidCutoff {
        /// The offending value.
        value: f64,
        /// Largest cut-off that is accepted.
        limit: f64,
    },
    /// A radius is negative, NaN, infinite or larger than
    /// [`Real::MAX_MAGNITUDE`](crate::Real::MAX_MAGNITUDE).
    InvalidRadius {
        /// Zero-based number of the element, or `None` for the one radius of all.
        index: Option<usize>,
        /// The offending value.
        value: f64,
        /// Largest radius that is accepted.
        limit: f64,
    },
    /// The tolerance is negative, NaN, infinite or larger than
    /// [`Real::MAX_MAGNITUDE`](crate::Real::MAX_MAGNITUDE).
    InvalidTolerance {
        /// The offending value.
        value: f64,
        /// Largest tolerance that is accepted.
        limit: f64,
    },
    /// The buffer is negative, NaN, infinite or larger than
    /// [`Real::MAX_MAGNITUDE`](crate::Real::MAX_MAGNITUDE).
    InvalidBuffer {
        /// The offending value.
        value: f64,
        /// Largest buffer that is accepted.
        limit: f64,
    },
    /// An index was searched before it was built, or after building it failed.
    IndexNotBuilt,
    /// Boxes were compared with spheres or points; two sets must be of one kind.
    UnlikeShapes,
    /// Two sets have filters of different kinds or with different matrices, or only one has a filter.
    UnlikeFilters,
    /// A box has its minimum above its maximum.
    InvertedBox {
        /// Zero-based number of the element.
        index: usize,
        /// Zero-based axis: 0 is x.
        axis: usize,
        /// The minimum corner on that axis.
        min: f64,
        /// The maximum corner on that axis.
        max: f64,
    },
    /// Two arrays that describe the same elements differ in length.
    LengthMismatch {
        /// The contents of the second array: `"radii"` or `"maximum corners"`, or `"bodies"`, `"categories"`,
        /// `"masks"` or `"groups"` of a filter.
        what: &'static str,
        /// Length of the first array, the centres or minimum corners.
        expected: usize,
        /// Length of the second array.
        found: usize,
    },
    /// A group that the matrix of groups does not have.
    UnknownGroup {
        /// Zero-based number of the element of that group, or `None` if the group does not belong to an
        /// element.
        index: Option<usize>,
        /// The group.
        group: u32,
        /// Number of groups of the matrix; groups are numbered from 0.
        groups: usize,
    },
    /// There are more elements than the integers of an engine can number.
    TooManyElements {
        /// Requested number of elements.
        elements: usize,
        /// Largest number that is accepted.
        limit: usize,
    },
    /// A couple does not consist of two different elements with the smaller number first.
    MalformedCouple {
        /// Zero-based place of the couple in the list.
        index: usize,
        /// The first element of the couple.
        i: u32,
        /// Its second element, which must be larger than the first and below `elements`.
        j: u32,
        /// Number of elements.
        elements: usize,
    },
    /// The domain is so wide, in cells, that the list heads alone would exceed the limit of the engine.
    DomainTooWide {
        /// Zero-based axis that needs the most cells.
        axis: usize,
        /// Width of the domain along that axis, in the unit of the coordinates.
        width: f64,
        /// Edge of a cell, in the same unit.
        cell_size: f64,
        /// Number of list heads of all axes (a float, because it may exceed any integer).
        heads: f64,
        /// Limit on that number.
        limit: usize,
        /// The element that stretches the domain, which is the one farthest from the mean of all along that
        /// axis, and its coordinate; `None` if the caller set the domain.
        stretched_by: Option<(usize, f64)>,
    },
    /// An element lies outside the domain that the caller set.
    OutsideDomain {
        /// Zero-based number of the element.
        index: usize,
        /// Zero-based axis: 0 is x.
        axis: usize,
        /// The offending coordinate.
        value: f64,
        /// The domain on that axis.
        domain: [f64; 2],
    },
    /// The domain that the caller set is not a finite, non-empty box, or the cell edge is not positive.
    InvalidDomain {
        /// Zero-based axis: 0 is x.
        axis: usize,
        /// Bounds of the domain on that axis.
        domain: [f64; 2],
    },
    /// A coordinate of the origin of a periodic box is NaN, infinite or too large.
    InvalidBoxOrigin {
        /// Zero-based axis: 0 is x.
        axis: usize,
        /// The offending value.
        value: f64,
        /// Largest magnitude that is accepted.
        limit: f64,
    },
    /// A component of an edge of a periodic box is NaN, infinite or too large, or the whole edge is too
    /// short.
    InvalidBoxEdge {
        /// Zero-based number of the edge.
        edge: usize,
        /// Its component of the largest magnitude, or the component that is not a number.
        value: f64,
        /// Smallest and largest accepted magnitude of the largest component.
        limits: [f64; 2],
    },
    /// An edge of a periodic box is linearly dependent on the edges before it, up to rounding: the box has no
    /// volume.
    DependentBoxEdges {
        /// Zero-based number of the first edge that is.
        edge: usize,
        /// Its height above the edges before it, as a fraction of its length.
        height: f64,
        /// Smallest fraction that is accepted.
        limit: f64,
    },
    /// An element lies outside the periodic box, and the search refuses such elements.
    OutsideBox {
        /// Zero-based number of the element.
        index: usize,
        /// Zero-based number of the edge along which it is outside.
        edge: usize,
        /// Its position along that edge; 0 to 1 is inside.
        fraction: f64,
    },
    /// An element is so far away from the box that the shifts of its couples do not fit their
    /// integers.
    TooFarFromBox {
        /// Zero-based number of the element.
        index: usize,
        /// Zero-based number of the edge along which it is far.
        edge: usize,
        /// Number of periods.
        periods: f64,
        /// Largest number that is accepted.
        limit: f64,
    },
    /// The periodic box is so skewed that the shifts of its couples may not fit their integers.
    ShiftTooLarge {
        /// Upper bound on the edges in a shift.
        edges: f64,
        /// Largest number that is accepted.
        limit: f64,
    },
    /// The periodic box is so thin that the rounding of coordinates is comparable to its size.
    UnresolvedBox {
        /// Zero-based number of the edge along which it is thin.
        edge: usize,
        /// Upper bound on the rounding, in periods.
        rounding: f64,
    },
    /// The periodic box is so small, compared with the reach of its elements, that it would need too many
    /// periodic images.
    TooManyImages {
        /// Number of images (a float, because it may exceed any integer).
        images: f64,
        /// Limit on that number.
        limit: usize,
    },
    /// Edge neighbours were requested in 2D, where grid squares have only faces (sides) and vertices
    /// (corners).
    NoEdgesIn2D,
    /// The image has more grid squares than the integer sums over it allow.
    ImageTooLarge {
        /// Grid squares along each axis.
        shape: Vec<usize>,
    },
    /// A slab of an image is not made of whole planes.
    PartialPlane {
        /// Number of its grid squares.
        squares: usize,
        /// Number of grid squares in a plane.
        plane: usize,
    },
    /// There are more planes than the shape of the image says.
    TooManyPlanes {
        /// Number of planes, including those of the last slab.
        found: usize,
        /// Number of planes of the image.
        expected: usize,
    },
    /// The image was finished before all of its planes were added.
    MissingPlanes {
        /// Number of planes added.
        found: usize,
        /// Number of planes of the image.
        expected: usize,
    },
    /// The edge of a grid square is not a length, or is outside the range in which areas are exact to
    /// rounding.
    InvalidSpacing {
        /// Zero-based axis of the array.
        axis: usize,
        /// The offending value.
        value: f64,
        /// Shortest and longest edge that are accepted.
        limits: [f64; 2],
    },
    /// An image has more contacts or labels than can be numbered.
    TooManyContacts {
        /// Largest number that is accepted.
        limit: usize,
    },
    /// This processor lacks the requested vector instructions.
    SimdUnavailable {
        /// The requested instructions.
        simd: Simd,
    },
    /// The requested threads cannot be started.
    NoThreads {
        /// Number of threads requested; 0 is one per processor.
        threads: usize,
        /// The reason.
        reason: String,
    },
    /// The search was [stopped](crate::Detector::stopped_by) before its end.
    Stopped,
    /// A device that searches in place of the processor cannot do so.
    Device {
        /// The reason.
        message: String,
    },
    /// The system has no memory left for an array.
    OutOfMemory {
        /// Number of bytes requested.
        bytes: usize,
    },
}

const AXIS_NAMES: [&str; 4] = ["x", "y", "z", "w"];

/// The name of an axis: `x`, `y`, `z`, `w`, then `axis 4` and so on.
pub(crate) fn axis_name(axis: usize) -> String {
    AXIS_NAMES.get(axis).map_or_else(|| format!("axis {axis}"), |name| (*name).to_owned())
}

impl fmt::Display for Error {
    #[allow(clippy::too_many_lines, reason = "an arm for each variant")]
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFiniteCoordinate { index, axis, value } => {
                write!(
                    out,
                    "element {index}: coordinate {} is {value}, not a finite number",
                    axis_name(*axis)
                )
            }
            Self::CoordinateTooLarge { index, axis, value, limit } => write!(
                out,
                "element {index}: coordinate {} is {value:e}; magnitudes above {limit:e} overflow when squared",
                axis_name(*axis)
            ),
            Self::InvalidCutoff { value, limit } => not_in_range(out, "cut-off", *value, *limit),
            Self::InvalidRadius { index: Some(index), value, limit } => {
                not_in_range(out, &format!("element {index}: radius"), *value, *limit)
            }
            Self::InvalidRadius { index: None, value, limit } => not_in_range(out, "radius", *value, *limit),
            Self::InvalidTolerance { value, limit } => not_in_range(out, "tolerance", *value, *limit),
            Self::InvalidBuffer { value, limit } => not_in_range(out, "buffer", *value, *limit),
            Self::IndexNotBuilt => {
                write!(out, "the index holds no elements yet: it was not built, or building it failed")
            }
            Self::UnlikeShapes => write!(out, "axis-aligned boxes cannot be compared with spheres or points"),
            Self::UnlikeFilters => {
                write!(
                    out,
                    "the filters of the two sets differ in kind or in their matrix, or only one set has a filter"
                )
            }
            Self::InvertedBox { index, axis, min, max } => write!(
                out,
                "element {index}: its box is inverted along {}: minimum {min} above maximum {max}",
                axis_name(*axis)
            ),
            Self::LengthMismatch { what, expected, found } => {
                write!(out, "{expected} elements but {found} {what}")
            }
            Self::UnknownGroup { index, group, groups } => {
                if let Some(index) = index {
                    write!(out, "element {index}: ")?;
                }
                write!(out, "group {group} is not below {groups}, the number of groups of the matrix")
            }
            Self::TooManyElements { elements, limit } => {
                write!(out, "{elements} elements; this engine numbers at most {limit}")
            }
            Self::MalformedCouple { index, i, j, elements } => {
                write!(out, "couple {index} is ({i}, {j}), not i < j < {elements}, the number of elements")
            }
            Self::DomainTooWide { axis, width, cell_size, heads, limit, stretched_by } => {
                let (name, cells) = (axis_name(*axis), width / cell_size);
                write!(
                    out,
                    "the domain is {width:e} wide along {name}, {cells:.3e} cells of {cell_size:e}: the list heads would \
                     take {heads:.3e} integers; the limit is {limit}. "
                )?;
                if let Some((element, position)) = stretched_by {
                    write!(
                        out,
                        "Element {element} at {name} = {position:e} is the farthest from the others. "
                    )?;
                }
                write!(
                    out,
                    "Use an engine whose memory does not depend on the domain (`Engine::Rows`), or a higher limit \
                     (`Nbs::with_max_heads`)"
                )
            }
            Self::OutsideDomain { index, axis, value, domain: [min, max] } => write!(
                out,
                "element {index}: coordinate {} is {value}, outside the domain [{min}, {max}]",
                axis_name(*axis)
            ),
            Self::InvalidDomain { axis, domain: [min, max] } => {
                write!(out, "the domain [{min}, {max}] along {} is empty or not finite", axis_name(*axis))
            }
            Self::InvalidBoxOrigin { axis, value, limit } => write!(
                out,
                "the origin of the periodic box: coordinate {} is {value:e}, not a number from -{limit:e} to {limit:e}",
                axis_name(*axis)
            ),
            Self::InvalidBoxEdge { edge, value, limits: [low, high] } => write!(
                out,
                "edge {edge} of the periodic box: {value:e} is not a length from {low:e} to {high:e}"
            ),
            Self::DependentBoxEdges { edge, height, limit } => write!(
                out,
                "the periodic box has no volume: edge {edge} is linearly dependent on those before it (it rises above them \
                 by {height:.1e} of its length, at least {limit:.1e} is needed)"
            ),
            Self::OutsideBox { index, edge, fraction } => write!(
                out,
                "element {index} is outside the periodic box: at {fraction} along edge {edge}, where 0 to 1 is inside"
            ),
            Self::TooFarFromBox { index, edge, periods, limit } => write!(
                out,
                "element {index} is {periods:e} periods from the periodic box along edge {edge}; at most {limit:e} can be counted"
            ),
            Self::ShiftTooLarge { edges, limit } => write!(
                out,
                "the periodic box is so skewed that images are up to {edges:e} of its edges away; at most {limit:e} can be \
                 counted. Describe the same lattice by shorter edges"
            ),
            Self::UnresolvedBox { edge, rounding } => write!(
                out,
                "the periodic box is too thin along edge {edge} for these coordinates: they are rounded by up to {rounding:e} \
                 of it"
            ),
            Self::TooManyImages { images, limit } => write!(
                out,
                "the periodic box is too small for the reach of its elements: they take {images:.3e} images; the limit is \
                 {limit}. Give a smaller cut-off, or check the edges of the box"
            ),
            Self::NoEdgesIn2D => {
                write!(
                    out,
                    "in 2D grid squares meet along a face or at a vertex: there is no edge neighbourhood"
                )
            }
            Self::ImageTooLarge { shape } => write!(
                out,
                "an image of {shape:?} grid squares is too large: sums over about 30,000 x 30,000 x 30,000 fit 64 bits"
            ),
            Self::PartialPlane { squares, plane } => {
                write!(out, "{squares} grid squares are not a whole number of planes of {plane}")
            }
            Self::TooManyPlanes { found, expected } => {
                write!(out, "the image has {expected} planes, but {found} were given")
            }
            Self::MissingPlanes { found, expected } => {
                write!(out, "the image has {expected} planes, but only {found} were given")
            }
            Self::InvalidSpacing { axis, value, limits: [low, high] } => write!(
                out,
                "spacing along axis {axis} of the image: {value:e} is not a length from {low:e} to {high:e}"
            ),
            Self::TooManyContacts { limit } => {
                write!(out, "the image has more than {limit} contacts or labels: they cannot be numbered")
            }
            Self::SimdUnavailable { simd } => write!(out, "this processor has no {simd}"),
            Self::NoThreads { threads, reason } => write!(out, "cannot start {threads} threads: {reason}"),
            Self::Stopped => write!(out, "the search was stopped before its end"),
            Self::Device { message } => write!(out, "{message}"),
            Self::OutOfMemory { bytes } => write!(out, "no memory for {bytes} bytes"),
        }
    }
}

fn not_in_range(out: &mut fmt::Formatter<'_>, what: &str, value: f64, limit: f64) -> fmt::Result {
    // Avoids numbers of hundreds of digits.
    let value = if value.abs() < 1e9 { value.to_string() } else { format!("{value:e}") };
    write!(out, "{what} {value} is not a number from 0 to {limit:e}")
}

impl Error {
    /// The zero-based number of the element that the error is about, if there is one.
    pub fn element(&self) -> Option<usize> {
        match self {
            Self::NonFiniteCoordinate { index, .. }
            | Self::CoordinateTooLarge { index, .. }
            | Self::InvertedBox { index, .. }
            | Self::OutsideDomain { index, .. }
            | Self::OutsideBox { index, .. }
            | Self::TooFarFromBox { index, .. } => Some(*index),
            Self::InvalidRadius { index, .. } | Self::UnknownGroup { index, .. } => *index,
            Self::DomainTooWide { stretched_by, .. } => stretched_by.map(|(element, _)| element),
            _ => None,
        }
    }
}

impl std::error::Error for Error {}

/// Refuses an array of another length than expected.
pub(crate) fn check_lengths(what: &'static str, expected: usize, found: usize) -> Result<(), Error> {
    if expected != found {
        return Err(Error::LengthMismatch { what, expected, found });
    }
    Ok(())
}
