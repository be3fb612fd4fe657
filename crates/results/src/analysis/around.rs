//! The elements around points, the nearest first, with all images in a periodic box.

use fdem_contact::{Csr, Elements, Index};

use crate::analysis::error::AnalysisError;
use crate::analysis::placed::Placed;
use crate::arrays::each;

/// The elements of a network, to be found around points.
pub(crate) struct Around<'a, const D: usize> {
    placed: &'a Placed<'a, D>,
    centres: Vec<[f64; D]>,
}

/// Elements around a point: all that are not farther than `known`, or more.
pub(crate) struct Surroundings<'a, const D: usize> {
    numbers: &'a [u32],
    squares: &'a [f64],
    positions: &'a [[f64; D]],
    owners: &'a [u32],
    /// No other element and no other image of one is nearer.
    pub(crate) known: f64,
    /// Whether there are no others.
    pub(crate) are_all: bool,
}

/// An element, or an image of one.
pub(crate) struct Neighbour<const D: usize> {
    pub(crate) element: u32,
    pub(crate) centre: [f64; D],
    pub(crate) distance: f64,
}

impl<const D: usize> Surroundings<'_, D> {
    /// The elements, the nearest first.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Neighbour<D>> + '_ {
        let all = self.numbers.iter().zip(self.squares).map(|(&number, square)| Neighbour {
            element: self.owners[number as usize],
            centre: self.positions[number as usize],
            distance: square.sqrt(),
        });
        all.take_while(|neighbour| neighbour.distance <= self.known)
    }
}

impl<'a, const D: usize> Around<'a, D> {
    pub(crate) fn new(placed: &'a Placed<'a, D>) -> Self {
        Self { placed, centres: placed.wrapped() }
    }

    /// The centres, inside of the box.
    pub(crate) fn centres(&self) -> &[[f64; D]] {
        &self.centres
    }

    /// No point is farther from its nearest image of an element, along any direction, in a box that is
    /// periodic along all edges: the points that are nearer to the element than to its images by one edge
    /// are between two planes, and this is how far the corners between all these planes may be.
    pub(crate) fn widest(&self) -> f64 {
        let Some(cell) = &self.placed.network.space.cell else { return 0.0 };
        let (edges, heights) = (cell.edges(), cell.heights());
        (0..D).map(|edge| edges[edge].iter().map(|x| x * x).sum::<f64>() / (2.0 * heights[edge])).sum()
    }

    /// The results of `work` for each point, which gets more elements until it returns a result. It must
    /// return one when it has all elements, or all up to a distance that depends on the network only.
    pub(crate) fn each<T: Send>(
        &self,
        points: &[[f64; D]],
        work: impl Fn(usize, &Surroundings<'_, D>) -> Option<T> + Sync,
    ) -> Result<Vec<T>, AnalysisError> {
        /// Number of elements around a point at first: the cells of most elements are complete with it.
        const FIRST: usize = 48;
        /// Number of points of one look-up, which bounds its memory.
        const CHUNK: usize = 1 << 17;
        /// Number of points of a part of the work.
        const PART: usize = 256;
        let refused = AnalysisError::Search;
        let team = &self.placed.team;
        let is_open = self.placed.frame.periods.iter().all(Option::is_none);
        let mut results: Vec<Option<T>> = points.iter().map(|_| None).collect();
        let mut waiting: Vec<usize> = (0..points.len()).collect();
        let mut margin = 3.0 * self.spacing();
        let mut index = Index::new().with_threads(team.threads()).map_err(refused)?;
        let mut found = Csr::new();
        while !waiting.is_empty() {
            let (positions, owners) = self.with_images(margin);
            index.build(&Elements::points(&positions, margin).map_err(refused)?).map_err(refused)?;
            let mut most = FIRST.min(positions.len());
            loop {
                let (mut left, mut more_would_help) = (Vec::new(), false);
                for chunk in waiting.chunks(CHUNK) {
                    let at: Vec<_> = chunk.iter().map(|&point| points[point]).collect();
                    index.nearest(&at, most, &mut found).map_err(refused)?;
                    let done = team.parts_of(PART, chunk.len(), |range| {
                        let of_point = |row: usize| {
                            let (numbers, squares) = (found.neighbours_of(row), found.values_of(row));
                            let last = squares.last().map_or(0.0, |square| square.sqrt());
                            let known = if is_open { last } else { last.min(margin) };
                            let are_all = is_open && most == positions.len();
                            let near = Surroundings {
                                numbers,
                                squares,
                                positions: &positions,
                                owners: &owners,
                                known,
                                are_all,
                            };
                            (work(chunk[row], &near), last < margin || is_open)
                        };
                        range.map(of_point).collect::<Vec<_>>()
                    });
                    for (&point, (result, helps)) in chunk.iter().zip(done.into_iter().flatten()) {
                        if result.is_none() {
                            left.push(point);
                            more_would_help |= helps;
                        }
                        results[point] = result;
                    }
                }
                waiting = left;
                if waiting.is_empty() || !more_would_help || most == positions.len() {
                    break;
                }
                most = (2 * most).min(positions.len());
            }
            // Images that are farther away.
            margin *= 2.0;
        }
        Ok(results.into_iter().map(|result| result.expect("no point waits")).collect())
    }

    /// Edge of the cube that an element has on average; above 0.
    fn spacing(&self) -> f64 {
        let (network, frame) = (self.placed.network, &self.placed.frame);
        let measure = frame.measure(&frame.domain) / network.space.centres.len().max(1) as f64;
        let edge = measure.powf(1.0 / D as f64);
        if edge > 0.0 { edge } else { 1.0 }
    }

    /// The centres and their images up to `margin` beyond the faces of the box, and the element of each.
    fn with_images(&self, margin: f64) -> (Vec<[f64; D]>, Vec<u32>) {
        let (network, frame) = (self.placed.network, &self.placed.frame);
        let mut positions = self.centres.clone();
        let mut owners: Vec<u32> = (0..positions.len() as u32).collect();
        let Some(cell) = &network.space.cell else { return (positions, owners) };
        let most: [i32; D] =
            each(|axis| frame.periods[axis].map_or(0, |period| (margin / period).ceil() as i32));
        let mut shift: [i32; D] = each(|axis| -most[axis]);
        loop {
            if shift != [0; D] {
                for (element, centre) in self.centres.iter().enumerate() {
                    let image = cell.displaced(centre, &shift);
                    let at = frame.transformed(network, image);
                    let is_near = (0..D).all(|axis| {
                        let [low, high] = frame.domain[axis];
                        frame.periods[axis].is_none()
                            || (low - margin <= at[axis] && at[axis] <= high + margin)
                    });
                    if is_near {
                        positions.push(image);
                        owners.push(element as u32);
                    }
                }
            }
            // The next shift, counted like an odometer.
            let Some(axis) = (0..D).find(|&axis| shift[axis] < most[axis]) else { break };
            shift[axis] += 1;
            for before in 0..axis {
                shift[before] = -most[before];
            }
        }
        (positions, owners)
    }
}
