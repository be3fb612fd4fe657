//! The kernels and their arguments, as `kernels/*.h` have them.

use bytemuck::{Pod, Zeroable};

/// Threads of a block.
pub const THREADS: usize = 256;

/// Numbers that a thread adds up.
pub(crate) const SCANNED: usize = 16;

/// Bits of a digit of a key, and keys that a thread moves.
pub(crate) const DIGIT_BITS: u32 = 4;
pub(crate) const SORTED: usize = 8;

/// The kernels, and a macro that calls another one with their names.
macro_rules! kernels {
    ($($kernel:ident = $name:ident,)*) => {
        /// A kernel.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Kernel {
            $(
                #[doc = concat!("`", stringify!($name), "`")]
                $kernel,
            )*
        }

        impl Kernel {
            /// All kernels.
            pub const ALL: &[Self] = &[$(Self::$kernel),*];

            /// The name of the kernel in the text.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$kernel => stringify!($name),)*
                }
            }
        }
    };
}

kernels! {
    ScanBlocks = scan_blocks,
    ScanSums = scan_sums,
    Scan = scan,
    SortCount = sort_count,
    SortMove = sort_move,
    RowKeys = row_keys,
    RowRanks = row_ranks,
    RowGather = row_gather,
    RowStarts = row_starts,
    RowNeighbours = row_neighbours,
    CellHeads = cell_heads,
    GatherWords = gather_words,
    CountPairs2 = count_pairs_2,
    CountPairs3 = count_pairs_3,
    ListPairs2 = list_pairs_2,
    ListPairs3 = list_pairs_3,
    CountPairs2Single = count_pairs_2_single,
    CountPairs3Single = count_pairs_3_single,
    ListPairs2Single = list_pairs_2_single,
    ListPairs3Single = list_pairs_3_single,
    CountCrosses2 = count_crosses_2,
    CountCrosses3 = count_crosses_3,
    ListCrosses2 = list_crosses_2,
    ListCrosses3 = list_crosses_3,
    CountCrosses2Single = count_crosses_2_single,
    CountCrosses3Single = count_crosses_3_single,
    ListCrosses2Single = list_crosses_2_single,
    ListCrosses3Single = list_crosses_3_single,
    ListKeys = list_keys,
    ListStarts = list_starts,
    ListEntries = list_entries,
    ExtremesOfBlocks = extremes_of_blocks,
    ExtremesOfAll = extremes_of_all,
    SamplePoints = sample_points,
    ExactSums = exact_sums,
    LargestNumbers = largest_numbers,
    DeformTriangles = deform_triangles,
    DeformTetrahedra = deform_tetrahedra,
    SoftenEnds2 = soften_ends_2,
    SoftenEnds3 = soften_ends_3,
    Exponentials = exponentials,
    PullJoints2 = pull_joints_2,
    PullJoints3 = pull_joints_3,
    PressCouples2 = press_couples_2,
    PressCouples3 = press_couples_3,
    GatherCouples2 = gather_couples_2,
    GatherCouples3 = gather_couples_3,
    PressCases2 = press_cases_2,
    PressCases3 = press_cases_3,
    SolidDeform2 = solid_deform_2,
    SolidDeform3 = solid_deform_3,
    AddForces2 = add_forces_2,
    AddForces3 = add_forces_3,
    GatherRows2 = gather_rows_2,
    GatherRows3 = gather_rows_3,
    SolidMove2 = solid_move_2,
    SolidMove3 = solid_move_3,
    MoveRows = move_rows,
    ListMarked = list_marked,
}

