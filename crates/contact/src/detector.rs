//! A search that holds all engines and chooses the one that fits the elements.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::couple::Couple;
use crate::elements::{Elements, Shape};
use crate::engine::{Engine, Plan};
use crate::error::Error;
use crate::explain::{Estimate, Explanation, Means};
use crate::pool::Pool;
use crate::real::Real;
use crate::search::Search;
use crate::search::cgrid::CGrid;
use crate::search::direct::DirectUntil;
use crate::search::level::Level;
use crate::search::multilevel::Multilevel;
use crate::search::nbs::Nbs;
use crate::search::rows::Rows;
use crate::search::rows::scan::Scanner;
use crate::simd::Simd;
use crate::stop::Stop;

/// The C-grid is chosen if it is predicted to be at least this many times as fast. For long boxes in all
/// directions the prediction is 3 to 10 times too favourable to it, least where the C-grid is small, and rows
/// are twice as fast as predicted where boxes look ahead.
const WORTH_IT: f64 = 6.0;

/// With fewer elements, testing all against all is faster than any structure.
const FEW_ELEMENTS: usize = 32;

/// A search with the engine that fits the elements, or with a given one. It keeps the memory of all engines
/// between calls.
///
/// # Example
/// ```
/// use fdem_contact::{Detector, Elements, Engine, Search};
///
/// let centres: Vec<[f64; 2]> = (0..100).map(|k| [f64::from(k), 0.0]).collect();
/// let elements = Elements::points(&centres, 1.0)?;
/// let mut detector = Detector::new();
/// println!("{}", detector.plan(&elements)?.reason);
/// assert_eq!(detector.count(&elements)?, 99);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Detector<T, const D: usize> {
    /// The given engine; `None` to choose one.
    engine: Option<Engine>,
    direct: DirectUntil,
    nbs: Nbs<D>,
    rows: Rows<T, D>,
    multilevel: Multilevel<T, D>,
    cgrid: CGrid<T, D>,
}

impl<T: Real, const D: usize> Default for Detector<T, D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, const D: usize> Detector<T, D> {
    /// A detector that chooses its engine from the elements; [`Plan::reason`] says why. It holds no memory
    /// yet.
    pub fn new() -> Self {
        Self {
            engine: None,
            direct: DirectUntil::default(),
            nbs: Nbs::new(),
            rows: Rows::new(),
            multilevel: Multilevel::new(),
            cgrid: CGrid::new(),
        }
    }

    /// The same with this engine; `None` chooses one from the elements.
    #[must_use]
    pub fn with_engine(mut self, engine: impl Into<Option<Engine>>) -> Self {
        self.engine = engine.into();
        self
    }

    /// The same on `threads` threads, if the engine can use them ([`Rows`], [`Multilevel`]); 0 is one per
    /// processor.
    ///
    /// # Errors
    /// [`Error::NoThreads`].
    pub fn with_threads(self, threads: usize) -> Result<Self, Error> {
        let stop = self.rows.pool().stop().clone();
        Ok(self.with_pool(Pool::new(threads)?.stopped_by(stop)))
    }

    /// The same on the threads of `pool`, if the engine can use them. A search that is called from one of
    /// these threads starts no other.
    ///
    /// That thread may do other work of the pool while it waits: it must hold no lock that such work needs.
    ///
    /// # Example
    /// ```
    /// # use std::sync::Arc;
    /// # use fdem_contact::{Detector, Elements, Search};
    /// let pool = Arc::new(rayon::ThreadPoolBuilder::new().num_threads(2).build()?);
    /// let mut detector = Detector::new().on_pool(pool.clone());
    /// let elements = Elements::points(&[[0.0, 0.0], [1.0, 0.0]], 1.0)?;
    /// assert_eq!(pool.install(|| detector.count(&elements))?, 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[cfg(feature = "rayon")]
    #[must_use]
    pub fn on_pool(self, pool: Arc<rayon::ThreadPool>) -> Self {
        let stop = self.rows.pool().stop().clone();
        self.with_pool(Pool::of(pool).stopped_by(stop))
    }

