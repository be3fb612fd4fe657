//! Options of the command: definitions, parsing and help.

mod drawings;
mod simulation;

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Parser, Subcommand, ValueEnum};
use fdem_contact::{Engine, Simd};
use fdem_io::{Columns, CoupleColumns, PackingFormat};
use fdem_scenes::Sizes;

use crate::command::cutoff::{Cutoff, PairCutoff};
use crate::command::device_name::DeviceName;
use crate::command::frames::Frames;
use crate::command::lengths::{length, number};
use crate::command::ranks::version;
pub(crate) use drawings::{DrawingArguments, has_extension};
pub(crate) use simulation::{
    CheckArguments, MOST_RUNS as MOST_RUNS_OF_A_SWEEP, MaterialsArguments, NewArguments, ResumeArguments,
    RunArguments, RunOptions, SweepArguments, ValidateArguments,
};

/// Contact detection and the combined finite-discrete element method.
#[derive(Debug, Parser)]
#[command(name = "fdem", version = version(), max_term_width = 100)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) task: Task,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Task {
    Contacts(Box<ContactsArguments>),
    Bench(BenchArguments),
    Generate(GenerateArguments),
    New(NewArguments),
    Materials(MaterialsArguments),
    Check(CheckArguments),
    Run(RunArguments),
    Resume(ResumeArguments),
    Sweep(SweepArguments),
    Validate(ValidateArguments),
    /// List the processor and the graphics processors on which `fdem contacts` can search.
    Devices,
}

/// Find which elements of a packing, or of meshes, touch.
///
/// Reads circles or spheres from FILE and writes every couple in contact once, as `i,j,distance,overlap`.
/// Elements that just touch are in contact. Elements are named by their ids in the file, or by the number of
/// their data row from 0. Couples are sorted by the rows of their elements.
///
/// Text files: columns are separated by commas, semicolons, tabs or blanks; `#` or `%` starts a comment; a
/// header names the columns (x, PosX[m], X (mm), `x_mm`, radius, diameter, d, id, …). Without a header, 2
/// columns are x y, 3 are x y z, 4 are x y z radius. NumPy .npy arrays of numbers have the same columns.
/// Without z, the packing is 2D.
///
/// Other formats are recognised by their content, or given by --format: dumps and data files of LAMMPS and
/// LIGGGHTS, XYZ and extended XYZ, text of YADE, .data of MercuryDPM, VTK, VTU and VTP with only points and a
/// radius among their data, NumPy .npz with arrays `positions` and `radii`. All files, also meshes, may be
/// compressed by gzip or zstd. If the file says that its box is periodic, the box is periodic,
/// unless --periodic says otherwise.
///
/// A file of several frames is a series: all couples are written to one table (.csv, .npy, .npz or .parquet)
/// that starts with the columns `frame,step` (the step is -1 if the file has none), --json writes an array,
/// and --count prints a line per frame. With `{frame}` in the name of an output, each frame has its own file.
/// See --frames.
///
/// Meshes (Gmsh, STL, OBJ, PLY, VTK, VTU, VTP, Abaqus, tables of triangles) are recognised by their content.
/// Couples are elements of different bodies, written as `i,j,body_i,body_j,kind,measure,x,y,z,nx,ny,nz` with
/// the numbers of the elements in the files. Bodies are numbered from 0 over all files; the JSON summary
/// lists them. If a file has tetrahedra, only these are compared, otherwise its triangles. Triangles compared
/// with tetrahedra of another file are bodies without volume: contacts are found, but their measure is 0, and
/// shared boundary is only found between tetrahedra. Meshes with z = 0 everywhere are 2D. A table of
/// triangles has the columns `vertex1_X` to `vertex3_Z`, separated by blanks or tabs.
///
/// In a periodic box (`--periodic`), elements outside are wrapped into the box, every image in contact
/// counts, and couples also have the columns `sx,sy,sz`: element j, displaced from its position in the file
/// by this number of edges of the box, touches element i at its position in the file.
#[derive(Clone, Debug, Args)]
#[command(after_help = "Example: fdem contacts packing.csv --output couples.csv --json summary.json")]
pub(crate) struct ContactsArguments {
    #[command(flatten)]
    pub(crate) input: InputArguments,