/// The text of all kernels, for the compiler of a device.
pub fn source() -> String {
    let files = [
        include_str!("../kernels/platform.h"),
        include_str!("../kernels/scan.h"),
        include_str!("../kernels/sort.h"),
        include_str!("../kernels/rows.h"),
        include_str!("../kernels/pairs.h"),
        include_str!("../kernels/lists.h"),
        include_str!("../kernels/extremes.h"),
        include_str!("../kernels/sums.h"),
        include_str!("../kernels/laws.h"),
        include_str!("../kernels/joints.h"),
        include_str!("../kernels/watch.h"),
        include_str!("../kernels/patch.h"),
        include_str!("../kernels/contact.h"),
        include_str!("../kernels/step.h"),
    ];
    let lines = files.iter().flat_map(|file| file.lines());
    let own = |line: &&str| !line.starts_with("#include \"") && !line.starts_with("#pragma once");
    lines.filter(own).flat_map(|line| [line, "\n"]).collect()
}

/// The place of an array in the memory of a device.
pub(crate) type Address = u64;

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ScanArguments {
    pub(crate) numbers: Address,
    pub(crate) sums: Address,
    pub(crate) before: Address,
    pub(crate) count: u64,
    pub(crate) blocks: u64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct SortArguments {
    pub(crate) keys: Address,
    pub(crate) ids: Address,
    pub(crate) sorted_keys: Address,
    pub(crate) sorted_ids: Address,
    pub(crate) counts: Address,
    pub(crate) before: Address,
    pub(crate) count: u64,
    pub(crate) blocks: u32,
    pub(crate) shift: u32,
}

/// The numbers of [`RowCells`](fdem_contact::RowCells).
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Cells {
    pub(crate) origin: [f64; 3],
    pub(crate) inverse: f64,
    pub(crate) axes: [u32; 3],
    pub(crate) unused: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct KeyArguments {
    pub(crate) points: Address,
    pub(crate) keys: Address,
    pub(crate) ids: Address,
    pub(crate) cells: Cells,
    pub(crate) kind: u32,
    pub(crate) first: u32,
    pub(crate) place_bits: u32,
    pub(crate) dimensions: u32,
    pub(crate) second: u64,
    pub(crate) count: u64,
    pub(crate) single: u32,
    pub(crate) unused: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct RankArguments {
    pub(crate) points: Address,
    pub(crate) keys: Address,
    pub(crate) ids: Address,
    pub(crate) ranked: Address,
    pub(crate) crowded: Address,
    pub(crate) count: u64,
    pub(crate) dimensions: u32,
    pub(crate) axis: u32,
    pub(crate) single: u32,
    pub(crate) unused: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GatherArguments {
    pub(crate) points: Address,
    pub(crate) radii: Address,
    pub(crate) ids: Address,
    pub(crate) coordinates: Address,
    pub(crate) sorted_radii: Address,
    pub(crate) heads: Address,
    pub(crate) cells: Cells,
    pub(crate) count: u64,
    pub(crate) dimensions: u32,
    pub(crate) single: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct StartArguments {
    pub(crate) coordinates: Address,
    pub(crate) heads: Address,
    pub(crate) before: Address,
    pub(crate) row_of: Address,
    pub(crate) starts: Address,
    pub(crate) rows: Address,
    pub(crate) cells: Cells,
    pub(crate) count: u64,
    pub(crate) dimensions: u32,
    pub(crate) single: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct NeighbourArguments {
    pub(crate) rows: Address,
    pub(crate) neighbours: Address,
    pub(crate) count: u64,
    pub(crate) mask: u32,
    pub(crate) unused: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ListKeyArguments {
    pub(crate) couples: Address,
    pub(crate) keys: Address,
    pub(crate) ids: Address,
    pub(crate) couple_count: u64,
    pub(crate) count: u64,
    pub(crate) bits: u32,
    pub(crate) unused: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ListStartArguments {
    pub(crate) keys: Address,
    pub(crate) starts: Address,
    pub(crate) entries: u64,
    pub(crate) count: u64,
    pub(crate) bits: u32,
    pub(crate) unused: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ListEntryArguments {
    pub(crate) keys: Address,
    pub(crate) points: Address,
    pub(crate) neighbours: Address,
    pub(crate) distances: Address,
    pub(crate) count: u64,
    pub(crate) bits: u32,
    pub(crate) dimensions: u32,
    pub(crate) single: u32,
    pub(crate) unused: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct DeformArguments {
    pub(crate) states: Address,
    pub(crate) forces: Address,
    pub(crate) count: u64,
    pub(crate) has_initial: u32,
    pub(crate) is_viscous: u32,
    pub(crate) is_bedded: u32,
    pub(crate) unused: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ExactSumArguments {
    pub(crate) numbers: Address,
    pub(crate) parts: Address,
    pub(crate) count: u64,
    pub(crate) pieces: u32,
    pub(crate) unused: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct LargestArguments {
    pub(crate) numbers: Address,
    pub(crate) largest: Address,
    pub(crate) count: u64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct SolidElementArguments {
    pub(crate) positions: Address,
    pub(crate) velocities: Address,
    pub(crate) corners: Address,
    pub(crate) gradients: Address,
    pub(crate) volumes: Address,
    pub(crate) materials: Address,
    pub(crate) moduli: Address,
    pub(crate) beddings: Address,
    pub(crate) normals: Address,
    pub(crate) initial: Address,
    pub(crate) stored: Address,
    pub(crate) viscosities: Address,
    pub(crate) viscous: Address,
    pub(crate) dissipated: Address,
    pub(crate) forces: Address,
    pub(crate) stresses: Address,
    pub(crate) energies: Address,
    pub(crate) inverted: Address,
    pub(crate) step: f64,
    pub(crate) count: u64,
    pub(crate) watched: WatchArguments,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct WatchArguments {
    pub(crate) noted: Address,
    pub(crate) limits: Address,
    pub(crate) moved: Address,
    pub(crate) awake: Address,
    pub(crate) any_awake: Address,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct MovedRowArguments {
    pub(crate) from: Address,
    pub(crate) to: Address,
    pub(crate) from_rows: Address,
    pub(crate) to_rows: Address,
    pub(crate) from_stride: u64,
    pub(crate) to_stride: u64,
    pub(crate) rows: u64,
    pub(crate) columns: u64,
    pub(crate) words: u64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct MarkedArguments {
    pub(crate) marks: Address,
    pub(crate) before: Address,
    pub(crate) list: Address,
    pub(crate) count: u64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GatheredArguments {
    pub(crate) values: Address,
    pub(crate) numbers: Address,
    pub(crate) gathered: Address,
    pub(crate) count: u64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct CornerForceArguments {
    pub(crate) corners: Address,
    pub(crate) starts: Address,
    pub(crate) added: Address,
    pub(crate) forces: Address,
    pub(crate) count: u64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct SolidNodeArguments {
    pub(crate) positions: Address,
    pub(crate) velocities: Address,
    pub(crate) masses: Address,
    pub(crate) true_masses: Address,
    pub(crate) ranges: Address,
    pub(crate) corners: Address,
    pub(crate) forces: Address,
    pub(crate) ends: Address,
    pub(crate) of_joints: Address,
    pub(crate) places: Address,
    pub(crate) held: Address,
    pub(crate) drives: Address,
    pub(crate) reactions: Address,
    pub(crate) sums: Address,
    pub(crate) mosts: Address,
    pub(crate) runaway: Address,
    pub(crate) gravity: [f64; 3],
    pub(crate) origin: [f64; 3],
    pub(crate) grains: [f64; 2],
    pub(crate) step: f64,
    pub(crate) local_damping: f64,
    pub(crate) relaxation: f64,
    pub(crate) speed_limit: f64,
    pub(crate) count: u64,
    pub(crate) energy: u32,
    pub(crate) taken: [u32; 2],
    pub(crate) blocks: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct NumberArguments {
    pub(crate) numbers: Address,
    pub(crate) count: u64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct CoupleArguments {
    pub(crate) positions: Address,
    pub(crate) velocities: Address,
    pub(crate) corners: Address,
    pub(crate) elements: Address,
    pub(crate) marks: Address,
    pub(crate) laws: Address,
    pub(crate) states: Address,
    pub(crate) apart_until: Address,
    pub(crate) grips: Address,
    pub(crate) forces: Address,
    pub(crate) energies: Address,
    pub(crate) sums: Address,
    pub(crate) mosts: Address,
    pub(crate) grains: [f64; 2],
    pub(crate) step: f64,
    pub(crate) travel: f64,
    pub(crate) still_ignored: f64,
    pub(crate) count: u64,
    pub(crate) blocks: u64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct CoupleForceArguments {
    pub(crate) elements: Address,
    pub(crate) starts: Address,
    pub(crate) sides: Address,
    pub(crate) states: Address,
    pub(crate) added: Address,
    pub(crate) forces: Address,
    pub(crate) count: u64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ContactCaseArguments {
    pub(crate) cases: Address,
    pub(crate) count: u64,
    pub(crate) step: f64,
    pub(crate) still_ignored: f64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct JointArguments {
    pub(crate) positions: Address,
    pub(crate) velocities: Address,
    pub(crate) nodes: Address,
    pub(crate) marks: Address,
    pub(crate) laws: Address,
    pub(crate) memories: Address,
    pub(crate) forces: Address,
    pub(crate) left: Address,
    pub(crate) any_left: Address,
    pub(crate) elastic: Address,
    pub(crate) sums: Address,
    pub(crate) grains: [f64; 2],
    pub(crate) step: f64,
    pub(crate) count: u64,
    pub(crate) blocks: u64,
    pub(crate) stride: u64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct CellHeadArguments {
    pub(crate) coordinates: Address,
    pub(crate) heads: Address,
    pub(crate) cell_heads: Address,
    pub(crate) cells: Cells,
    pub(crate) count: u64,
    pub(crate) single: u32,
    pub(crate) unused: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GatherWordArguments {
    pub(crate) words: Address,
    pub(crate) ids: Address,
    pub(crate) sorted: Address,
    pub(crate) count: u64,
}

/// Elements in their order.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct SetArguments {
    pub(crate) coordinates: Address,
    pub(crate) radii: Address,
    pub(crate) ids: Address,
    /// Bodies, firsts, seconds of [`FilterNumbers`](fdem_contact::FilterNumbers).
    pub(crate) labels: [Address; 3],
    pub(crate) count: u64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct PairArguments {
    pub(crate) own: SetArguments,
    pub(crate) other: SetArguments,
    pub(crate) matrix: Address,
    pub(crate) words: u64,
    pub(crate) counts: Address,
    pub(crate) before: Address,
    pub(crate) couples: Address,
    pub(crate) reach: f64,
    pub(crate) reach_squared: f64,
    pub(crate) tolerance: f64,
    pub(crate) axis: u64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct OneSetArguments {
    pub(crate) pairs: PairArguments,
    pub(crate) row_of: Address,
    pub(crate) starts: Address,
    pub(crate) neighbours: Address,
    pub(crate) mask: u64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct TwoSetArguments {
    pub(crate) pairs: PairArguments,
    pub(crate) starts: Address,
    pub(crate) rows: Address,
    pub(crate) row_count: u64,
    pub(crate) cells: Cells,
    pub(crate) last: [f64; 3],
}

/// Extremes of elements, and the first number that is refused.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Extremes {
    pub(crate) min: [f64; 3],
    pub(crate) max: [f64; 3],
    pub(crate) radii: [f64; 2],
    pub(crate) wrong_number: u64,
    pub(crate) wrong_radius: u64,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ExtremesArguments {
    pub(crate) points: Address,
    pub(crate) radii: Address,
    pub(crate) extremes: Address,
    pub(crate) count: u64,
    pub(crate) blocks: u64,
    pub(crate) limit: f64,
    pub(crate) dimensions: u32,
    pub(crate) single: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct SampleArguments {
    pub(crate) points: Address,
    pub(crate) sample: Address,
    pub(crate) count: u64,
    pub(crate) step: u64,
    pub(crate) dimensions: u32,
    pub(crate) single: u32,
}