    /// The same, but a search for a list of couples ends with [`Error::Stopped`] soon after any thread sets
    /// `stop`; the list is then empty.
    ///
    /// [`Rows`] and [`Multilevel`] check `stop` before each part of the search, some thousand elements, and
    /// between the three passes that sort the elements. Other engines check it for each element.
    ///
    /// # Example
    /// ```
    /// use std::sync::Arc;
    /// use std::sync::atomic::{AtomicBool, Ordering};
    /// use fdem_contact::{Detector, Elements, Engine, Error, Search};
    ///
    /// let stop = Arc::new(AtomicBool::new(false));
    /// let mut detector = Detector::new().with_engine(Engine::Rows).stopped_by(stop.clone());
    /// let points = [[0.0, 0.0], [1.0, 0.0]];
    /// let (elements, mut couples) = (Elements::points(&points, 1.0)?, Vec::new());
    /// detector.couples(&elements, &mut couples)?;
    /// stop.store(true, Ordering::Relaxed);
    /// assert_eq!(detector.couples(&elements, &mut couples), Err(Error::Stopped));
    /// # Ok::<(), Error>(())
    /// ```
    #[doc(alias = "cancel")]
    #[must_use]
    pub fn stopped_by(self, stop: Arc<AtomicBool>) -> Self {
        let pool = self.rows.pool().stopped_by(Stop::new(stop));
        self.with_pool(pool)
    }

    /// The same with other vector instructions, if the engine uses any ([`Rows`], [`Multilevel`]). The
    /// couples and their order are the same.
    ///
    /// # Errors
    /// [`Error::SimdUnavailable`] if this processor lacks them.
    pub fn with_simd(mut self, simd: Simd) -> Result<Self, Error> {
        self.rows = self.rows.with_simd(simd)?;
        self.multilevel = self.multilevel.with_simd(simd)?;
        Ok(self)
    }

    /// The same on a thread pool that is shared with other searches, until that is stopped.
    pub(crate) fn with_pool(mut self, pool: Pool) -> Self {
        self.direct = DirectUntil(pool.stop().clone());
        self.nbs = self.nbs.stopped_by(pool.stop().clone());
        self.cgrid = self.cgrid.stopped_by(pool.stop().clone());
        self.rows = self.rows.with_pool(pool.clone());
        self.multilevel = self.multilevel.with_pool(pool);
        self
    }

    /// Calls `visit` with all couples in their order, in blocks.
    pub(crate) fn for_each_block(
        &mut self,
        elements: &Elements<'_, T, D>,
        mut visit: impl FnMut(&[Couple]),
    ) -> Result<(), Error> {
        match self.choose(elements) {
            Engine::Rows => self.rows.for_each_block(elements, visit),
            Engine::Multilevel => self.multilevel.for_each_block(elements, visit),
            Engine::Direct | Engine::Nbs | Engine::CGrid => {
                self.for_each(elements, |couple| visit(&[couple]))
            }
        }
    }

    /// Appends as [`Rows::append_converted`] does; other engines use one thread.
    pub(crate) fn append_converted<V: Copy + Send + Sync>(
        &mut self,
        elements: &Elements<'_, T, D>,
        convert: impl Fn(&[Couple], &mut Vec<V>) -> Result<(), Error> + Sync,
        parts: &mut Vec<Vec<V>>,
        list: &mut Vec<V>,
    ) -> Result<(), Error> {
        match self.choose(elements) {
            Engine::Rows => return self.rows.append_converted(elements, convert, parts, list),
            Engine::Multilevel => return self.multilevel.append_converted(elements, convert, parts, list),
            _ => {}
        }
        let mut room = Ok(());
        self.for_each(elements, |couple| {
            if room.is_ok() {
                room = convert(&[couple], list);
            }
        })?;
        room
    }

    /// Folds as [`Rows::fold_blocks`] does; other engines have one part.
    pub(crate) fn fold_blocks<S: Send>(
        &mut self,
        elements: &Elements<'_, T, D>,
        start: impl Fn() -> S,
        visit: impl Fn(&mut S, &[Couple]) + Sync,
    ) -> Result<Vec<S>, Error> {
        match self.choose(elements) {
            Engine::Rows => return self.rows.fold_blocks(elements, start, visit),
            Engine::Multilevel => return self.multilevel.fold_blocks(elements, start, visit),
            _ => {}
        }
        let mut state = start();
        self.for_each(elements, |couple| visit(&mut state, &[couple]))?;
        Ok(vec![state])
    }