    /// More files: meshes and packings of spheres. Each mesh is a body, unless it contains several; each
    /// sphere is a body.
    #[arg(value_name = "FILE")]
    pub(crate) more: Vec<PathBuf>,

    /// Engine of the search; all engines find the same couples.
    #[arg(long, value_enum, default_value_t = EngineName::Auto)]
    pub(crate) engine: EngineName,

    /// Where the search runs: `cpu`, `gpu`, or `gpu:N` with a number of `fdem devices`. A graphics processor
    /// of NVIDIA finds the couples of the engine rows, of packings.
    #[arg(long, value_name = "DEVICE", default_value = "cpu")]
    pub(crate) device: DeviceName,

    /// Number of threads of the engines rows and multilevel, and of --labels; 0 is one per processor. Couples
    /// and their order do not depend on it.
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) threads: usize,

    /// Elements with the same integer in this column belong to the same body and form no couple. The column
    /// is given by its name, or by its number from 1; without a header, the other columns are counted without
    /// it.
    #[arg(long, value_name = "COLUMN")]
    pub(crate) bodies: Option<String>,

    /// The column of the types for --cutoff by pairs of types: its name, or its number from 1; without a
    /// header, the other columns are counted without it [default: the first of `element`, `species` and
    /// `type` that the file has].
    #[arg(long, value_name = "COLUMN", requires = "cutoff")]
    pub(crate) type_column: Option<String>,

    #[command(flatten)]
    pub(crate) periodic: PeriodicArguments,

    #[command(flatten)]
    pub(crate) couples: CoupleArguments,

    #[command(flatten)]
    pub(crate) meshes: MeshArguments,

    #[command(flatten)]
    pub(crate) labels: LabelArguments,

    #[command(flatten)]
    pub(crate) analysis: AnalyseArguments,

    /// Print an estimate of the search and no couples: engine, cells, rows, images, approximate number of
    /// couples, memory. For levels, also print the counted and the predicted work: windows on rows of cells,
    /// candidates in these windows, couples.
    #[arg(long, conflicts_with_all = ["output", "count", "picture", "plots", "report", "verify", "analyse"])]
    pub(crate) explain: bool,

    /// Write the couples to FILE, in the format of its extension. Without it, couples go to standard output,
    /// or nowhere if --picture, --plots or --report is given; `-` is always standard output. Tables: `.csv`,
    /// `.npy` (records), `.parquet`, and `.npz` with one array per column; for a packing, `i` and `j` in .npz
    /// are rows of `positions`, and `ids` has the ids of the file. ParaView: `.vtp` with centres as points
    /// and couples as lines; lines across a face of the box end at images, which are points with `image` 1;
    /// lines of meshes, and of spheres and walls, lead through the contact point, which has `contact` 1.
    /// Networks of a packing: `.graphml`, and `.json` (networkx from 3.4:
    /// `node_link_graph(data, edges="edges")`).
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    /// Print only the number of couples, and do not store couples.
    #[arg(long, conflicts_with = "output")]
    pub(crate) count: bool,

    /// Write the summary as JSON.
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) drawings: DrawingArguments,

    /// Check the couples of K random elements by brute force; exit code 1 if any differ.
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = at_least_one)]
    pub(crate) verify: Option<usize>,

    /// Print no summary and no progress.
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

impl ContactsArguments {
    /// Whether couples are written: not if only drawings are requested.
    pub(crate) fn writes_couples(&self) -> bool {
        !self.count && (self.output.is_some() || !self.drawings.any())
    }

    /// The cut-offs by pairs of types.
    pub(crate) fn pairs(&self) -> Option<&[PairCutoff]> {
        self.input.cutoff.as_ref()?.pairs()
    }

    /// The columns that options name.
    pub(crate) fn named_columns(&self) -> NamedColumns<'_> {
        NamedColumns { bodies: self.bodies.as_deref(), types: self.type_column.as_deref() }
    }
}

