//! `fdem generate` writes packings, random ones from a seed.

use std::io::{self, Write};

use fdem_io::Centres;
use fdem_scenes::{Cloud, Error, book, clusters, deposit, gas, gas_edge, jittered_lattice, lattice};

use crate::command::args::{BookPacking, Common, GenerateArguments, PackingKind};
use crate::command::failure::{Failure, display_name};
use crate::command::output::{Output, TableFormat, is_stdout};

pub(crate) fn run(arguments: &GenerateArguments) -> Result<(), Failure> {
    let (common, dims) = shape(&arguments.kind);
    let path = common.output.as_deref();
    let table = TableFormat::among(&[TableFormat::Csv, TableFormat::Npy], path)?;
    let mut output = Output::open(path)?;
    let (centres, radii) = if dims == 2 {
        let cloud = planar(&arguments.kind)?;
        (Centres::Two(cloud.centres), cloud.radii)
    } else {
        let cloud = any_dimension::<3>(&arguments.kind)?;
        (Centres::Three(cloud.centres), cloud.radii)
    };
    output.write(|mut out| match table {
        TableFormat::Npy => fdem_io::write_packing_npy(&mut out, &centres, Some(&radii)),
        _ => fdem_io::write_packing_csv(&mut out, &centres, Some(&radii)),
    })?;
    output.commit()?;
    if let Some(path) = path.filter(|path| !is_stdout(path)) {
        let what = if dims == 2 { "discs" } else { "spheres" };
        let edge = edge(&arguments.kind, &radii)?;
        let place =
            edge.map_or_else(String::new, |edge| format!(" (in a box with edges of {edge} from the origin)"));
        // A message that cannot be shown is not an error.
        let _ = writeln!(io::stderr(), "wrote {} {what} to {}{place}", centres.len(), display_name(path));
    }
    Ok(())
}

/// Edge of the box that a gas fills. Periodic searches need it, and it cannot be found from the elements.
fn edge(kind: &PackingKind, radii: &[f64]) -> Result<Option<f64>, Failure> {
    let PackingKind::Gas { dims, neighbours, .. } = kind else { return Ok(None) };
    if radii.is_empty() {
        return Ok(None);
    }
    let edge = if dims.dims == 2 { gas_edge::<2> } else { gas_edge::<3> };
    Ok(Some(edge(radii, *neighbours)?))
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Unusable(format!("cannot generate this packing: {error}"))
    }
}

/// The options that all kinds have, and the dimension.
fn shape(kind: &PackingKind) -> (&Common, u8) {
    match kind {
        PackingKind::Gas { common, dims, .. }
        | PackingKind::Lattice { common, dims, .. }
        | PackingKind::Jittered { common, dims, .. }
        | PackingKind::Clusters { common, dims, .. }
        | PackingKind::Book { common, dims, .. } => (common, dims.dims),
        PackingKind::Deposit { common, .. } => (common, 2),
    }
}

fn planar(kind: &PackingKind) -> Result<Cloud<2>, Failure> {
    match kind {
        PackingKind::Deposit { common, seed, sizes, width, compression } => {
            Ok(deposit(common.elements, seed.seed, sizes.sizes, *width, *compression)?)
        }
        _ => any_dimension(kind),
    }
}

fn any_dimension<const D: usize>(kind: &PackingKind) -> Result<Cloud<D>, Failure> {
    /// Default spacing of the packings B, C and D, in diameters.
    const SPACING: f64 = 2.0;
    let n = shape(kind).0.elements;
    Ok(match *kind {
        PackingKind::Gas { ref seed, ref sizes, neighbours, .. } => {
            gas(n, seed.seed, neighbours, sizes.sizes)
        }
        PackingKind::Lattice { radius, spacing, .. } => lattice(n, spacing, radius),
        PackingKind::Jittered { ref seed, ref sizes, spacing, jitter, .. } => {
            jittered_lattice(n, seed.seed, spacing, jitter, sizes.sizes)
        }
        PackingKind::Clusters { ref seed, ref sizes, per_cluster, domain, neighbours, .. } => {
            clusters(n, seed.seed, per_cluster, domain, neighbours, sizes.sizes)
        }
        PackingKind::Deposit { .. } => unreachable!("a deposit is planar"),
        PackingKind::Book { packing: BookPacking::A, spacing: None, .. } => book::packing_a(n),
        PackingKind::Book { packing: BookPacking::A, spacing: Some(_), .. } => {
            return Err(Failure::Unusable("packing A is dense: --spacing does not apply to it".to_owned()));
        }
        PackingKind::Book { packing: BookPacking::B, spacing, .. } => {
            book::packing_b(n, spacing.unwrap_or(SPACING))
        }
        PackingKind::Book { packing: BookPacking::C, spacing, .. } => {
            book::packing_c(n, spacing.unwrap_or(SPACING))
        }
        PackingKind::Book { packing: BookPacking::D, spacing, .. } => {
            book::packing_d(n, spacing.unwrap_or(SPACING))
        }
    }?)
}
