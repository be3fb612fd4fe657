//! `fdem contacts` on several ranks: each reads its rows of the packing, all search together, and each writes
//! its rows of the couples.

use std::fmt;
use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::time::Instant;

use fdem_contact::{Couple, PeriodicBox, PeriodicCouple, Real};
use fdem_distributed::{Communicator, DistributedSearch, Message, Shapes};
use fdem_io::{Centres, NpyRows, PackingFormat, ReadError, ReadOptions, SimulationBox};
use fdem_results::network::{Couples, Network, Sizes, Space};

use crate::command::args::ContactsArguments;
use crate::command::cutoff::Cutoff;
use crate::command::device_name::DeviceName;
use crate::command::failure::{Failure, display_name};
use crate::command::input::{self, Input, unreadable};
use crate::command::output::{Output, TableFormat, is_stdout, refuse_to_overwrite};
use crate::command::outputs::show;
use crate::command::periodic::periodic_box;
use crate::command::progress::{Position, Progress};
use crate::command::ranks::{agree, first_unlike, gather_counts, u64_from};
use crate::command::ranks_file::SharedFile;
use crate::command::summary::grouped;
use crate::command::tables::couples_with_ids;

/// Elements of a rank: consecutive rows of the packing.
struct RankPart<const D: usize> {
    /// First element of each rank, and the number of all elements.
    starts: Vec<u64>,
    centres: Vec<[f64; D]>,
    /// Empty if the file has no radii.
    radii: Vec<f64>,
    /// Ids of the file, or numbers of rows.
    ids: Vec<i64>,
    has_radii: bool,
    cell: Option<SimulationBox>,
}

/// Elements of a rank as they are read.
struct Rows {
    centres: Centres,
    radii: Option<Vec<f64>>,
    ids: Vec<i64>,
    cell: Option<SimulationBox>,
}

/// Finds the contacts of a packing. Collective: all ranks return the same failure.
pub(crate) fn run(arguments: &ContactsArguments, communicator: &dyn Communicator) -> Result<(), Failure> {
    refuse(arguments, communicator.size())?;
    let progress = Progress::new(arguments.quiet || communicator.rank() > 0);
    let start = Instant::now();
    let mut output = SharedFile::open(arguments, communicator)?;
    let (rows, name) = read(arguments, communicator, &progress)?;
    match rows.centres {
        Centres::Two(centres) => {
            let part = RankPart::new(communicator, centres, rows.radii, rows.ids, rows.cell);
            find(arguments, communicator, &progress, (&name, start), &part, &mut output)
        }
        Centres::Three(centres) => {
            let part = RankPart::new(communicator, centres, rows.radii, rows.ids, rows.cell);
            find(arguments, communicator, &progress, (&name, start), &part, &mut output)
        }
    }?
    .tell(output, arguments, communicator)
}

/// Refuses options that need all elements or all couples in one process.
fn refuse(arguments: &ContactsArguments, ranks: usize) -> Result<(), Failure> {
    let drawings = arguments.drawings.files();
    let unusable = [
        ("--labels", arguments.labels.labels),
        ("several files", !arguments.more.is_empty()),
        ("--body-table", arguments.meshes.body_table.is_some()),
        ("--self-contact", arguments.meshes.self_contact),
        ("--bodies", arguments.bodies.is_some()),
        ("--couples", arguments.couples.couples.is_some()),
        ("--cutoff by pairs of types", arguments.pairs().is_some()),
        ("--explain", arguments.explain),
        ("--device", arguments.device != DeviceName::Cpu),
        ("--verify", arguments.verify.is_some()),
        ("--analyse", arguments.analysis.analyse),
        ("--json", arguments.json.is_some()),
    ];
    let drawn = drawings.into_iter().map(|(option, file)| (option, file.is_some()));
    if let Some((option, _)) = unusable.into_iter().chain(drawn).find(|(_, given)| *given) {
        let advice = "start it without the launcher";
        return Err(Failure::Unusable(format!(
            "{option} works in one process, not on {ranks} ranks: {advice}"
        )));
    }
    if is_stdout(&arguments.input.file) {
        return Err(Failure::Unusable("several ranks cannot read standard input: give a file".to_owned()));
    }
    match &arguments.output {
        None if arguments.count => {}
        Some(file) if !is_stdout(file) => {
            refuse_to_overwrite(&[("the input", Some(&arguments.input.file)), ("--output", Some(file))])?;
            if !matches!(TableFormat::of(Some(file))?, TableFormat::Npy | TableFormat::Csv) {
                return Err(Failure::Unusable(format!(
                    "--output {}: several ranks write .npy or .csv",
                    display_name(file)
                )));
            }
        }
        _ => {
            return Err(Failure::Unusable(
                "several ranks write to a file: give --output FILE or --count".to_owned(),
            ));
        }
    }
    Ok(())
}