/// Columns of the file that options name.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct NamedColumns<'a> {
    /// The bodies; none are read without it.
    pub(crate) bodies: Option<&'a str>,
    /// The types, in place of the column with a usual name. They are read if the cut-off needs them.
    pub(crate) types: Option<&'a str>,
}

/// Options for a periodic box.
#[derive(Clone, Debug, Args)]
pub(crate) struct PeriodicArguments {
    /// Edges along which the box is periodic, the first edge being x: `x`, `xy`, `xyz`, `z`, … The box is
    /// that of the file, unless --box or --edges gives one. With `none`, the box of the file is not periodic,
    /// whatever the file says.
    #[arg(long, value_name = "AXES", value_parser = axes)]
    pub(crate) periodic: Option<Axes>,

    /// Periodic box with edges along the axes: `X0,X1,Y0,Y1` and in 3D `Z0,Z1`. Axes that are not periodic
    /// also need ascending limits, which are not used.
    #[arg(long = "box", value_name = "LIMITS", allow_hyphen_values = true, value_parser = numbers, requires = "periodic", conflicts_with = "edges")]
    pub(crate) limits: Option<Numbers>,

    /// Sheared box: components of its edges, one edge after the other, 4 numbers in 2D and 9 in 3D.
    #[arg(long, value_name = "VECTORS", allow_hyphen_values = true, value_parser = numbers, requires = "periodic")]
    pub(crate) edges: Option<Numbers>,

    /// Corner at which the edges of a sheared box start [default: 0 along each axis].
    #[arg(long, value_name = "POINT", allow_hyphen_values = true, value_parser = numbers, requires = "edges", conflicts_with = "limits")]
    pub(crate) origin: Option<Numbers>,
}

/// Options for couples from a file.
#[derive(Clone, Debug, Args)]
pub(crate) struct CoupleArguments {
    /// Take the couples, and values such as forces, from FILE in place of a search: a `dump local` of LAMMPS
    /// or LIGGGHTS with the time step of the packing. Its columns are written beside those of the couples.
    /// With forces, lines of pictures and reports are wide and coloured by force, and --analyse also gives
    /// the mean force, the stress of Love and Weber, and strong couples. In a periodic box, couples are with
    /// the nearest image.
    #[arg(long, value_name = "FILE", conflicts_with_all = [
        "labels", "explain", "verify", "bodies", "tolerance", "engine", "more", "skip_bad_lines",
    ])]
    pub(crate) couples: Option<PathBuf>,

    /// Names of the columns of --couples: in order (`i,j,_,fx,fy,fz`; `_` skips a column) or by name or
    /// number (`i=c_id[1],j=c_id[2],force=5`; other columns keep their names). `i` and `j` are ids of
    /// elements; `fx`, `fy`, `fz` are the force on `i` by `j`, or `force` is its part along the line of the
    /// centres, positive for repulsion. Couples are written with `i` before `j` in the packing, and `fx`,
    /// `fy`, `fz` are turned to match; other columns are not changed [default: the names of the file; for i
    /// also id1, patom1, batom1 and atom1, for j likewise].
    #[arg(long, value_name = "LIST", requires = "couples")]
    pub(crate) couple_columns: Option<CoupleColumns>,
}

/// Options for the analysis of the network.
#[derive(Clone, Debug, Args)]
pub(crate) struct AnalyseArguments {
    /// Also analyse the network, briefly in the summary and in full in its JSON: coordination with and
    /// without rattlers, fabric and directions, clusters and percolation, overlaps and gaps, packing
    /// fraction, radial distribution.
    #[arg(long)]
    pub(crate) analyse: bool,

    /// Region in which `--analyse` measures the packing fraction: `X0,X1,Y0,Y1` and in 3D `Z0,Z1` [default:
    /// the domain, shrunk by the largest diameter on both sides along axes that are not periodic].
    #[arg(long, value_name = "LIMITS", allow_hyphen_values = true, value_parser = numbers, requires = "analyse")]
    pub(crate) inner: Option<Numbers>,

