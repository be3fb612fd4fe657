//! What can be wrong with the input. Every variant says what, where and the limit.

use std::fmt;

use crate::simd::Simd;

/// Why a set of elements, or a search over it, was refused before anything was computed.
///
/// No input is ever clamped, dropped or capped in silence: either the answer is exact, or it is one of these.
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
    /// A coordinate is so large that squared distances overflow ([`Real::MAX_MAGNITUDE`](crate::Real::MAX_MAGNITUDE)).
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
    /// The cut-off is negative, NaN, infinite or larger than [`Real::MAX_MAGNITUDE`](crate::Real::MAX_MAGNITUDE).
    InvalidCutoff {
        /// The offending value.
        value: f64,
        /// Largest cut-off that is accepted.
        limit: f64,
    },
    /// A radius is negative, NaN, infinite or larger than [`Real::MAX_MAGNITUDE`](crate::Real::MAX_MAGNITUDE).
    InvalidRadius {
        /// Zero-based number of the element, or `None` for the one radius of all.
        index: Option<usize>,
        /// The offending value.
        value: f64,
        /// Largest radius that is accepted.
        limit: f64,
    },
    /// The tolerance is negative, NaN, infinite or larger than [`Real::MAX_MAGNITUDE`](crate::Real::MAX_MAGNITUDE).
    InvalidTolerance {
        /// The offending value.
        value: f64,
        /// Largest tolerance that is accepted.
        limit: f64,
    },
    /// The buffer is negative, NaN, infinite or larger than [`Real::MAX_MAGNITUDE`](crate::Real::MAX_MAGNITUDE).
    InvalidBuffer {
        /// The offending value.
        value: f64,
        /// Largest buffer that is accepted.
        limit: f64,
    },
    /// An index was searched before it was built, or after its building has failed.
    IndexNotBuilt,
    /// Boxes were compared with spheres or points: two sets are of one kind.
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
        /// What the second array holds: `"radii"` or `"maximum corners"`, or `"bodies"`, `"categories"`, `"masks"` or `"groups"` of a filter.
        what: &'static str,
        /// Length of the first array, the centres or minimum corners.
        expected: usize,
        /// Length of the second.
        found: usize,
    },
    /// A group that the matrix of groups does not have.
    UnknownGroup {
        /// Zero-based number of the element of that group, or `None` where no element is meant.
        index: Option<usize>,
        /// The group.
        group: u32,
        /// Groups of the matrix, numbered from 0.
        groups: usize,
    },
    /// More elements than the integers of an engine can number.
    TooManyElements {
        /// Number of elements asked for.
        elements: usize,
        /// Largest number that is accepted.
        limit: usize,
    },
    /// A couple that is not two different elements, the smaller number first.
    MalformedCouple {
        /// Its place in the couple list.
        index: usize,
        /// Its first element.
        i: u32,
        /// Its second element, which must be larger than the first and below `elements`.
        j: u32,
        /// Number of elements.
        elements: usize,
    },
    /// The domain is so wide, in cells, that the list heads alone would exceed the bound of the engine.
    DomainTooWide {
        /// Zero-based axis that needs the most cells.
        axis: usize,
        /// Width of the domain along that axis, in the unit of the coordinates.
        width: f64,
        /// Edge of a cell, in the same unit.
        cell_size: f64,
        /// Integers that the heads of all axes would take (a float: it may be beyond any integer).
        heads: f64,
        /// Bound on that number.
        limit: usize,
        /// The element that stretches the domain, the one farthest from the mean of all along that axis, and its coordinate;
        /// `None` if the caller set the domain.
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
        /// Its bounds on that axis.
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
    /// A component of an edge of a periodic box is NaN, infinite or too large, or the whole edge is too short.
    InvalidBoxEdge {
        /// Zero-based number of the edge.
        edge: usize,
        /// Its component of the largest magnitude, or the one that is not a number.
        value: f64,
        /// Smallest magnitude of the largest component, and largest, that are accepted.
        limits: [f64; 2],
    },
    /// An edge of a periodic box is linearly dependent on the edges before it, up to rounding: the box has no volume.
    DependentBoxEdges {
        /// Zero-based number of the first edge that is.
        edge: usize,
        /// Its height above the edges before it, as a fraction of its length.
        height: f64,
        /// Smallest fraction that is accepted.
        limit: f64,
    },
    /// The edges of a periodic box are left-handed: its volume is negative.
    NegativeBoxVolume {
        /// The volume, which may be beyond the range of floats.
        volume: f64,
    },
    /// An element lies outside the periodic box, and the search was told to refuse that.
    OutsideBox {
        /// Zero-based number of the element.
        index: usize,
        /// Zero-based number of the edge along which it is outside.
        edge: usize,
        /// Where it is along that edge: from 0 to 1 is inside.
        fraction: f64,
    },
    /// An element lies so many periods away from its box that the shifts of its couples do not fit their integers.
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
    /// The periodic box is so thin that rounding of the coordinates is of its size.
    UnresolvedBox {
        /// Zero-based number of the edge along which it is thin.
        edge: usize,
        /// Bound on the rounding, in periods.
        rounding: f64,
    },
    /// The periodic box is so small, for the reach of its elements, that it takes too many periodic images.
    TooManyImages {
        /// Number of images (a float: it may be beyond any integer).
        images: f64,
        /// Bound on that number.
        limit: usize,
    },
    /// Neighbours at edges of an image in 2D, which has faces (sides) and vertices (corners) only.
    NoEdgesIn2D,
    /// More grid squares than sums over them can be kept of in integers.
    ImageTooLarge {
        /// Grid squares along each axis.
        shape: Vec<usize>,
    },
    /// A slab of an image is not made of whole planes.
    PartialPlane {
        /// Its grid squares.
        squares: usize,
        /// Grid squares of a plane.
        plane: usize,
    },
    /// More planes than the shape of the image says.
    TooManyPlanes {
        /// Planes with those of the last slab.
        found: usize,
        /// Planes of the image.
        expected: usize,
    },
    /// The image was finished before its last plane had come.
    MissingPlanes {
        /// Planes that have come.
        found: usize,
        /// Planes of the image.
        expected: usize,
    },
    /// The edge of a grid square is not a length, or beyond the range in which areas are exact to rounding.
    InvalidSpacing {
        /// Zero-based axis of the array.
        axis: usize,
        /// The offending value.
        value: f64,
        /// Shortest and longest edge that are accepted.
        limits: [f64; 2],
    },
    /// More contacts, or labels, in an image than can be numbered.
    TooManyContacts {
        /// Largest number that is accepted.
        limit: usize,
    },
    /// This processor lacks the vector instructions that were asked for.
    SimdUnavailable {
        /// What was asked for.
        simd: Simd,
    },
    /// The threads that were asked for cannot be had.
    NoThreads {
        /// Number asked for; 0 is one for each processor.
        threads: usize,
        /// Why not.
        reason: String,
    },
    /// The search was [stopped](crate::Detector::stopped_by) before its end.
    Stopped,
    /// The system has no memory left for the arrays of an engine.
    OutOfMemory {
        /// Bytes that were asked for.
        bytes: usize,
    },
}