/// Reads this rank's rows. Each rank reads them from a NumPy array; rank 0 reads files of other formats, and
/// sends the rows.
fn read(
    arguments: &ContactsArguments,
    communicator: &dyn Communicator,
    progress: &Progress,
) -> Result<(Rows, String), Failure> {
    let file = &arguments.input.file;
    let name = display_name(file);
    let failed = |error: &io::Error| Failure::reading(&name, error);
    let opened = File::open(file).and_then(|mut opened| {
        let mut start = Vec::new();
        (&mut opened).take(NpyRows::START as u64).read_to_end(&mut start)?;
        Ok((fs::metadata(file)?.len(), start, opened))
    });
    let (length, start, mut opened) = agree(communicator, opened.map_err(|error| failed(&error)))?;
    let seen = [&length.to_le_bytes(), &start[..]].concat();
    if let Some(rank) = first_unlike(communicator, &seen[..seen.len().min(4096)]) {
        return Err(Failure::Unusable(format!(
            "rank {rank}: {name} is another file there than on rank 0; it must be on a file system that all machines share, or be copied to each"
        )));
    }
    let may_be_array = arguments.input.format.is_none_or(|format| format == PackingFormat::Npy);
    let array = if may_be_array && !arguments.input.skip_bad_lines && arguments.input.frames.is_none() {
        NpyRows::open(&start).map_err(|error| unreadable(&name, &error))?
    } else {
        None
    };
    let Some(array) = array else {
        return Ok((scatter(arguments, communicator, progress)?, name));
    };
    array.check_length(length).map_err(|error| unreadable(&name, &error))?;
    drop(start);
    let rows = rows_of(communicator, array.rows());
    let options = ReadOptions {
        columns: arguments.input.columns.clone(),
        skip_bad_lines: false,
        ignore_ids: arguments.input.ignore_ids,
        bodies: None,
        types: None,
    };
    let place = array.bytes(rows.clone());
    let (packing, _) = progress.step("reading", Some(place.end - place.start), |position| {
        let mut bytes = vec![0; (place.end - place.start) as usize];
        let read = opened.seek(SeekFrom::Start(place.start)).and_then(|_| opened.read_exact(&mut bytes));
        read.map_err(|error| failed(&error))?;
        array.read(rows.clone(), &bytes, &options, position).map_err(|error| unreadable(&name, &error))
    });
    let packing = agree(communicator, packing)?;
    let numbers = || (rows.start.cast_signed()..rows.end.cast_signed()).collect();
    let ids = match packing.ids {
        Some(ids) => {
            refuse_duplicates(communicator, &name, &ids, rows.start)?;
            ids
        }
        None => numbers(),
    };
    Ok((Rows { centres: packing.centres, radii: packing.radii, ids, cell: packing.cell }, name))
}

/// The rows of this rank.
fn rows_of(communicator: &dyn Communicator, all: u64) -> Range<u64> {
    let end = |rank: usize| (u128::from(all) * rank as u128 / communicator.size() as u128) as u64;
    end(communicator.rank())..end(communicator.rank() + 1)
}

