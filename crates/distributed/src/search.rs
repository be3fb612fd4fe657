//! Search for couples among elements that are spread over ranks.

mod couples;
mod elements;
mod ghosts;
mod owners;
mod runs;

use fdem_contact::{Couple, Detector, Elements, PeriodicBox, PeriodicCouple, Real, Search};

use crate::communicator::Communicator;
use crate::error::{Error, agree, name_by_id};
use crate::wire::{Wire, put_all, put_points};
use couples::FoundCouples;
use elements::{ElementSet, ShapeKind};
use ghosts::{GhostGroups, Ghosts, Lattice, keeper};
use owners::{Owned, distribute};

pub use elements::Shapes;

/// Finds which elements touch, where each rank has some of them. The couples are those that one process would
/// find, to the last bit.
///
/// Each rank gives its elements, any of them, with an id that no other element has. The search sends each
/// element to the rank that owns its part of the domain, and ghosts to neighbours, and finds the couples of
/// each rank with a [`Detector`]. The rank that gets the ghost keeps the couple. No rank holds all elements
/// or all couples.
///
/// # Order
/// Couples are sorted by `i`, `j` and shift over all ranks: rank 0 has the first ones, rank 1 the next ones,
/// and so on, each about the same number.
///
/// # When do two elements touch?
/// The comparison is that of [`Elements`] and, in a periodic box, of
/// [`PeriodicSearch`](fdem_contact::PeriodicSearch), where ids take the place of numbers.
///
/// # Cost
/// With `n` elements and `m` couples in all on `p` ranks: time and memory of a search among about `n / p`
/// elements and the ghosts, which are the elements at the border of a part of the domain. Elements, ghosts
/// and couples are each sent once, and those that stay on their rank are not sent. Elements and couples are
/// counted by cells along the curve or by ids; only crowded cells are sorted to be divided. 4 million spheres
/// that start on the wrong ranks take 8 ranks about the processor time of one process
/// (`bench/DISTRIBUTED.md`). All ranks get the boxes around about 256 groups of elements of each rank, 14 kB
/// in 3D. Large elements are sent to the ranks of the small ones that they may touch, and not the other way.
///
/// # Source
/// S. Plimpton, "Fast parallel algorithms for short-range molecular dynamics", J. Comput. Phys. 117 (1995),
/// for ghosts of a spatial decomposition; M. Parashar, J.C. Browne, "On partitioning dynamic adaptive grid
/// hierarchies", HICSS 1996, for parts along a space-filling curve.
///
/// # Example
/// ```
/// use fdem_contact::Couple;
/// use fdem_distributed::{DistributedSearch, Shapes, threads};
///
/// // A row of discs that touch. Rank 0 has the even ones, rank 1 the odd ones.
/// let couples = threads::run(2, |communicator| {
///     let ids: Vec<u32> = (0..10).filter(|id| *id as usize % 2 == communicator.rank()).collect();
///     let centres: Vec<[f64; 2]> = ids.iter().map(|id| [f64::from(*id), 0.0]).collect();
///     let discs = Shapes::Equal { centres: &centres, radius: 0.5 };
///     DistributedSearch::new(communicator).couples(&ids, &discs, 0.0)
/// });
/// let couples: Vec<Couple> = couples.into_iter().collect::<Result<Vec<_>, _>>()?.concat();
/// assert_eq!(couples, (0..9).map(|i| Couple { i, j: i + 1 }).collect::<Vec<_>>());
/// # Ok::<(), fdem_distributed::Error>(())
/// ```
pub struct DistributedSearch<'c, T, const D: usize> {
    communicator: &'c dyn Communicator,
    detector: Detector<T, D>,
    statistics: Statistics,
}

/// Numbers of this rank in the last search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Elements that this rank owned during the search.
    pub elements: usize,
    /// Ghosts that it got, images in a periodic box included.
    pub ghosts: usize,
    /// Couples that it found, before they were sorted over the ranks.
    pub couples: usize,
}

impl<'c, T: Real, const D: usize> DistributedSearch<'c, T, D> {
    /// A search over these ranks, on one thread of each.
    pub fn new(communicator: &'c dyn Communicator) -> Self {
        Self { communicator, detector: Detector::new(), statistics: Statistics::default() }
    }

    /// The same with `threads` threads on this rank; 0 is one per processor. Not collective. The couples are
    /// the same.
    ///
    /// # Errors
    /// [`fdem_contact::Error::NoThreads`].
    pub fn with_threads(mut self, threads: usize) -> Result<Self, fdem_contact::Error> {
        self.detector = self.detector.with_threads(threads)?;
        Ok(self)
    }

