//! A mesh of tetrahedra.

/// A mesh of tetrahedra. Every facet belongs to two elements of one region, or is listed in `facets`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tetrahedra {
    /// Coordinates `[n]`, in the unit of the surface.
    pub nodes: Vec<[f64; 3]>,
    /// Corners of the elements `[m]`: the first three are counter-clockwise seen from the last.
    pub elements: Vec<[u32; 4]>,
    /// Region of each element `[m]`.
    pub regions: Vec<u32>,
    /// Outer facets and facets between regions `[k]`, once each: counter-clockwise seen from outside, or from
    /// the region of the higher number.
    pub facets: Vec<[u32; 3]>,
    /// Face of each of those facets `[k]`.
    pub faces: Vec<u32>,
    /// Facets on those of the surface that are inside of a region `[l]`, once each.
    pub inner: Vec<[u32; 3]>,
    /// Face of each of those facets `[l]`.
    pub inner_faces: Vec<u32>,
}