/// Refuses an id that occurs twice among all ranks: equal ids are sent to the same rank. Collective.
fn refuse_duplicates(
    communicator: &dyn Communicator,
    name: &str,
    ids: &[i64],
    first: u64,
) -> Result<(), Failure> {
    let size = communicator.size();
    let mut bytes = vec![Vec::new(); size];
    for (&id, row) in ids.iter().zip(first..) {
        let to = (id.cast_unsigned().wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize % size;
        bytes[to].extend(id.to_le_bytes());
        bytes[to].extend(row.to_le_bytes());
    }
    let messages = bytes.into_iter().enumerate().map(|(rank, bytes)| Message { rank, bytes });
    let received = communicator.exchange(messages.collect());
    let mut ids: Vec<(i64, u64)> = Vec::new();
    for message in received {
        let numbers = message.bytes.as_chunks::<8>().0.as_chunks::<2>().0;
        ids.extend(numbers.iter().map(|[id, row]| (i64::from_le_bytes(*id), u64::from_le_bytes(*row))));
    }
    ids.sort_unstable();
    let twice = ids.windows(2).filter(|pair| pair[0].0 == pair[1].0).min_by_key(|pair| pair[1].1);
    let told = twice.map_or_else(Vec::new, |pair| {
        [pair[1].1.to_le_bytes(), pair[0].1.to_le_bytes(), pair[0].0.to_le_bytes()].concat()
    });
    let all = communicator.all_gather(&told);
    let numbers =
        |told: &Vec<u8>| <[u64; 3]>::try_from(told.chunks(8).map(u64_from).collect::<Vec<_>>()).ok();
    match all.iter().filter_map(numbers).min() {
        Some([second, first, id]) => {
            let error = ReadError::DuplicateIdRow { id: id.cast_signed(), first, second };
            Err(unreadable(name, &error))
        }
        None => Ok(()),
    }
}

/// Rank 0 reads the file, and sends each rank its elements.
fn scatter(
    arguments: &ContactsArguments,
    communicator: &dyn Communicator,
    progress: &Progress,
) -> Result<Rows, Failure> {
    if communicator.rank() > 0 {
        agree(communicator, Ok(()))?;
        return Ok(receive(&communicator.receive(0)));
    }
    let opened =
        input::open(&arguments.input.file, arguments.input.format, arguments.input.max_memory, progress)
            .and_then(|opened| {
                if opened.is_mesh() {
                    return Err(Failure::Unusable(format!(
                        "{} is a mesh: several ranks search packings",
                        opened.name
                    )));
                }
                input::understand(opened, &arguments.input, progress)
            });
    let input = agree(communicator, opened)?;
    let all = input.packing.centres.len() as u64;
    for rank in 1..communicator.size() {
        let end = |rank: usize| (u128::from(all) * rank as u128 / communicator.size() as u128) as usize;
        communicator.send(rank, &packed(&input, end(rank)..end(rank + 1)));
    }
    let own = rows_of(communicator, all);
    Ok(receive(&packed(&input, own.start as usize..own.end as usize)))
}

/// Elements as bytes, for [`receive`].
fn packed(input: &Input, rows: Range<usize>) -> Vec<u8> {
    let packing = &input.packing;
    let mut bytes = Vec::new();
    let cell = packing.cell.as_ref();
    let flags =
        [packing.centres.dimensions() as u64, u64::from(packing.radii.is_some()), u64::from(cell.is_some())];
    flags.iter().chain(&[rows.len() as u64]).for_each(|flag| bytes.extend(flag.to_le_bytes()));
    let mut reals = |values: &[f64]| values.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    if let Some(cell) = cell {
        reals(&cell.origin);
        reals(cell.edges.as_flattened());
        reals(&cell.repeats.map(|repeats| f64::from(u8::from(repeats))));
    }
    match &packing.centres {
        Centres::Two(centres) => reals(centres[rows.clone()].as_flattened()),
        Centres::Three(centres) => reals(centres[rows.clone()].as_flattened()),
    }
    if let Some(radii) = &packing.radii {
        reals(&radii[rows.clone()]);
    }
    rows.for_each(|row| bytes.extend(input::id(packing, row).to_le_bytes()));
    bytes
}

fn receive(bytes: &[u8]) -> Rows {
    let mut numbers = bytes.as_chunks::<8>().0.iter().copied();
    let mut whole = || numbers.next().map_or(0, u64::from_le_bytes);
    let [dimensions, has_radii, has_cell, count] = [(); 4].map(|()| whole());
    let count = count as usize;
    let mut real = || numbers.next().map_or(0.0, f64::from_le_bytes);
    let cell = (has_cell == 1).then(|| SimulationBox {
        origin: [(); 3].map(|()| real()),
        edges: [(); 3].map(|()| [(); 3].map(|()| real())),
        repeats: [(); 3].map(|()| real() == 1.0),
    });
    let centres = if dimensions == 2 {
        Centres::Two((0..count).map(|_| [(); 2].map(|()| real())).collect())
    } else {
        Centres::Three((0..count).map(|_| [(); 3].map(|()| real())).collect())
    };
    let radii = (has_radii == 1).then(|| (0..count).map(|_| real()).collect());
    Rows { centres, radii, ids: numbers.map(i64::from_le_bytes).collect(), cell }
}

impl<const D: usize> RankPart<D> {
    /// Collective.
    fn new(
        communicator: &dyn Communicator,
        centres: Vec<[f64; D]>,
        radii: Option<Vec<f64>>,
        ids: Vec<i64>,
        cell: Option<SimulationBox>,
    ) -> Self {
        let mut starts = vec![0];
        for count in gather_counts(communicator, centres.len() as u64) {
            starts.push(starts.last().copied().unwrap_or(0) + count);
        }
        Self { starts, centres, has_radii: radii.is_some(), radii: radii.unwrap_or_default(), ids, cell }
    }

    fn elements(&self) -> u64 {
        self.starts.last().copied().unwrap_or(0)
    }

    /// Centres, radii and ids of elements of any ranks, which are given in ascending order. Collective.
    fn fetch(&self, communicator: &dyn Communicator, wanted: &[u32]) -> (Vec<[f64; D]>, Vec<f64>, Vec<i64>) {
        let mut asked = Vec::new();
        let mut rest = wanted;
        for rank in 0..communicator.size() {
            let count = rest.partition_point(|&element| u64::from(element) < self.starts[rank + 1]);
            let bytes: Vec<u8> = rest[..count].iter().flat_map(|element| element.to_le_bytes()).collect();
            rest = &rest[count..];
            if count > 0 {
                asked.push(Message { rank, bytes });
            }
        }
        let own = self.starts[communicator.rank()];
        let answers = communicator.exchange(asked).into_iter().map(|Message { rank, bytes }| {
            let places = bytes
                .as_chunks::<4>()
                .0
                .iter()
                .map(|element| (u64::from(u32::from_le_bytes(*element)) - own) as usize);
            let mut out = Vec::with_capacity(places.len() * 8 * (D + 2));
            for place in places {
                self.centres[place].iter().for_each(|x| out.extend(x.to_le_bytes()));
                if self.has_radii {
                    out.extend(self.radii[place].to_le_bytes());
                }
                out.extend(self.ids[place].to_le_bytes());
            }
            Message { rank, bytes: out }
        });
        let answers = answers.collect();
        let (mut centres, mut radii, mut ids) = (Vec::new(), Vec::new(), Vec::new());
        // Answers come by rank, and each rank's elements in the order of the requests.
        for answer in communicator.exchange(answers) {
            let mut numbers = answer.bytes.as_chunks::<8>().0.iter().copied();
            while let Some(x) = numbers.next() {
                let mut rest = || numbers.next().unwrap_or_default();
                let mut centre = [f64::from_le_bytes(x); D];
                centre.iter_mut().skip(1).for_each(|x| *x = f64::from_le_bytes(rest()));
                centres.push(centre);
                if self.has_radii {
                    radii.push(f64::from_le_bytes(rest()));
                }
                ids.push(i64::from_le_bytes(rest()));
            }
        }
        (centres, radii, ids)
    }
}

/// The summary that rank 0 shows at the end.
struct RanksSummary {
    file: String,
    elements: u64,
    dimensions: usize,
    ranks: usize,
    ghosts: u64,
    couples: u64,
    seconds: [f64; 2],
}

impl fmt::Display for RanksSummary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut line = |label: &str, text: String| writeln!(out, "{label:<16} {text}");
        line("file", self.file.clone())?;
        line("elements", format!("{} in {}D", grouped(self.elements), self.dimensions))?;
        line("ranks", format!("{}, with {} ghosts in all", self.ranks, grouped(self.ghosts)))?;
        let mean = if self.elements == 0 { 0.0 } else { 2.0 * self.couples as f64 / self.elements as f64 };
        line("couples", format!("{}, {mean:.3} contacts per element", grouped(self.couples)))?;
        let [detect, all] = self.seconds;
        line("time", format!("{detect:.3} s to detect, {all:.3} s in all"))
    }
}