    /// Largest distance of the radial distribution of `--analyse`, and its number of bins [default: 3 mean
    /// diameters, or less in small domains; 150].
    #[arg(long, value_name = "R[,BINS]", allow_hyphen_values = true, value_parser = numbers, requires = "analyse")]
    pub(crate) rdf: Option<Numbers>,

    /// For `--analyse`, also measure the voids: local void ratios by radical Voronoi cells, and sizes of
    /// pores. This takes some 20 µs for each element, and many times more where voids are large.
    #[arg(long, requires = "analyse")]
    pub(crate) voids: bool,

    /// For `--analyse`, elements with fewer contacts are rattlers, which are removed repeatedly [default: 3
    /// in 2D and 4 in 3D, as without friction; 2, as with friction, if that removes more than half of the
    /// elements that 2 leaves].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<u32>, requires = "analyse")]
    pub(crate) rattlers: Option<u32>,
}

/// Options for meshes.
#[derive(Clone, Debug, Args)]
pub(crate) struct MeshArguments {
    /// For meshes, also write the bodies that touch to FILE.csv, .npy, .npz or .parquet, as
    /// `i,j,couples,overlap,shared,x,y,z,nx,ny,nz`: number of couples of elements, overlap, shared boundary,
    /// mean place and direction of the contact.
    #[arg(long, value_name = "FILE")]
    pub(crate) body_table: Option<PathBuf>,

    /// For meshes, elements of the same body also form couples, unless they share a node.
    #[arg(long)]
    pub(crate) self_contact: bool,
}

/// Options for labelled images.
#[derive(Clone, Debug, Args)]
pub(crate) struct LabelArguments {
    /// FILE is a 2D or 3D image (NumPy .npy or .npz, or the pages of a TIFF file) in which each number is a
    /// body: find the bodies that touch, with the number and area of the faces that they share, and the mean
    /// place and direction of the contact. x is along the last axis of the array; the origin is the centre of
    /// the first pixel or voxel.
    #[arg(long, conflicts_with_all = [
        "columns", "radius", "cutoff", "tolerance", "format", "frames", "skip_bad_lines", "ignore_ids", "max_memory", "engine", "bodies", "periodic", "limits", "edges",
        "origin", "explain", "verify", "more", "body_table", "self_contact", "analyse",
    ])]
    pub(crate) labels: bool,

    /// Pixels or voxels that are neighbours: `face`: those that share a face (in 2D a side); `edge`: also
    /// those that share an edge (3D only); `vertex`: also those that share a vertex (a corner).
    #[arg(long, value_enum, default_value_t = NeighbourhoodName::Face, requires = "labels")]
    pub(crate) neighbourhood: NeighbourhoodName,

    /// Edge lengths of a pixel or voxel, for areas, places and directions [default: 1 each].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = numbers, requires = "labels")]
    pub(crate) spacing: Option<Numbers>,

    /// Number of the background, which is not a body; `none` if every number is a body.
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true, value_parser = background, default_value = "0", requires = "labels")]
    pub(crate) background: Background,

    /// Name of the array in an .npz file that has several.
    #[arg(long, value_name = "NAME", requires = "labels")]
    pub(crate) member: Option<String>,
}

/// Neighbourhoods by their names on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum NeighbourhoodName {
    Face,
    Edge,
    Vertex,
}

impl NeighbourhoodName {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Face => "face",
            Self::Edge => "edge",
            Self::Vertex => "vertex",
        }
    }
}

/// Label of the background, if there is one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Background(pub(crate) Option<i128>);

/// Edges x, y and z that are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Axes(pub(crate) [bool; 3]);

/// Numbers separated by commas.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Numbers(pub(crate) Vec<f64>);

/// Options for the input and its elements.
#[derive(Clone, Debug, Args)]
pub(crate) struct InputArguments {
    /// Packing or mesh to read; `-` reads standard input.
    pub(crate) file: PathBuf,

    /// Meaning of the columns: in order (`radius,x,y,z`; `_` skips a column) or by name
    /// (`x=PosX[m],y=PosY[m],radius=R`).
    #[arg(long, value_name = "LIST")]
    pub(crate) columns: Option<Columns>,