const AXIS_NAMES: [&str; 4] = ["x", "y", "z", "w"];

/// `x`, `y`, `z`, `w`, then `axis 4` and so on.
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
                     take {heads:.3e} integers, the bound is {limit}. "
                )?;
                if let Some((element, position)) = stretched_by {
                    write!(
                        out,
                        "Element {element} at {name} = {position:e} stretches it; without it the domain may do. "
                    )?;
                }
                write!(
                    out,
                    "An engine whose memory does not depend on the domain (`Engine::Rows`) or a higher bound \
                     (`Nbs::with_max_heads`) will do"
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
            Self::NegativeBoxVolume { volume } => write!(
                out,
                "the periodic box has the negative volume {volume:e}: its edges are left-handed; swap two, or turn one round"
            ),
            Self::OutsideBox { index, edge, fraction } => write!(
                out,
                "element {index} is outside the periodic box: at {fraction} along edge {edge}, where 0 to 1 is inside"
            ),
            Self::TooFarFromBox { index, edge, periods, limit } => write!(
                out,
                "element {index} is {periods:e} periods from the periodic box along edge {edge}; at most {limit:e} can be counted"
            ),
            Self::UnresolvedBox { edge, rounding } => write!(
                out,
                "the periodic box is too thin along edge {edge} for these coordinates: they are rounded by up to {rounding:e} \
                 of it"
            ),
            Self::TooManyImages { images, limit } => write!(
                out,
                "the periodic box is too small for the reach of its elements: they take {images:.3e} images, the bound is \
                 {limit}"
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
                write!(out, "{squares} grid squares are not a number of planes of {plane}")
            }
            Self::TooManyPlanes { found, expected } => {
                write!(out, "the image has {expected} planes, {found} have come")
            }
            Self::MissingPlanes { found, expected } => {
                write!(out, "the image has {expected} planes, only {found} have come")
            }
            Self::InvalidSpacing { axis, value, limits: [low, high] } => write!(
                out,
                "spacing along axis {axis} of the image: {value:e} is not a length from {low:e} to {high:e}"
            ),
            Self::TooManyContacts { limit } => {
                write!(out, "the image has more than {limit} contacts or labels: they cannot be numbered")
            }
            Self::SimdUnavailable { simd } => write!(out, "this processor has no {simd}"),
            Self::NoThreads { threads, reason } => write!(out, "{threads} threads cannot be had: {reason}"),
            Self::Stopped => write!(out, "the search was stopped before its end"),
            Self::OutOfMemory { bytes } => write!(out, "no memory for {bytes} bytes"),
        }
    }
}

fn not_in_range(out: &mut fmt::Formatter<'_>, what: &str, value: f64, limit: f64) -> fmt::Result {
    // Hundreds of digits help nobody.
    let value = if value.abs() < 1e9 { value.to_string() } else { format!("{value:e}") };
    write!(out, "{what} {value} is not a number from 0 to {limit:e}")
}

impl Error {
    /// The element that the error is about, by its zero-based number, if it is about one.
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
