//! A distributed search under MPI, against the search of one process: seconds, speed-up, and processor time.
//!
//! Started alone, the program starts `mpirun` for each number of ranks and writes the table. Started by
//! `mpirun`, it is one of the ranks.

#![allow(clippy::print_stdout, reason = "a program for the terminal")]

use std::error::Error;
use std::fmt::Write;
use std::process::Command;
use std::time::Instant;

use fdem_distributed::{Communicator, DistributedSearch, Shapes, launched};
use fdem_mpi::{World, library_version};
use fdem_scenes::{Sizes, gas};

/// Number of spheres, unless `--elements N` says otherwise.
const ELEMENTS: usize = 4_000_000;

/// Rounds of each number of ranks; the fastest counts.
const ROUNDS: usize = 5;

/// Environment variable with the number of elements.
const VARIABLE: &str = "FDEM_BENCH_ELEMENTS";

/// Environment variable that is set if spheres are sorted along the first axis.
const SORTED: &str = "FDEM_BENCH_SORTED";

/// The times of the fastest round, and the numbers of couples and ghosts.
struct Times {
    is_sorted: bool,
    ranks: usize,
    seconds: f64,
    /// Processor time of all ranks together in that round.
    processor: f64,
    couples: i64,
    ghosts: i64,
}

fn main() -> Result<(), Box<dyn Error>> {
    if launched().is_some() || std::env::var(VARIABLE).is_ok() {
        return rank();
    }
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |option: &str| {
        let place = arguments.iter().position(|argument| argument == option)?;
        arguments.get(place + 1)
    };
    let elements = match value("--elements") {
        Some(number) => number.parse()?,
        None => ELEMENTS,
    };
    let times = [false, true].into_iter().flat_map(|is_sorted| [1, 2, 8].map(|ranks| (ranks, is_sorted)));
    let times = times.map(|(ranks, is_sorted)| start(ranks, elements, is_sorted));
    let times: Vec<Times> = times.collect::<Result<_, _>>()?;
    let text = report(elements, &times)?;
    match value("--write") {
        Some(file) => std::fs::write(file, text)?,
        None => print!("{text}"),
    }
    Ok(())
}

/// Starts the ranks, and reads the output of rank 0.
fn start(ranks: usize, elements: usize, is_sorted: bool) -> Result<Times, Box<dyn Error>> {
    let number = ranks.to_string();
    let mut command = Command::new("mpirun");
    command
        .args(["--oversubscribe", "--allow-run-as-root", "-n", &number])
        .arg(std::env::current_exe()?)
        .env(VARIABLE, elements.to_string());
    if is_sorted {
        command.env(SORTED, "1");
    }
    let output = command.output()?;
    let text = String::from_utf8(output.stdout)?;
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [seconds, processor, couples, ghosts] = numbers[..] else {
        return Err(format!("{ranks} ranks: {}", String::from_utf8_lossy(&output.stderr)).into());
    };
    Ok(Times { is_sorted, ranks, seconds, processor, couples: couples as i64, ghosts: ghosts as i64 })
}

/// Work of one rank: it has every `size`-th sphere, so that nearly all spheres are sent to another rank; or
/// consecutive ones of those that are sorted.
fn rank() -> Result<(), Box<dyn Error>> {
    let world = World::start()?;
    let elements: usize = std::env::var(VARIABLE)?.parse()?;
    let mut cloud = gas::<3>(elements, 1, 6.0, Sizes::Equal { radius: 0.5 })?;
    let (rank, size) = (world.rank(), world.size());
    let mut places = (rank, elements, size);
    if std::env::var(SORTED).is_ok() {
        cloud.centres.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        places = (rank * elements / size, (rank + 1) * elements / size, 1);
    }
    let own = || (places.0..places.1).step_by(places.2);
    let ids: Vec<u32> = own().map(|place| place as u32).collect();
    let centres: Vec<[f64; 3]> = own().map(|place| cloud.centres[place]).collect();
    drop(cloud);
    let spheres = Shapes::Equal { centres: &centres, radius: 0.5 };
    let mut best = [f64::INFINITY, 0.0];
    let mut found = [0, 0];
    for _ in 0..ROUNDS {
        let mut search = DistributedSearch::new(&world);
        world.barrier();
        let (start, processor) = (Instant::now(), processor_time());
        let couples = search.couples(&ids, &spheres, 0.0)?.len();
        let mut used = [((processor_time() - processor) * 1e9) as i64];
        world.barrier();
        let seconds = start.elapsed().as_secs_f64();
        world.all_sum(&mut used);
        found = [couples, search.statistics().ghosts].map(|count| count.cast_signed() as i64);
        world.all_sum(&mut found);
        if seconds < best[0] {
            best = [seconds, used[0] as f64 / 1e9];
        }
    }
    if world.rank() == 0 {
        println!("{} {} {} {}", best[0], best[1], found[0], found[1]);
    }
    Ok(())
}

/// Processor time of this process so far, s. Linux only; elsewhere 0.
fn processor_time() -> f64 {
    /// Ticks in a second: the unit of `/proc` on all architectures of today.
    const TICKS: f64 = 100.0;
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name of the program, which may contain blanks, ends at the last parenthesis. User and system time
    // are fields 14 and 15.
    let fields = text.rsplit_once(')').map_or("", |(_, rest)| rest).split_whitespace();
    fields.skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / TICKS
}

fn report(elements: usize, times: &[Times]) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    let used: Vec<usize> = times.iter().take(3).map(|times| times.ranks).collect();
    let millions = elements as f64 / 1e6;
    writeln!(text, "# Distributed search\n")?;
    writeln!(text, "{}; {}.\n", fdem_bench::machine(&used), library_version())?;
    writeln!(
        text,
        "{millions} million spheres of equal size at random places, 6 neighbours each; one thread for each rank, all ranks on one machine. *Dealt out*: at first rank `r` has every sphere \
         whose number leaves the remainder `r`, so nearly all are sent. *Sorted*: the spheres are numbered along the first axis, and each rank has consecutive ones, as when ranks read parts of a \
         sorted file. At the end the couples are sorted over all ranks. Fastest of {ROUNDS} rounds. One rank is the search of one process, with its couples sorted.\n\n\
         The processor time is the sum over all ranks; MPI waits by looking again and again, so the time that ranks wait for each other counts too. With more ranks than cores the ranks take turns: \
         the column before the ghosts shows the cost of the division alone.\n"
    )?;
    writeln!(
        text,
        "| spheres | ranks | s | speed-up | processor time, s | processor time / 1 rank | ghosts / elements | couples |"
    )?;
    writeln!(
        text,
        "|:--------|------:|--:|---------:|------------------:|------------------------:|------------------:|--------:|"
    )?;
    for of_input in times.chunk_by(|a, b| a.is_sorted == b.is_sorted) {
        let one = &of_input[0];
        for times in of_input {
            let ghosts = 100.0 * times.ghosts as f64 / elements as f64;
            writeln!(
                text,
                "| {} | {} | {:.2} | {:.2} | {:.2} | {:.2} | {ghosts:.1} % | {} |",
                if times.is_sorted { "sorted" } else { "dealt out" },
                times.ranks,
                times.seconds,
                one.seconds / times.seconds,
                times.processor,
                times.processor / one.processor,
                times.couples,
            )?;
        }
    }
    Ok(text)
}