    /// Radius of all elements, in place of the radii in the file.
    #[arg(long, value_name = "R", allow_negative_numbers = true, value_parser = length, conflicts_with = "cutoff")]
    pub(crate) radius: Option<f64>,

    /// The elements are points, and couples are those at a distance of at most D. `fdem contacts` also takes
    /// a distance for each pair of types, `H-C=1.3,C-C=1.9`: pairs that are not listed form no couple.
    #[arg(long, value_name = "D", allow_negative_numbers = true, value_parser = Cutoff::from_str)]
    pub(crate) cutoff: Option<Cutoff>,

    /// Largest gap that counts as contact, in the unit of the file.
    #[arg(long, value_name = "T", allow_negative_numbers = true, value_parser = length, default_value_t = 0.0)]
    pub(crate) tolerance: f64,

    /// Format of FILE, in place of the recognised one: `text`, `npy`, `npz`, `lammps-dump`, `lammps-data`,
    /// `xyz`, `mercury`, `vtk` (the points of a legacy file) or `vtk-xml` (the points of VTU and VTP).
    #[arg(long, value_name = "NAME", value_parser = PackingFormat::from_str)]
    pub(crate) format: Option<PackingFormat>,

    /// Frames of FILE, counted from 0, as Python indices or slices: `7`, `-1` for the last, `0:100:10` for
    /// every tenth of the first 100 [default: all]. With one number, outputs are those of a single packing;
    /// with a slice, those of a series.
    #[arg(long, value_name = "START:STOP:STEP", allow_hyphen_values = true, value_parser = Frames::from_str)]
    pub(crate) frames: Option<Frames>,

    /// Skip lines that cannot be read and report them, instead of stopping at the first.
    #[arg(long)]
    pub(crate) skip_bad_lines: bool,

    /// Most memory that FILE may take, with its elements, as estimated from its size before it is read, or
    /// from its content if it is compressed: bytes, or a number with kB, MB, GB or TB, such as `8GB`
    /// [default: three quarters of the memory of the machine, or of the limit of the process].
    #[arg(long, value_name = "SIZE", value_parser = memory)]
    pub(crate) max_memory: Option<u64>,

    /// Number the elements by data row even if the file has a column of ids. (`--columns` without `id` has
    /// the same effect.)
    #[arg(long)]
    pub(crate) ignore_ids: bool,
}

/// Engines by their names on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum EngineName {
    /// An engine chosen for the elements; the summary names it and the reason.
    Auto,
    /// All pairs are compared.
    Direct,
    /// Munjiza-NBS as published: linear in the number of elements, for similar sizes.
    Nbs,
    /// The cells of Munjiza-NBS in sorted rows, with vector instructions: many times as fast, in any domain.
    Rows,
    /// As rows, for unlike sizes: elements are divided into levels of similar sizes, each with its own rows.
    Multilevel,
    /// The C-grid of Williams, Perkins and Cook: elements that span many cells.
    #[value(name = "cgrid")]
    CGrid,
}

impl EngineName {
    /// The engine; `None` to choose one.
    pub(crate) fn engine(self) -> Option<Engine> {
        Some(match self {
            Self::Auto => return None,
            Self::Direct => Engine::Direct,
            Self::Nbs => Engine::Nbs,
            Self::Rows => Engine::Rows,
            Self::Multilevel => Engine::Multilevel,
            Self::CGrid => Engine::CGrid,
        })
    }
}

/// Time the engines on your packing.
///
/// The time is that of a detection from coordinates in memory to couples in memory. It includes the checks of
/// the elements, but not reading the file. Each engine runs once to warm up, then they take turns. Engines
/// keep their memory between runs.
#[derive(Debug, Args)]
#[command(after_help = "Example: fdem bench packing.csv --engines rows,direct --json timings.json")]
pub(crate) struct BenchArguments {
    #[command(flatten)]
    pub(crate) input: InputArguments,