    /// The same with an engine for the search on each rank; `None` chooses one from the elements. The couples
    /// are the same.
    #[must_use]
    pub fn with_engine(mut self, engine: impl Into<Option<fdem_contact::Engine>>) -> Self {
        self.detector = self.detector.with_engine(engine);
        self
    }

    /// Numbers of this rank in the last search.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Finds the couples in open space, and returns this rank's run of them. Collective.
    ///
    /// # Shapes
    /// `ids`: `[n]`, one for each element of `shapes`; each rank has its own `n`. No id occurs twice on all
    /// ranks together.
    ///
    /// # Units
    /// `tolerance`, the largest gap that counts as contact, is in the length unit of the elements. It is the
    /// same on all ranks.
    ///
    /// # Errors
    /// [`Error`], the same on all ranks.
    ///
    /// # Panics
    /// If the number of ids differs from the number of elements.
    pub fn couples(
        &mut self,
        ids: &[u32],
        shapes: &Shapes<'_, T, D>,
        tolerance: T,
    ) -> Result<Vec<Couple>, Error> {
        let elements = self.check(ids, shapes, tolerance, None)?;
        let mut found = FoundCouples::new(self.communicator, ids);
        if self.communicator.size() == 1 {
            let keep = |couple: Couple| {
                let (i, j) = (ids[couple.i as usize], ids[couple.j as usize]);
                found.push(Couple { i: i.min(j), j: i.max(j) });
            };
            let searched = self.detector.for_each(&elements, keep);
            agree(self.communicator, searched.map_err(|error| name(error, ids)))?;
            self.statistics = Statistics { elements: ids.len(), ghosts: 0, couples: found.len() };
        } else {
            let owned = distribute(self.communicator, shapes.view(ids, tolerance), false);
            let ghosts = self.ghosts(&owned, None)?;
            self.search(owned.set, ghosts, None, |i, j, _| found.push(Couple { i, j }))?;
            self.statistics.couples = found.len();
        }
        Ok(found.sorted(self.communicator))
    }

    /// Finds the couples in a periodic box, and returns this rank's run of them. Collective.
    ///
    /// # Shapes
    /// As [`DistributedSearch::couples`]. The box is the same on all ranks.
    ///
    /// # Errors
    /// [`Error`], the same on all ranks.
    ///
    /// # Panics
    /// If the number of ids differs from the number of elements.
    pub fn periodic_couples(
        &mut self,
        ids: &[u32],
        shapes: &Shapes<'_, T, D>,
        tolerance: T,
        cell: &PeriodicBox<T, D>,
    ) -> Result<Vec<PeriodicCouple<D>>, Error> {
        self.check(ids, shapes, tolerance, Some(cell))?;
        let reduced = cell.reduced();
        let cell = reduced.as_ref().map_or(cell, |reduced| &reduced.cell);
        let mut found = FoundCouples::new(self.communicator, ids);
        let wrapped = ElementSet::wrapped(ids, shapes, tolerance, cell).map_err(|error| name(error, ids));
        let wrapped = agree(self.communicator, wrapped)?;
        let owned = distribute(self.communicator, wrapped.view(), true);
        drop(wrapped);
        let [magnitude, reach] = owned.limits;
        let lattice = agree(self.communicator, Lattice::new(cell, magnitude, reach))?;
        let ghosts = self.ghosts(&owned, Some(&lattice))?;
        let checked = reduced.map_or(Ok(()), |reduced| reduced.check_shifts(&ghosts.shifts));
        agree(self.communicator, checked)?;
        let keep = |i, j, shift| {
            let shift = reduced.map_or(shift, |reduced| reduced.shift_of_couple([i, j], &shift));
            found.push(PeriodicCouple { i, j, shift });
        };
        self.search(owned.set, ghosts, Some(&lattice), keep)?;
        self.statistics.couples = found.len();
        Ok(found.sorted(self.communicator))
    }