impl RanksSummary {
    /// Puts the output in place, and shows the summary, on rank 0.
    fn tell(
        self,
        output: SharedFile,
        arguments: &ContactsArguments,
        communicator: &dyn Communicator,
    ) -> Result<(), Failure> {
        let output = output.close(communicator);
        let mut done = Ok(());
        if communicator.rank() == 0 {
            let name = output.as_ref().and_then(Output::file_name);
            done = match output {
                Some(output) => output.commit(),
                None => crate::command::output::print(&format!("{}\n", self.couples)),
            };
            if done.is_ok() && !arguments.quiet {
                show(&self, name.as_slice());
            }
        }
        agree(communicator, done)
    }
}

fn find<const D: usize>(
    arguments: &ContactsArguments,
    communicator: &dyn Communicator,
    progress: &Progress,
    (name, start): (&str, Instant),
    part: &RankPart<D>,
    output: &mut SharedFile,
) -> Result<RanksSummary, Failure> {
    let tolerance = arguments.input.tolerance;
    let cutoff = arguments.input.cutoff.as_ref().map(Cutoff::largest);
    let given = arguments.input.radius;
    let one_size = given.or(cutoff.map(|cutoff| cutoff * f64::HALF));
    if one_size.is_none() && !part.has_radii {
        return Err(Failure::Unusable(format!(
            "{name}: no column for radius or diameter: give --radius R, --cutoff D or --columns"
        )));
    }
    if part.elements() > u64::from(u32::MAX - 1) {
        let why = "one search numbers at most 4,294,967,294";
        return Err(Failure::Unusable(format!(
            "{name}: {} elements are too many: {why}",
            grouped(part.elements())
        )));
    }
    let cell: Option<PeriodicBox<f64, D>> = periodic_box(&arguments.periodic, name, part.cell.as_ref())?;
    let shapes = match one_size {
        Some(radius) => Shapes::Equal { centres: &part.centres, radius },
        None => Shapes::Spheres { centres: &part.centres, radii: &part.radii },
    };
    let first = part.starts[communicator.rank()] as u32;
    let numbers: Vec<u32> = (first..).take(part.centres.len()).collect();
    let search = DistributedSearch::new(communicator).with_engine(arguments.engine.engine());
    let search = search.with_threads(arguments.threads);
    let mut search =
        agree(communicator, search.map_err(|error| Failure::Unusable(format!("--threads: {error}"))))?;
    let (found, detect) = progress.step("detecting", None, |_| match &cell {
        None => search.couples(&numbers, &shapes, tolerance).map(Couples::Plain),
        Some(cell) => search.periodic_couples(&numbers, &shapes, tolerance, cell).map(Couples::Periodic),
    });
    let found: Couples<D> = found.map_err(|error| Failure::Unusable(format!("{name}: {error}")))?;
    let ghosts = gather_counts(communicator, search.statistics().ghosts as u64).iter().sum();
    drop((search, numbers));
    let couples = gather_counts(communicator, found.len() as u64).iter().sum();
    if arguments.output.is_some() {
        let (written, _) = progress.step("writing", Some(found.len() as u64), |position| {
            write(communicator, part, &found, cell, (given, cutoff), output, position)
        });
        written?;
    }
    let seconds = [detect, start.elapsed().as_secs_f64()];
    let (file, elements, ranks) = (name.to_owned(), part.elements(), communicator.size());
    Ok(RanksSummary { file, elements, dimensions: D, ranks, ghosts, couples, seconds })
}