    /// The engine of [`Detector::plan`], without the rest of the plan.
    fn choose(&self, elements: &Elements<'_, T, D>) -> Engine {
        match self.engine {
            Some(engine) => engine,
            None if elements.len() <= FEW_ELEMENTS => Engine::Direct,
            None if matches!(elements.shape, Shape::Equal(_)) => Engine::Rows,
            None => {
                let (levels, cost) = self.multilevel.levels_and_cost(elements);
                if CGrid::levels_for_long_boxes(elements, cost / WORTH_IT).is_some() {
                    Engine::CGrid
                } else if levels.len() > 1 {
                    Engine::Multilevel
                } else {
                    Engine::Rows
                }
            }
        }
    }

    /// How a search over `elements` will run.
    ///
    /// # Errors
    /// The errors of [`Search::for_each`] that can be found without allocating.
    pub fn plan(&self, elements: &Elements<'_, T, D>) -> Result<Plan<D>, Error> {
        let mut levels = Vec::new();
        let (engine, reason) = match self.engine {
            None if elements.len() <= FEW_ELEMENTS => {
                (Engine::Direct, format!("all against all is fastest for up to {FEW_ELEMENTS} elements"))
            }
            None if matches!(elements.shape, Shape::Equal(_)) => (Engine::Rows, SIMILAR.to_owned()),
            None => {
                let cost;
                (levels, cost) = self.multilevel.levels_and_cost(elements);
                match (CGrid::levels_for_long_boxes(elements, cost / WORTH_IT), &levels[..]) {
                    (Some((in_cells, in_cells_cost)), _) => {
                        levels = in_cells;
                        (Engine::CGrid, long(cost / in_cells_cost))
                    }
                    (_, [first, .., last]) => (Engine::Multilevel, unlike(first, last)),
                    _ => (Engine::Rows, SIMILAR.to_owned()),
                }
            }
            Some(engine) => {
                match engine {
                    Engine::Multilevel => levels = self.multilevel.levels(elements),
                    Engine::CGrid => levels = self.cgrid.levels(elements),
                    Engine::Direct | Engine::Nbs | Engine::Rows => {}
                }
                (engine, "requested".to_owned())
            }
        };
        let grid = match engine {
            Engine::Direct | Engine::Multilevel | Engine::CGrid => None,
            Engine::Nbs => Some(self.nbs.plan(elements)?),
            Engine::Rows => Some(self.rows.plan(elements)),
        };
        Ok(Plan {
            engine,
            reason,
            cell_size: grid.map(|grid| grid.cell_size()),
            cells: grid.map(|grid| grid.cells()),
            levels: if matches!(engine, Engine::Multilevel | Engine::CGrid) { levels } else { Vec::new() },
        })
    }

    /// The plan of a search over `elements`, with its rows, its memory and the expected number of couples.
    ///
    /// The number of couples is estimated from the neighbours of 1024 elements, the same ones at every call.
    /// The error is one or two per cent if all elements have about the same number of neighbours, spread
    /// uniformly or in clusters. It can be arbitrarily large if few elements have most of the couples; see
    /// [`Explanation::couples_error`]. Up to 1024 elements are counted exactly.
    ///
    /// # Cost
    /// One pass over the elements, with a look-up for each and a test against every sampled element around
    /// it. This is a fraction of a search, unless most elements touch most others.
    ///
    /// # Errors
    /// As [`Detector::plan`].
    #[doc(alias = "estimate")]
    pub fn explain(&self, elements: &Elements<'_, T, D>) -> Result<Explanation<D>, Error> {
        let plan = self.plan(elements)?;
        let means = self.means(elements)?;
        Ok(Explanation::new(plan, elements, means, Estimate::of(elements), size_of::<Couple>()))
    }

    /// The memory, threads and instructions of a search over `elements`.
    pub(crate) fn means(&self, elements: &Elements<'_, T, D>) -> Result<Means, Error> {
        Ok(match self.choose(elements) {
            Engine::Direct => Means::NONE,
            Engine::Nbs => {
                let grid = self.nbs.plan(elements)?;
                let integers = Nbs::integers_for(elements.len(), &grid);
                Means { bytes: integers * size_of::<u32>(), ..Means::NONE }
            }
            Engine::CGrid => Means { bytes: self.cgrid.expected_bytes(elements), ..Means::NONE },
            Engine::Multilevel => Means {
                bytes: self.multilevel.expected_bytes(elements),
                threads: self.rows.threads(),
                simd: Some(self.rows.simd()),
            },
            Engine::Rows => Means {
                bytes: self.rows.expected_bytes(elements),
                threads: self.rows.threads(),
                simd: Some(self.rows.simd()),
            },
        })
    }

