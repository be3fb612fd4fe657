//! Contacts between elements on a device.

use fdem_simulation::{CoupleColumns, CoupleStates, FlatContact, FlatGrip, Press, PressSums, SUM_PARTS};

use crate::array::Array;
use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{
    Address, ContactCaseArguments, CoupleArguments, CoupleForceArguments, Kernel, LargestArguments, THREADS,
};
use crate::primitives::{add_up, launch, launch_blocks, pieces, sums_of};

/// Bits of the marks of a couple in the kernels, and of its state.
const MAY_BEGIN: u32 = 1;
const CREDITS: u32 = 2;
const TOUCHES: u32 = 1;

/// Rows of sums over couples: both parts of four works, then the number that touch and nothing.
const ROWS: usize = 10;

/// The couples of a run.
pub(crate) struct DeviceContacts<M, const D: usize> {
    count: usize,
    elements: Array<M, u32>,
    marks: Array<M, u32>,
    laws: Array<M, f64>,
    states: Array<M, u32>,
    apart_until: Array<M, f64>,
    grips: Array<M, f64>,
    forces: Array<M, f64>,
    energies: Array<M, f64>,
    /// The elements of all couples, each once, where the couples of each begin, and these.
    gathering: usize,
    gathered: Array<M, u32>,
    starts: Array<M, u32>,
    sides: Array<M, u32>,
    /// Sums and largest numbers of the blocks of couples.
    sums: Array<M, f64>,
    mosts: Array<M, f64>,
    /// The parts of all sums, then the bits of the largest number.
    report: Array<M, u64>,
}

impl<M, const D: usize> DeviceContacts<M, D> {
    /// Numbers of a history.
    const GRIP: usize = 5 * D + 2;

    pub(crate) const fn new() -> Self {
        Self {
            count: 0,
            elements: Array::new(),
            marks: Array::new(),
            laws: Array::new(),
            states: Array::new(),
            apart_until: Array::new(),
            grips: Array::new(),
            forces: Array::new(),
            energies: Array::new(),
            gathering: 0,
            gathered: Array::new(),
            starts: Array::new(),
            sides: Array::new(),
            sums: Array::new(),
            mosts: Array::new(),
            report: Array::new(),
        }
    }

    /// Blocks of couples.
    fn blocks(&self) -> usize {
        self.count.div_ceil(THREADS)
    }

    /// Takes couples over.
    pub(crate) fn load(
        &mut self,
        device: &impl Device<Memory = M>,
        couples: &CoupleColumns,
        states: &CoupleStates<D>,
    ) -> Result<(), GpuError> {
        let count = couples.elements.len();
        self.count = count;
        self.elements.write(device, couples.elements.as_flattened())?;
        let flag = |set: bool, bit: u32| if set { bit } else { 0 };
        let flags = couples.may_begin.iter().zip(&couples.credits);
        let marks: Vec<u32> =
            flags.map(|(begins, credits)| flag(*begins, MAY_BEGIN) | flag(*credits, CREDITS)).collect();
        self.marks.write(device, &marks)?;
        let laws = columns(&couples.laws, |law| {
            let FlatContact { penalty, friction, tangential, damping, masses, length, weight, fading } = *law;
            [penalty, friction, tangential, damping, masses[0], masses[1], length, weight, fading]
        });
        self.laws.write(device, &laws)?;
        let both = states.touches.iter().zip(&states.overlaps);
        let both = both.map(|(touches, overlap)| flag(*touches, TOUCHES) | u32::from(*overlap) << 1);
        self.states.write(device, &both.collect::<Vec<_>>())?;
        self.apart_until.write(device, &states.apart_until)?;
        let mut grips = vec![0.0; Self::GRIP * count];
        for (couple, grip) in states.grips.iter().enumerate() {
            let vectors = [grip.friction, grip.damping, grip.shares[0], grip.shares[1]];
            let numbers = vectors.into_iter().flatten();
            let numbers = numbers.chain([grip.credited_energy, f64::from(grip.way)]).chain(grip.push);
            for (k, number) in numbers.enumerate() {
                grips[k * count + couple] = number;
            }
        }
        self.grips.write(device, &grips)?;
        self.forces.resize(device, 2 * (D + 1) * D * count)?;
        self.energies.resize(device, count)?;
        self.sums.resize(device, ROWS * self.blocks())?;
        self.mosts.resize(device, self.blocks())?;
        self.report.resize(device, SUM_PARTS * (ROWS * pieces(self.blocks())).max(pieces(count)) + 1)?;
        self.list_sides(device, &couples.elements)
    }

    /// Lists the couples of each element, ascending.
    fn list_sides(
        &mut self,
        device: &impl Device<Memory = M>,
        elements: &[[u32; 2]],
    ) -> Result<(), GpuError> {
        let mut sides: Vec<(u32, u32)> = elements.as_flattened().iter().copied().zip(0..).collect();
        sides.sort_unstable();
        let (mut gathered, mut starts) = (Vec::new(), Vec::new());
        for (place, (element, _)) in (0..).zip(&sides) {
            if gathered.last() != Some(element) {
                gathered.push(*element);
                starts.push(place);
            }
        }
        starts.push(sides.len() as u32);
        self.gathering = gathered.len();
        self.gathered.write(device, &gathered)?;
        self.starts.write(device, &starts)?;
        self.sides.write(device, &sides.into_iter().map(|(_, side)| side).collect::<Vec<_>>())?;
        Ok(())
    }

    /// Whether each couple touches.
    pub(crate) fn touching(&self, device: &impl Device<Memory = M>) -> Result<Vec<bool>, GpuError> {
        let states = self.states.to_vec(device, self.count)?;
        Ok(states.iter().map(|state| state & TOUCHES != 0).collect())
    }