/// Returns the place of an element in an ascending list, which contains it.
fn numbering(elements: &[u32]) -> Box<dyn Fn(u32) -> u32 + '_> {
    /// A table takes this many numbers at most for each element. A longer one would not be proportional to
    /// the share of the rank.
    const MOST: usize = 8;
    let (Some(&first), Some(&last)) = (elements.first(), elements.last()) else { return Box::new(|_| 0) };
    let span = (last - first) as usize + 1;
    if span > MOST * elements.len() {
        return Box::new(|element| elements.partition_point(|&other| other < element) as u32);
    }
    let mut places = vec![0; span];
    for (place, &element) in (0..).zip(elements) {
        places[(element - first) as usize] = place;
    }
    Box::new(move |element| places[(element - first) as usize])
}

/// Writes this rank's couples, with the elements of other ranks that they need.
fn write<const D: usize>(
    communicator: &dyn Communicator,
    part: &RankPart<D>,
    found: &Couples<D>,
    cell: Option<PeriodicBox<f64, D>>,
    (radius, cutoff): (Option<f64>, Option<f64>),
    output: &mut SharedFile,
    position: &Position,
) -> Result<(), Failure> {
    let mut wanted: Vec<u32> = found.iter().flat_map(|couple| [couple.i, couple.j]).collect();
    wanted.sort_unstable();
    wanted.dedup();
    let (centres, radii, ids) = part.fetch(communicator, &wanted);
    // The elements are renumbered, in the same order.
    let number = numbering(&wanted);
    let renumbered =
        found.iter().map(|couple| PeriodicCouple { i: number(couple.i), j: number(couple.j), ..couple });
    let couples = match found {
        Couples::Plain(_) => {
            Couples::Plain(renumbered.map(|PeriodicCouple { i, j, .. }| Couple { i, j }).collect())
        }
        Couples::Periodic(_) => Couples::Periodic(renumbered.collect()),
    };
    let sizes = match (radius, cutoff) {
        (Some(radius), _) => Sizes::All(radius),
        (None, Some(cutoff)) => Sizes::Cutoff(cutoff),
        (None, None) => Sizes::Each(&radii),
    };
    let network =
        Network { space: Space { centres: &centres, cell }, sizes, couples: &couples, forces: None };
    output.write(communicator, &couples_with_ids(&network, &ids, position))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use clap::Parser;
    use fdem_distributed::threads;

    use super::*;
    use crate::command::args::{Arguments, Task};
    use crate::command::contacts;

    /// A folder for the files of a test.
    struct Folder(tempfile::TempDir);

    impl Folder {
        fn new() -> Self {
            Self(tempfile::tempdir().unwrap())
        }

        fn path(&self, name: &str) -> PathBuf {
            self.0.path().join(name)
        }

        fn write(&self, name: &str, content: impl AsRef<[u8]>) {
            fs::write(self.path(name), content).unwrap();
        }

        /// Names of all files, hidden ones too.
        fn files(&self) -> Vec<String> {
            let names = fs::read_dir(self.0.path()).unwrap();
            let mut names: Vec<String> =
                names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
            names.sort();
            names
        }

        /// The arguments of `fdem contacts FILE -q OPTIONS`, with `-o OUTPUT` unless it is empty.
        fn arguments(&self, file: &str, options: &str, output: &str) -> ContactsArguments {
            let file = self.path(file).to_str().unwrap().to_owned();
            let output = (!output.is_empty())
                .then(|| ["-o".to_owned(), self.path(output).to_str().unwrap().to_owned()]);
            let words =
                ["fdem", "contacts", "-q"].into_iter().chain(options.split_whitespace()).map(str::to_owned);
            let words = words.chain([file]).chain(output.into_iter().flatten());
            match Arguments::try_parse_from(words).unwrap().task {
                Task::Contacts(arguments) => *arguments,
                task => panic!("{task:?}"),
            }
        }

        /// Compares the files that one process and several ranks write.
        fn compare(&self, file: &str, options: &str) {
            for extension in ["npy", "csv"] {
                let (one, many) = (format!("one.{extension}"), format!("many.{extension}"));
                contacts::run(&self.arguments(file, options, &one)).unwrap();
                let expected = fs::read(self.path(&one)).unwrap();
                assert!(expected.len() > 1000, "{file} {options}: there are couples");
                for size in [2, 3, 8] {
                    let arguments = self.arguments(file, options, &many);
                    let done = threads::run(size, |communicator| run(&arguments, communicator));
                    for done in done {
                        done.unwrap();
                    }
                    let found = fs::read(self.path(&many)).unwrap();
                    assert!(found == expected, "{file} {options}: {extension} on {size} ranks");
                    fs::remove_file(self.path(&many)).unwrap();
                }
                fs::remove_file(self.path(&one)).unwrap();
            }
        }

        /// The failure, which all ranks have.
        fn refusal(&self, file: &str, options: &str, output: &str) -> String {
            let arguments = self.arguments(file, options, output);
            let failures =
                threads::run(3, |communicator| run(&arguments, communicator).unwrap_err().to_string());
            assert!(failures.iter().all(|failure| *failure == failures[0]), "{failures:?}");
            failures[0].clone()
        }
    }

    /// Rows `x,y,z,radius`, or with an id before them.
    fn packing(n: usize, with_ids: bool) -> Vec<Vec<f64>> {
        let cloud =
            fdem_scenes::gas::<3>(n, 7, 6.0, fdem_scenes::Sizes::Lognormal { median: 0.5, sigma: 0.3 });
        let cloud = cloud.unwrap();
        let rows = cloud.centres.iter().zip(&cloud.radii).enumerate().map(|(k, (centre, radius))| {
            // Ids in no order.
            let id = with_ids.then_some((k * 7919 % n) as f64);
            id.into_iter().chain(*centre).chain([*radius]).collect()
        });
        rows.collect()
    }

    fn npy(rows: &[Vec<f64>]) -> Vec<u8> {
        let shape = format!("({}, {})", rows.len(), rows.first().map_or(4, Vec::len));
        let mut text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
        while (10 + text.len() + 1) % 64 != 0 {
            text.push(' ');
        }
        text.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.bytes());
        bytes.extend(rows.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes
    }

    #[test]
    fn several_ranks_write_the_file_of_one_process() {
        let folder = Folder::new();
        let rows = packing(800, false);
        folder.write("in.npy", npy(&rows));
        folder.compare("in.npy", "");
        folder.compare("in.npy", "--cutoff 0.9 --tolerance 0.1");
        folder.compare("in.npy", "--radius 0.5 --periodic xy --box -1,7.5,0,8,0,9");
        folder.compare("in.npy", "--periodic xyz --edges 8,0,0,4,8,0,1,-3,9 --origin 1,2,3");

        folder.write("ids.npy", npy(&packing(800, true)));
        folder.compare("ids.npy", "--columns id,x,y,z,radius");
        folder.compare("ids.npy", "--columns id,x,y,z,radius --ignore-ids --engine nbs");

        // Rank 0 reads text, and sends it to the others.
        let line = |row: &Vec<f64>| row.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
        let lines: Vec<String> = rows.iter().map(line).collect();
        folder.write("in.csv", format!("x,y,z,radius\n{}\n", lines.join("\n")));
        folder.compare("in.csv", "");
        folder.write("bad.csv", format!("x,y,z,radius\nnone,0,0,0\n{}\n", lines.join("\n")));
        folder.compare("bad.csv", "--skip-bad-lines");
        assert_eq!(folder.files(), ["bad.csv", "ids.npy", "in.csv", "in.npy"]);
    }

    #[test]
    fn few_elements_and_none_are_no_trouble() {
        let folder = Folder::new();
        for n in 0..4 {
            let rows: Vec<Vec<f64>> = (0..n).map(|k| vec![f64::from(k), 0.0, 0.0, 0.5]).collect();
            folder.write("in.npy", npy(&rows));
            contacts::run(&folder.arguments("in.npy", "", "one.npy")).unwrap();
            let arguments = folder.arguments("in.npy", "", "many.npy");
            threads::run(8, |communicator| run(&arguments, communicator).unwrap());
            assert_eq!(fs::read(folder.path("one.npy")).unwrap(), fs::read(folder.path("many.npy")).unwrap());
        }
    }

    /// A failure is the same on all ranks, names the rank where it happened, and leaves no file behind.
    #[test]
    fn a_failure_of_one_rank_ends_all_and_leaves_no_file() {
        let folder = Folder::new();
        let mut rows = packing(90, false);
        rows[75][1] = f64::NAN;
        folder.write("nan.npy", npy(&rows));
        let refusal = folder.refusal("nan.npy", "", "out.npy");
        assert!(refusal.starts_with("rank 2: ") && refusal.contains("row 75"), "{refusal}");

        let mut rows = packing(90, true);
        rows[80][0] = rows[3][0];
        folder.write("twice.npy", npy(&rows));
        let refusal = folder.refusal("twice.npy", "--columns id,x,y,z,radius", "out.npy");
        assert!(refusal.contains("80") && refusal.contains(" 3"), "{refusal}");

        let mut cut = npy(&packing(90, false));
        cut.truncate(cut.len() - 8);
        folder.write("cut.npy", cut);
        assert!(folder.refusal("cut.npy", "", "out.npy").contains("cut.npy"));
        assert!(folder.refusal("nowhere.npy", "", "out.npy").starts_with("rank 0: cannot read"));
        assert!(folder.refusal("nan.npy", "", "nowhere/out.npy").starts_with("rank 0: cannot write"));
        folder.write("bad.csv", "x,y,radius\n0,0,1\n0,none,1\n");
        assert!(folder.refusal("bad.csv", "", "out.npy").contains("bad.csv:3"));
        folder.write("points.npy", npy(&[vec![0.0, 0.0, 0.0]]));
        assert!(folder.refusal("points.npy", "", "out.npy").contains("--radius"));
        assert_eq!(folder.files(), ["bad.csv", "cut.npy", "nan.npy", "points.npy", "twice.npy"]);
    }

    /// Options that need all couples in one process are refused before the file is opened.
    #[test]
    fn options_for_one_process_are_refused() {
        let folder = Folder::new();
        for (options, output, part) in [
            ("--analyse", "out.npy", "--analyse"),
            ("--verify 3", "out.npy", "--verify"),
            ("--json a.json", "out.npy", "--json"),
            ("--picture a.svg", "out.npy", "--picture"),
            ("--explain", "", "--explain"),
            ("--couples a.dump", "out.npy", "--couples"),
            ("", "out.parquet", ".npy or .csv"),
            ("", "", "--output FILE or --count"),
        ] {
            let refusal = folder.refusal("nowhere.npy", options, output);
            assert!(refusal.contains(part), "{options}: {refusal}");
        }
        assert_eq!(folder.files(), [""; 0]);
    }
}
