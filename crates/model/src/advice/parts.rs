//! Parts of a mesh: elements that hang together by facets. Nothing holds elements to each other that share
//! only nodes, or an edge in three dimensions.

use fdem_mesh::{Corners, sorted_facets};

/// The part of each element: the least element of its part.
pub(crate) fn parts<const D: usize, const N: usize>(elements: &[[u32; N]]) -> Vec<u32>
where
    [[f64; D]; N]: Corners<D, N>,
{
    let facets = sorted_facets::<D, N>(elements);
    let mut parent: Vec<u32> = (0..elements.len() as u32).collect();
    for pair in facets.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        join(&mut parent, pair[0].1, pair[1].1);
    }
    (0..elements.len() as u32).map(|element| root(&mut parent, element)).collect()
}

/// Joins the sets of two numbers. Returns whether they were two.
pub(crate) fn join(parent: &mut [u32], one: u32, other: u32) -> bool {
    let (a, b) = (root(parent, one), root(parent, other));
    parent[a.max(b) as usize] = a.min(b);
    a != b
}

/// The least number of the set of a number.
fn root(parent: &mut [u32], mut number: u32) -> u32 {
    while parent[number as usize] != number {
        parent[number as usize] = parent[parent[number as usize] as usize];
        number = parent[number as usize];
    }
    number
}
