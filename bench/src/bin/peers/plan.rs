//! The options of a run.

use std::path::{Path, PathBuf};

use fdem_bench::peers::sets::{SETS, Set};
use fdem_bench::peers::{Command, EngineKind};
use fdem_contact::Simd;

pub(crate) const USAGE: &str = "\
usage: peers [--sets A,B,...] [--engines A,B,...] [--external NAME=COMMAND]... [--simd LEVEL] [--threads N,M,...]
             [--rounds N] [--budget SECONDS] [--patience SECONDS] [--counts N,M,...] [--quick] [--out FILE]
             [--small] [--moving]

  --sets      of gas100k, gas1m, dense1m, sparse1m, outlier1m, gas2d1m, poly400k, logn1m, ratio1, ratio3, ratio10, ratio30, ratio100,
              ratio1000, boxes1m; all if not given
  --engines   of rows, rows-avx2, rows-fresh, rows-cold, nbs, auto: ours; the first is what the others are compared with; if not given, auto and rows for
              unlike sizes and boxes, all but auto for points
  --external  a rival that is a program, see external/README.md; may be repeated
  --simd      portable, neon, avx2 or avx512 for rows; the best of this processor if not given
  --threads   for all that can, one table for each number; all is one for each processor; 1 if not given
  --rounds    times taken of each search, 5 if not given
  --budget    a search whose times of one set add up to more, 3 s if not given, takes no further round
  --patience  a search that would take longer than this, 15 s if not given, is left out
  --counts    points of the gas that rows counts, to show the time per element; 1000000,10000000 if not given, 0 for none
  --quick     10,000 bodies: compares the couples, takes no times, writes nothing unless --out is given
  --small     only sets of 10 to 10,000 points; SMALL.md of this package unless --out is given
  --moving    only points that move, and coordinates in 32 bits; MOVING.md unless --out is given
  --out       Markdown with the tables, and the plot beside it as SVG; RESULTS.md of this package if not given
";

/// The searches to run, and the file for the results.
pub(crate) struct Plan {
    pub(crate) sets: Vec<&'static Set>,
    engines: Option<Vec<EngineKind>>,
    pub(crate) external: Vec<Command>,
    pub(crate) simd: Simd,
    pub(crate) threads: Vec<usize>,
    pub(crate) rounds: usize,
    pub(crate) budget: f64,
    pub(crate) patience: f64,
    pub(crate) counts: Vec<usize>,
    pub(crate) quick: bool,
    pub(crate) small: bool,
    pub(crate) moving: bool,
    pub(crate) out: Option<PathBuf>,
}

impl Plan {
    pub(crate) fn from_arguments(arguments: &[String]) -> Option<Self> {
        let mut plan = Self {
            sets: SETS.iter().collect(),
            engines: None,
            external: Vec::new(),
            simd: Simd::best(),
            threads: vec![1],
            rounds: 5,
            budget: 3.0,
            patience: 15.0,
            counts: vec![1_000_000, 10_000_000],
            quick: false,
            small: false,
            moving: false,
            out: None,
        };
        let mut rest = arguments.iter();
        while let Some(argument) = rest.next() {
            match argument.as_str() {
                "--quick" => plan.quick = true,
                "--small" => plan.small = true,
                "--moving" => plan.moving = true,
                _ => {}
            }
            if ["--quick", "--small", "--moving"].contains(&argument.as_str()) {
                continue;
            }
            let value = rest.next()?;
            match argument.as_str() {
                "--sets" => plan.sets = listed(value, |name| SETS.iter().find(|set| set.name == name))?,
                "--engines" => {
                    let kinds =
                        listed(value, |name| EngineKind::ALL.into_iter().find(|kind| kind.name() == name))?;
                    plan.engines = Some(kinds);
                }
                "--external" => plan.external.push(Command::parse(value)?),
                "--simd" => {
                    let levels = [Simd::Portable, Simd::Neon, Simd::Avx2, Simd::Avx512];
                    plan.simd = levels.into_iter().find(|level| level.name() == value)?;
                }
                "--threads" => {
                    plan.threads = listed(value, |number| match number {
                        "all" => std::thread::available_parallelism().ok().map(usize::from),
                        _ => number.parse().ok().filter(|&threads| threads > 0),
                    })?;
                }
                "--rounds" => plan.rounds = value.parse().ok().filter(|&rounds| rounds > 0)?,
                "--budget" => plan.budget = value.parse().ok().filter(|&seconds| seconds > 0.0)?,
                "--patience" => {
                    plan.patience = value.parse().ok().filter(|seconds| (0.001..1e6).contains(seconds))?;
                }
                "--counts" if value == "0" => plan.counts.clear(),
                "--counts" => plan.counts = listed(value, |n| n.parse().ok().filter(|&n| n > 0))?,
                "--out" => plan.out = Some(PathBuf::from(value)),
                _ => return None,
            }
        }
        if plan.out.is_none() && !plan.quick {
            let name = match (plan.small, plan.moving) {
                (true, _) => "SMALL.md",
                (_, true) => "MOVING.md",
                _ => "RESULTS.md",
            };
            plan.out = Some(Path::new(env!("CARGO_MANIFEST_DIR")).join(name));
        }
        Some(plan)
    }
}

impl Plan {
    /// Our searches on this set; the first is the reference.
    pub(crate) fn engines(&self, set: &Set) -> Vec<EngineKind> {
        let kinds = self.engines.as_deref();
        let available = || set.group.kinds().iter().copied().filter(|kind| kind.is_available()).collect();
        kinds.map_or_else(available, <[EngineKind]>::to_vec)
    }
}

/// The entries of a list separated by commas; `None` if one of them is unknown.
fn listed<T>(list: &str, find: impl Fn(&str) -> Option<T>) -> Option<Vec<T>> {
    list.split(',').map(find).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments() {
        let plan = |line: &str| Plan::from_arguments(&line.split(' ').map(str::to_owned).collect::<Vec<_>>());
        let all = plan("--quick").unwrap();
        let kinds = |name: &str| all.engines(all.sets.iter().find(|set| set.name == name).unwrap())[0];
        assert_eq!(
            ["gas1m", "logn1m", "boxes1m"].map(kinds),
            [EngineKind::Rows, EngineKind::Auto, EngineKind::Auto]
        );
        let some = plan("--quick --sets gas1m,gas2d1m --engines nbs --threads 1,3 --counts 0 --external a=b")
            .unwrap();
        assert_eq!((some.sets.len(), some.engines, some.out), (2, Some(vec![EngineKind::Nbs]), None));
        assert_eq!((some.threads, some.counts, some.external.len()), (vec![1, 3], vec![], 1));
        for wrong in
            ["--sets gas", "--rounds 0", "--simd", "--speed 3", "--threads 0", "--external a", "--counts x"]
        {
            assert!(plan(wrong).is_none(), "{wrong}");
        }
    }
}