    /// Engines to time [default: rows, multilevel for unlike sizes, nbs, and direct for up to 50,000
    /// elements].
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',')]
    pub(crate) engines: Option<Vec<Contestant>>,

    /// Also time the search on a graphics processor, `gpu` or `gpu:N` with a number of `fdem devices`, as the
    /// first row: with the copies of elements and couples, in memory that it keeps.
    #[arg(long, value_name = "DEVICE", default_value = "cpu")]
    pub(crate) device: DeviceName,

    /// Vector instructions of the engines rows and multilevel.
    #[arg(long, value_enum, default_value_t = SimdName::Auto)]
    pub(crate) simd: SimdName,

    /// Numbers of threads to time for the engines rows and multilevel; 0 is one per processor. The other
    /// engines have one thread.
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "1", allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) threads: Vec<usize>,

    /// Number of timed runs of each engine.
    #[arg(long, value_name = "K", default_value_t = 7, allow_negative_numbers = true, value_parser = runs)]
    pub(crate) repeat: usize,

    /// Write the timings as JSON, with one object per row of the table.
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
}

/// Engines that can be timed, by their names on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Contestant {
    /// The default engine for similar sizes: sorted rows with vector instructions.
    Rows,
    /// The default engine for unlike sizes: levels of similar sizes.
    Multilevel,
    /// The C-grid of Williams, Perkins and Cook: elements that span many cells.
    #[value(name = "cgrid")]
    CGrid,
    /// Munjiza-NBS as published.
    Nbs,
    /// All pairs are compared.
    Direct,
}

/// Vector instructions by their names on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SimdName {
    /// The fastest that this processor has.
    Auto,
    /// None: plain Rust.
    Portable,
    /// x86-64.
    Avx2,
    /// x86-64.
    Avx512,
    /// 64-bit ARM.
    Neon,
}

impl From<SimdName> for Simd {
    fn from(name: SimdName) -> Self {
        match name {
            SimdName::Auto => Self::best(),
            SimdName::Portable => Self::Portable,
            SimdName::Avx2 => Self::Avx2,
            SimdName::Avx512 => Self::Avx512,
            SimdName::Neon => Self::Neon,
        }
    }
}

/// Generate a packing. The same seed gives the same file on every platform.
#[derive(Debug, Args)]
#[command(after_help = "Example: fdem generate gas -n 100000 --neighbours 12 --output gas.csv")]
pub(crate) struct GenerateArguments {
    #[command(subcommand)]
    pub(crate) kind: PackingKind,
}

#[derive(Debug, Subcommand)]
pub(crate) enum PackingKind {
    /// Uniformly random centres.
    Gas {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        dims: Dims,
        #[command(flatten)]
        seed: Seed,
        #[command(flatten)]
        sizes: SizesArgument,
        /// Mean number of contacts of an element.
        #[arg(long, value_name = "Z", default_value_t = 6.0, allow_negative_numbers = true, value_parser = positive)]
        neighbours: f64,
    },
    /// A square (cubic) lattice, filled row by row.
    Lattice {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        dims: Dims,
        /// Radius of every element.
        #[arg(long, value_name = "R", default_value_t = 0.5, allow_negative_numbers = true, value_parser = positive)]
        radius: f64,
        /// Spacing, in diameters; at 1, neighbours touch exactly.
        #[arg(long, value_name = "S", default_value_t = 1.0, allow_negative_numbers = true, value_parser = positive)]
        spacing: f64,
    },
    /// A lattice whose elements are displaced randomly.
    Jittered {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        dims: Dims,
        #[command(flatten)]
        seed: Seed,
        #[command(flatten)]
        sizes: SizesArgument,
        /// Spacing of the lattice, in mean diameters.
        #[arg(long, value_name = "S", default_value_t = 1.0, allow_negative_numbers = true, value_parser = positive)]
        spacing: f64,
        /// Largest displacement along each axis, in spacings.
        #[arg(long, value_name = "J", default_value_t = 0.2, allow_negative_numbers = true, value_parser = length)]
        jitter: f64,
    },
    /// Small gases scattered in a large empty domain.
    Clusters {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        dims: Dims,
        #[command(flatten)]
        seed: Seed,
        #[command(flatten)]
        sizes: SizesArgument,
        /// Elements per cluster.
        #[arg(long, value_name = "M", default_value_t = 1000)]
        per_cluster: usize,
        /// Edge of the domain, in mean diameters.
        #[arg(long, value_name = "W", default_value_t = 1e5, allow_negative_numbers = true, value_parser = positive)]
        domain: f64,
        /// Mean number of contacts of an element inside a cluster.
        #[arg(long, value_name = "Z", default_value_t = 1.0, allow_negative_numbers = true, value_parser = positive)]
        neighbours: f64,
    },
    /// 2D discs dropped one by one into a box, each rolling to rest on the earlier ones.
    Deposit {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        seed: Seed,
        #[command(flatten)]
        sizes: SizesArgument,
        /// Width of the box, in the unit of the radii.
        #[arg(long, value_name = "W", default_value_t = 30.0, allow_negative_numbers = true, value_parser = positive)]
        width: f64,
        /// Shrinks the coordinates by this fraction, so that resting discs overlap as under load.
        #[arg(long, value_name = "C", default_value_t = 1e-3, allow_negative_numbers = true, value_parser = length)]
        compression: f64,
    },
    /// A packing of the examples in the book, with the diameter 1: A dense; B spaced along x; C spaced along
    /// all axes; D pairs spaced along x.
    Book {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        dims: Dims,
        /// Packing of the book.
        #[arg(long, value_enum)]
        packing: BookPacking,
        /// Spacing of packings B, C and D, in diameters [default: 2].
        #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = positive)]
        spacing: Option<f64>,
    },
}

