//! Exchange of fluid between cracks and the pores beside them.

use crate::error::FluidError;
use crate::matrix::PorousMatrix;
use crate::network::Network;

/// Lets fluid flow between the wet cells of a network and the pores at their corners, once after each step of
/// the network. Corners of cells are vertices of the pores. Returns the volume that the pores have gained, m³
/// at the reference density.
///
/// A crack has the pressure of the pores at its faces: between a corner of a cell, which takes the `D`th part
/// of its capacity `C = dm/dp/ρ`, and its vertex, whose storage `S` is shared by all such corners, the
/// difference is levelled out, `C S/(C + S) (p_c - p_v)`. So both have one pressure after a few steps, and
/// none overshoots, however stiff the fluid in the crack is. Where the capacity is far below the storage, as
/// with rigid walls and long steps, a crack gives no more than its capacity in each step. A cell that is not
/// full takes fluid at its lowest pressure, and no cell gives more than half of its fluid. The volume that
/// one side loses the other gains; the network has it in [`Balance::leaked`](crate::Balance::leaked),
/// negative if pores drain into cracks, the pores in
/// [`PoreBalance::exchanged`](crate::PoreBalance::exchanged).
///
/// # Errors
/// A corner that is no vertex of the pores.
pub fn exchange<const D: usize, const N: usize>(
    network: &mut Network<D>,
    matrix: &mut PorousMatrix<D, N>,
) -> Result<f64, FluidError> {
    let outlets = network.outlets();
    let storages = matrix.storages();
    let mut shares = vec![0_u32; storages.len()];
    for vertex in outlets.iter().flat_map(|outlet| outlet.vertices) {
        let Some(share) = shares.get_mut(vertex as usize) else {
            let range = "that of a vertex of the pores";
            let (place, value) = ("cell".to_owned(), f64::from(vertex));
            return Err(FluidError::OutOfRange { place, what: "number of a corner", value, range });
        };
        *share += 1;
    }
    let mut losses = Vec::with_capacity(outlets.len());
    let mut gains: Vec<(u32, f64)> = Vec::new();
    for outlet in &outlets {
        let mut loss = 0.0;
        for vertex in outlet.vertices {
            let at = vertex as usize;
            let storage = storages[at] / f64::from(shares[at]);
            if storage > 0.0 {
                let volume = outlet.volume(storage, matrix.pressures()[at], D as f64);
                loss += volume;
                gains.push((vertex, volume));
            }
        }
        losses.push((*outlet, loss));
    }
    network.lose(&losses);
    matrix.gain(&gains);
    Ok(losses.iter().fold(0.0, |sum, (_, loss)| sum + loss))
}