    /// The state of the couples.
    pub(crate) fn read(&self, device: &impl Device<Memory = M>) -> Result<CoupleStates<D>, GpuError> {
        let count = self.count;
        let states = self.states.to_vec(device, count)?;
        let grips = self.grips.to_vec(device, Self::GRIP * count)?;
        let grip = |couple: usize| {
            let number = |k: usize| grips[k * count + couple];
            let vector = |first: usize| std::array::from_fn(|axis| number(first + axis));
            FlatGrip {
                friction: vector(0),
                damping: vector(D),
                shares: [vector(2 * D), vector(3 * D)],
                credited_energy: number(4 * D),
                way: number(4 * D + 1) as u8,
                push: vector(4 * D + 2),
            }
        };
        Ok(CoupleStates {
            touches: states.iter().map(|state| state & TOUCHES != 0).collect(),
            overlaps: states.iter().map(|state| (state >> 1) as u8).collect(),
            apart_until: self.apart_until.to_vec(device, count)?,
            grips: (0..count).map(grip).collect(),
        })
    }

    /// Computes the forces of all couples from the positions and velocities of the nodes of the corners of
    /// elements, and adds them to the forces on corners.
    pub(crate) fn press(
        &self,
        device: &impl Device<Memory = M>,
        [positions, velocities, corners, forces]: [Address; 4],
        press: &Press,
    ) -> Result<PressSums, GpuError> {
        let Press { step, travel, still_ignored, grains, energy } = *press;
        let blocks = self.blocks();
        let arguments = CoupleArguments {
            positions,
            velocities,
            corners,
            elements: self.elements.address(device),
            marks: self.marks.address(device),
            laws: self.laws.address(device),
            states: self.states.address(device),
            apart_until: self.apart_until.address(device),
            grips: self.grips.address(device),
            forces: self.forces.address(device),
            energies: self.energies.address(device),
            sums: self.sums.address(device),
            mosts: self.mosts.address(device),
            grains,
            step,
            travel,
            still_ignored,
            count: self.count as u64,
            blocks: blocks as u64,
        };
        let gathering = CoupleForceArguments {
            elements: self.gathered.address(device),
            starts: self.starts.address(device),
            sides: self.sides.address(device),
            states: arguments.states,
            added: arguments.forces,
            forces,
            count: self.gathering as u64,
        };
        let [pressing, gather] = if D == 2 {
            [Kernel::PressCouples2, Kernel::GatherCouples2]
        } else {
            [Kernel::PressCouples3, Kernel::GatherCouples3]
        };
        launch(device, pressing, self.count, &arguments)?;
        launch(device, gather, self.gathering, &gathering)?;
        let parts = self.report.address(device);
        add_up(device, parts, ROWS, [arguments.sums, blocks as u64])?;
        let rows = SUM_PARTS * ROWS * pieces(blocks);
        let largest = LargestArguments {
            numbers: arguments.mosts,
            largest: parts + (size_of::<u64>() * rows) as u64,
            count: blocks as u64,
        };
        launch_blocks(device, Kernel::LargestNumbers, 1, &largest)?;
        let report = self.report.to_vec(device, rows + 1)?;
        let deep = f64::from_bits(report[rows]) as usize;
        let [friction, damping, handed_over, relaxed, touching] = sums_of(&report[..rows]);
        let mut stored = None;
        if energy {
            add_up(device, parts, 1, [arguments.energies, self.count as u64])?;
            let [sum] = sums_of(&self.report.to_vec(device, SUM_PARTS * pieces(self.count))?);
            stored = Some(sum);
        }
        Ok(PressSums {
            works: [friction, damping, handed_over, relaxed],
            touching,
            energy: stored,
            deep: (deep > 0).then(|| self.count - deep),
        })
    }
}

/// Columns of the numbers of some records.
fn columns<T, const K: usize>(records: &[T], numbers: impl Fn(&T) -> [f64; K]) -> Vec<f64> {
    let rows: Vec<[f64; K]> = records.iter().map(numbers).collect();
    (0..K).flat_map(|k| rows.iter().map(move |row| row[k])).collect()
}

/// Numbers of a couple for [`press_cases`] in `D` dimensions.
#[must_use]
pub const fn contact_numbers(dimensions: usize) -> usize {
    let corners = 2 * dimensions * (dimensions + 1);
    // Corners, velocities and forces; the law; the history; results.
    3 * corners + 10 + (5 * dimensions + 2) + 9
}

/// Computes the contacts of couples of elements, in two or three dimensions: the numbers of each couple in
/// the order of `ContactCase` in the kernels. `step`: time step, s; `still_ignored`: see
/// [`Press`](fdem_simulation::Press).
///
/// # Errors
/// [`GpuError::OutOfMemory`], [`GpuError::Driver`].
///
/// # Panics
/// If the numbers are not those of whole couples.
pub fn press_cases<const D: usize>(
    device: &impl Device,
    numbers: &mut [f64],
    step: f64,
    still_ignored: f64,
) -> Result<(), GpuError> {
    let mut array = Array::new();
    let count = numbers.len() / contact_numbers(D);
    assert_eq!(count * contact_numbers(D), numbers.len(), "whole couples");
    let cases = array.write(device, numbers)?;
    let arguments = ContactCaseArguments { cases, count: count as u64, step, still_ignored };
    let kernel = if D == 2 { Kernel::PressCases2 } else { Kernel::PressCases3 };
    launch(device, kernel, count, &arguments)?;
    array.read(device, 0, numbers)
}