#[derive(Debug, Args)]
pub(crate) struct Common {
    /// Number of elements.
    #[arg(long, short = 'n', value_name = "N", default_value_t = 1000, allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) elements: usize,
    /// Write to FILE.csv or FILE.npy instead of standard output.
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct Seed {
    /// Seed of the random numbers.
    #[arg(long, value_name = "S", default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>)]
    pub(crate) seed: u64,
}

#[derive(Debug, Args)]
pub(crate) struct Dims {
    /// 2 for discs, 3 for spheres.
    #[arg(long, value_name = "D", default_value_t = 3, value_parser = clap::value_parser!(u8).range(2..=3))]
    pub(crate) dims: u8,
}

#[derive(Debug, Args)]
pub(crate) struct SizesArgument {
    /// Radii: `equal:R`, `power:MIN:MAX:EXPONENT` or `lognormal:MEDIAN:SIGMA`.
    #[arg(long, value_name = "LAW", default_value = "equal:0.5", value_parser = sizes)]
    pub(crate) sizes: Sizes,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum BookPacking {
    A,
    B,
    C,
    D,
}

/// Reads a finite number above zero.
fn positive(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    if value > 0.0 { Ok(value) } else { Err(format!("'{text}' is not above zero")) }
}

/// Reads a number of bytes, with or without a unit.
fn memory(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|letter: char| letter.is_ascii_alphabetic());
    let unit = match text[digits.len()..].to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "k" | "kb" => 1e3,
        "m" | "mb" => 1e6,
        "g" | "gb" => 1e9,
        "t" | "tb" => 1e12,
        "kib" => 1024.0,
        "mib" => 1_048_576.0,
        "gib" => 1_073_741_824.0,
        unit => return Err(format!("'{unit}' is no unit of memory: say kB, MB, GB or TB")),
    };
    positive(digits.trim_end()).map(|number| (number * unit) as u64)
}

fn numbers(text: &str) -> Result<Numbers, String> {
    text.split(',').map(|text| number(text.trim())).collect::<Result<_, _>>().map(Numbers)
}

fn background(text: &str) -> Result<Background, String> {
    if text == "none" {
        return Ok(Background(None));
    }
    let number = text.parse().map_err(|_| format!("'{text}' is neither a whole number nor none"))?;
    Ok(Background(Some(number)))
}

/// Reads the letters of axes, each at most once, or `none`.
fn axes(text: &str) -> Result<Axes, String> {
    let mut axes = [false; 3];
    if text == "none" {
        return Ok(Axes(axes));
    }
    for letter in text.chars() {
        let axis = "xyz".find(letter).ok_or_else(|| format!("'{letter}' is not one of x, y, z"))?;
        if std::mem::replace(&mut axes[axis], true) {
            return Err(format!("{letter} is given twice"));
        }
    }
    if text.is_empty() { Err("no axis is given".to_owned()) } else { Ok(Axes(axes)) }
}

