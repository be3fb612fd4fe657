//! `fdem generate`: seeded packings.

use fdem_io::Centres;
use fdem_scenes::{Cloud, Error, book, clusters, deposit, gas, jittered_lattice, lattice};

use crate::command::args::{BookPacking, Common, GenerateArguments, Kind};
use crate::command::failure::Failure;
use crate::command::output::{Output, Table};

pub(crate) fn run(arguments: &GenerateArguments) -> Result<(), Failure> {
    let common = common(&arguments.kind);
    let is_deposit = matches!(arguments.kind, Kind::Deposit { .. });
    let path = common.output.as_deref();
    let table = Table::of(path)?;
    let mut output = Output::open(path)?;
    let (centres, radii) = match (common.dims, is_deposit) {
        (Some(3), true) => {
            return Err(Failure::Unusable("a deposit has --dims 2: its discs roll in a plane".to_owned()));
        }
        (_, true) | (Some(2), false) => {
            let cloud = planar(&arguments.kind).map_err(unusable)?;
            (Centres::Two(cloud.centres), cloud.radii)
        }
        _ => {
            let cloud = any_dimension::<3>(&arguments.kind).map_err(unusable)?;
            (Centres::Three(cloud.centres), cloud.radii)
        }
    };
    output.write(|mut out| match table {
        Table::Csv => fdem_io::write_packing_csv(&mut out, &centres, Some(&radii)),
        Table::Npy => fdem_io::write_packing_npy(&mut out, &centres, Some(&radii)),
    })?;
    output.commit()
}

fn unusable(error: Error) -> Failure {
    Failure::Unusable(format!("cannot generate this packing: {error}"))
}

fn common(kind: &Kind) -> &Common {
    match kind {
        Kind::Gas { common, .. }
        | Kind::Lattice { common, .. }
        | Kind::Jittered { common, .. }
        | Kind::Clusters { common, .. }
        | Kind::Deposit { common, .. }
        | Kind::Book { common, .. } => common,
    }
}

fn planar(kind: &Kind) -> Result<Cloud<2>, Error> {
    match kind {
        Kind::Deposit { common, seed, sizes, width, compression } => {
            deposit(common.elements, seed.seed, sizes.sizes, *width, *compression)
        }
        _ => any_dimension(kind),
    }
}

fn any_dimension<const D: usize>(kind: &Kind) -> Result<Cloud<D>, Error> {
    let n = common(kind).elements;
    match *kind {
        Kind::Gas { ref seed, ref sizes, neighbours, .. } => gas(n, seed.seed, neighbours, sizes.sizes),
        Kind::Lattice { radius, spacing, .. } => lattice(n, spacing, radius),
        Kind::Jittered { ref seed, ref sizes, spacing, jitter, .. } => {
            jittered_lattice(n, seed.seed, spacing, jitter, sizes.sizes)
        }
        Kind::Clusters { ref seed, ref sizes, per_cluster, domain, neighbours, .. } => {
            clusters(n, seed.seed, per_cluster, domain, neighbours, sizes.sizes)
        }
        Kind::Deposit { .. } => unreachable!("a deposit is planar"),
        Kind::Book { packing, spacing, .. } => match packing {
            BookPacking::A => book::packing_a(n),
            BookPacking::B => book::packing_b(n, spacing),
            BookPacking::C => book::packing_c(n, spacing),
            BookPacking::D => book::packing_d(n, spacing),
        },
    }
}