    /// Bytes that the engines hold now.
    pub fn bytes(&self) -> usize {
        self.rows.bytes()
            + self.multilevel.bytes()
            + self.cgrid.bytes()
            + self.nbs.integers() * size_of::<u32>()
    }
}

/// The reason for rows, in words.
const SIMILAR: &str = "linear in N for similar sizes, in any domain";

/// The reason for the C-grid, in words.
fn long(times: f64) -> String {
    format!(
        "most boxes are long and thin: the C-grid is predicted to be {times:.1} times as fast as sorted rows"
    )
}

/// The reason for levels, in words.
fn unlike(first: &Level, last: &Level) -> String {
    let ratio = last.largest / first.smallest.max(f64::MIN_POSITIVE);
    format!(
        "sizes from {} to {} (ratio {ratio:.1}) are searched fastest in separate levels",
        first.smallest, last.largest
    )
}

impl<T: Real, const D: usize> Search<T, D> for Detector<T, D> {
    fn for_each(&mut self, elements: &Elements<'_, T, D>, visit: impl FnMut(Couple)) -> Result<(), Error> {
        match self.choose(elements) {
            Engine::Direct => self.direct.for_each(elements, visit),
            Engine::Nbs => self.nbs.for_each(elements, visit),
            Engine::Rows => self.rows.for_each(elements, visit),
            Engine::Multilevel => self.multilevel.for_each(elements, visit),
            Engine::CGrid => self.cgrid.for_each(elements, visit),
        }
    }

    fn couples(&mut self, elements: &Elements<'_, T, D>, couples: &mut Vec<Couple>) -> Result<(), Error> {
        match self.choose(elements) {
            Engine::Direct => self.direct.couples(elements, couples),
            Engine::Nbs => self.nbs.couples(elements, couples),
            Engine::Rows => self.rows.couples(elements, couples),
            Engine::Multilevel => self.multilevel.couples(elements, couples),
            Engine::CGrid => self.cgrid.couples(elements, couples),
        }
    }

    fn count(&mut self, elements: &Elements<'_, T, D>) -> Result<u64, Error> {
        match self.choose(elements) {
            Engine::Direct => self.direct.count(elements),
            Engine::Nbs => self.nbs.count(elements),
            Engine::Rows => self.rows.count(elements),
            Engine::Multilevel => self.multilevel.count(elements),
            Engine::CGrid => self.cgrid.count(elements),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_takes_the_engine_of_its_plan() {
        let points = |n: usize| -> Vec<[f64; 2]> { (0..n).map(|k| [k as f64, (k % 7) as f64]).collect() };
        let many = points(5000);
        let radii = |largest: f64| -> Vec<f64> {
            (0..many.len()).map(|k| if k % 1000 == 0 { largest } else { 0.3 }).collect()
        };
        let (like, unlike) = (radii(0.4), radii(300.0));
        let far: Vec<_> =
            many.iter().map(|&[x, y]| if y < 3.0 { [x + 400.0, y] } else { [x, y + 400.0] }).collect();
        let few = points(FEW_ELEMENTS);
        let sets = [
            Elements::points(&few, 1.0),
            Elements::points(&many, 1.0),
            Elements::spheres_with_radii(&many, &like),
            Elements::spheres_with_radii(&many, &unlike),
            Elements::boxes(&many, &far),
        ]
        .map(Result::unwrap);
        let mut chosen = Vec::new();
        for elements in &sets {
            let detector = Detector::new();
            chosen.push(detector.choose(elements));
            assert_eq!(chosen.last(), Some(&detector.plan(elements).unwrap().engine));
            let detector = detector.with_engine(Engine::Nbs);
            assert_eq!(detector.choose(elements), Engine::Nbs);
        }
        assert_eq!(chosen[..4], [Engine::Direct, Engine::Rows, Engine::Rows, Engine::Multilevel]);
    }
}