fn whole<N: FromStr>(text: &str) -> Result<N, String> {
    text.parse().map_err(|_| format!("'{text}' is not a whole number of at least 0, or is too large"))
}

fn at_least_one(text: &str) -> Result<usize, String> {
    whole(text).and_then(|value| {
        if value == 0 { Err("checking 0 elements checks nothing".to_owned()) } else { Ok(value) }
    })
}

fn runs(text: &str) -> Result<usize, String> {
    whole(text)
        .and_then(|value| if value == 0 { Err("0 runs measure nothing".to_owned()) } else { Ok(value) })
}

fn sizes(text: &str) -> Result<Sizes, String> {
    let (law, parameters) = text.split_once(':').unwrap_or((text, ""));
    let parameters: Vec<&str> = parameters.split(':').collect();
    match (law, parameters.as_slice()) {
        ("equal", &[radius]) => Ok(Sizes::Equal { radius: number(radius)? }),
        ("power", &[min, max, exponent]) => {
            Ok(Sizes::PowerLaw { min: number(min)?, max: number(max)?, exponent: number(exponent)? })
        }
        ("lognormal", &[median, sigma]) => {
            Ok(Sizes::Lognormal { median: number(median)?, sigma: number(sigma)? })
        }
        _ => Err("expected equal:R, power:MIN:MAX:EXPONENT or lognormal:MEDIAN:SIGMA".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_options_are_consistent() {
        use clap::CommandFactory;
        Arguments::command().debug_assert();
    }

    #[test]
    fn numbers_say_what_is_wrong() {
        assert_eq!(length("0"), Ok(0.0));
        assert_eq!(length("-1"), Err("'-1' is negative".to_owned()));
        assert_eq!(positive("0"), Err("'0' is not above zero".to_owned()));
        assert_eq!(length("nan"), Err("'nan' is not a finite number".to_owned()));
        assert_eq!(length("0,5"), Err("'0,5' has a decimal comma: use a point".to_owned()));
    }

    #[test]
    fn sizes_of_memory_are_read() {
        assert_eq!(memory("1500"), Ok(1500));
        assert_eq!(memory("1.5GB"), Ok(1_500_000_000));
        assert_eq!(memory("2 gib"), Ok(2_147_483_648));
        assert_eq!(memory("0"), Err("'0' is not above zero".to_owned()));
        assert_eq!(memory("1pb"), Err("'pb' is no unit of memory: say kB, MB, GB or TB".to_owned()));
    }

    #[test]
    fn axes_and_lists_of_numbers_are_read() {
        assert_eq!(axes("zx"), Ok(Axes([true, false, true])));
        assert_eq!(axes("none"), Ok(Axes([false; 3])));
        assert_eq!(axes("xw"), Err("'w' is not one of x, y, z".to_owned()));
        assert_eq!(axes("xx"), Err("x is given twice".to_owned()));
        assert_eq!(axes(""), Err("no axis is given".to_owned()));
        assert_eq!(numbers("-1, 2e3"), Ok(Numbers(vec![-1.0, 2000.0])));
        assert_eq!(numbers("1,,2"), Err("'' is not a number".to_owned()));
        assert_eq!(numbers("1,inf"), Err("'inf' is not a finite number".to_owned()));
    }

    #[test]
    fn size_laws_are_read() {
        assert_eq!(sizes("power:1:50:-2.5"), Ok(Sizes::PowerLaw { min: 1.0, max: 50.0, exponent: -2.5 }));
        assert_eq!(sizes("lognormal:0.5:0.25"), Ok(Sizes::Lognormal { median: 0.5, sigma: 0.25 }));
        for bad in ["", "equal", "equal:1:2", "power:1:2", "uniform:1:2", "equal:x"] {
            assert!(sizes(bad).is_err(), "{bad}");
        }
    }
}