    /// Checks the elements of this rank, and that all ranks have the same kind of elements, tolerance and
    /// box.
    fn check<'a>(
        &self,
        ids: &[u32],
        shapes: &Shapes<'a, T, D>,
        tolerance: T,
        cell: Option<&PeriodicBox<T, D>>,
    ) -> Result<Elements<'a, T, D>, Error> {
        assert!(ids.len() == shapes.points().len(), "an id for each element");
        let elements = shapes.elements(tolerance).map_err(|error| name(error, ids));
        let elements = agree(self.communicator, elements)?;
        let mut likeness = Vec::new();
        tolerance.to_f64().put(&mut likeness);
        match shapes.kind() {
            ShapeKind::Equal(radius) => radius.to_f64().put(&mut likeness),
            ShapeKind::Spheres => 1_u64.put(&mut likeness),
            ShapeKind::Boxes => 2_u64.put(&mut likeness),
        }
        if let Some(cell) = cell {
            put_points(std::iter::once(cell.origin()).chain(cell.edges()), &mut likeness);
            put_all(cell.periodic(), &mut likeness);
        }
        let all = self.communicator.all_gather(&likeness);
        match all.iter().position(|other| *other != all[0]) {
            Some(rank) => Err(Error::Unlike { rank }),
            None => Ok(elements),
        }
    }

    /// Exchanges ghosts.
    fn ghosts(
        &self,
        owned: &Owned<T, D>,
        lattice: Option<&Lattice<'_, T, D>>,
    ) -> Result<Ghosts<T, D>, Error> {
        let set = &owned.set;
        let id_of = |index: usize| set.ids[index] as usize;
        // Wrapping may have brought a coordinate over the limit.
        let elements = set.elements().map_err(|error| name_by_id(error, id_of));
        let elements = agree(self.communicator, elements)?;
        let groups = GhostGroups::new(&elements, set.view(), &owned.ends, owned.curve);
        let chosen = ghosts::choose(self.communicator, &elements, &groups, lattice);
        let chosen = agree(self.communicator, chosen)?;
        Ok(ghosts::exchange(self.communicator, set, chosen, lattice.is_some()))
    }

    /// Searches this rank's elements and ghosts, and calls `keep` with the ids and the shift of each couple
    /// that this rank keeps, `i < j` as in [`PeriodicCouple`].
    fn search(
        &mut self,
        owned: ElementSet<T, D>,
        ghosts: Ghosts<T, D>,
        lattice: Option<&Lattice<'_, T, D>>,
        mut keep: impl FnMut(u32, u32, [i32; D]),
    ) -> Result<(), Error> {
        let mut all = owned;
        let Ghosts { set: mut ghosts, shifts, owners } = ghosts;
        let (n, rank) = (all.len(), self.communicator.rank());
        self.statistics = Statistics { elements: n, ghosts: ghosts.len(), couples: 0 };
        let ghost_levels: Vec<u16> = (0..ghosts.len()).map(|ghost| ghosts.level(ghost)).collect();
        if shifts.iter().any(|shift| *shift != [0; D]) {
            all.with_radii();
            ghosts.with_radii();
        }
        all.append(&ghosts);
        if let Some(lattice) = lattice {
            for (ghost, shift) in shifts.iter().enumerate().filter(|(_, shift)| **shift != [0; D]) {
                all.displace(n + ghost, lattice.cell, shift, lattice.rounding(shift));
            }
        }
        let periods = |place: usize| all.periods.get(place).copied().unwrap_or([0; D]);
        let visit = |couple: Couple| {
            // The owned element comes first: couples are in ascending order of places.
            let (a, b) = (couple.i as usize, couple.j as usize);
            if a >= n {
                return;
            }
            let (id, other) = (all.ids[a], all.ids[b]);
            if b < n && all.periods.is_empty() {
                keep(id.min(other), id.max(other), [0; D]);
                return;
            }
            let (i, j) = if id <= other { (a, b) } else { (b, a) };
            // Displacement of the second element, inside the box.
            let mut shift = [0; D];
            if b >= n {
                let ghost = b - n;
                let owner = owners[ghost] as usize;
                shift = shifts[ghost];
                let is_kept = match ghost_levels[ghost].cmp(&all.level(a)) {
                    std::cmp::Ordering::Less => false,
                    std::cmp::Ordering::Greater => true,
                    std::cmp::Ordering::Equal if owner != rank => keeper(owner, rank) == rank,
                    std::cmp::Ordering::Equal => other > id || (other == id && shift > [0; D]),
                };
                if !is_kept {
                    return;
                }
                if let (Some(lattice), true) = (lattice, shift != [0; D]) {
                    let touches = if i == a {
                        all.touches_image(a, (&ghosts, ghost), lattice.cell, &shift)
                    } else {
                        shift = shift.map(|edges| -edges);
                        ghosts.touches_image(ghost, (&all, a), lattice.cell, &shift)
                    };
                    if !touches {
                        return;
                    }
                }
            }
            let (before, after) = (periods(i), periods(j));
            let shift = std::array::from_fn(|edge| shift[edge] + before[edge] - after[edge]);
            keep(all.ids[i], all.ids[j], shift);
        };
        let searched = all.elements().and_then(|elements| self.detector.for_each(&elements, visit));
        agree(self.communicator, searched.map_err(|error| name_by_id(error, |index| all.ids[index] as usize)))
    }
}

fn name(error: fdem_contact::Error, ids: &[u32]) -> fdem_contact::Error {
    name_by_id(error, |index| ids[index] as usize)
}
