//! `fdem contacts --couples` takes the couples, and values such as forces, from a file in place of a search.

use fdem_contact::{Couple, PeriodicBox, PeriodicCouple};
use fdem_io::{FileCouples, read_couples};
use fdem_results::detection::{Detection, DetectionRequest, check_elements, given};
use fdem_results::network::{Couples, Space};

use crate::command::args::CoupleArguments;
use crate::command::failure::Failure;
use crate::command::input::{Input, id, open, refused, unreadable};
use crate::command::progress::Progress;

/// The couples of a file, by the ids of their elements.
pub(crate) struct CoupleFile {
    /// Name of the file in messages.
    pub(crate) name: String,
    couples: FileCouples,
    /// Time to read it, s.
    pub(crate) seconds: f64,
}

/// The couples of a file, by the numbers of their elements, in ascending order.
pub(crate) struct Joined<const D: usize> {
    pub(crate) detection: Detection<D>,
    /// Names and values of the other columns, in the order of the couples.
    pub(crate) columns: Vec<(String, Vec<f64>)>,
    /// The force on the first element of each couple by the second, if it is known.
    pub(crate) forces: Option<Vec<[f64; D]>>,
}

/// Names of the components of a force.
const FORCE: [&str; 3] = ["fx", "fy", "fz"];

impl CoupleFile {
    /// Reads the couples of the time step of the packing; `None` without the option.
    pub(crate) fn read(
        arguments: &CoupleArguments,
        step: Option<i64>,
        max_memory: Option<u64>,
        progress: &Progress,
    ) -> Result<Option<Self>, Failure> {
        let Some(file) = &arguments.couples else { return Ok(None) };
        let opened = open(file, None, max_memory, progress)?;
        let (couples, seconds) = progress.step("reading couples", None, |_| {
            read_couples(&opened.bytes, arguments.couple_columns.as_ref(), step)
        });
        let couples = couples.map_err(|error| unreadable(&opened.name, &error))?;
        Ok(Some(Self { name: opened.name, couples, seconds: seconds + opened.seconds }))
    }

    /// Finds the elements of the couples by their ids.
    pub(crate) fn join<const D: usize>(
        &self,
        input: &Input,
        space: &Space<'_, D>,
        request: &DetectionRequest<'_>,
    ) -> Result<Joined<D>, Failure> {
        // The elements are checked first: those that cannot be wrapped have no nearest image.
        check_elements(space, request).map_err(|error| refused(&input.name, &input.packing, &error))?;
        let found = self.found(input, space)?;
        let couples = match &space.cell {
            None => Couples::Plain(
                found.iter().map(|found| Couple::new(found.couple.i, found.couple.j)).collect(),
            ),
            Some(_) => Couples::Periodic(found.iter().map(|found| found.couple).collect()),
        };
        let detection =
            given(space, request, couples).map_err(|error| refused(&input.name, &input.packing, &error))?;
        let columns: Vec<(String, Vec<f64>)> = self
            .couples
            .columns
            .iter()
            .map(|(name, values)| {
                // The force on the other element of the couple is the opposite one.
                let turns = FORCE.contains(&name.as_str());
                let value = |found: &Found<D>| {
                    if turns && found.turned { 0.0 - values[found.row] } else { values[found.row] }
                };
                (name.clone(), found.iter().map(value).collect())
            })
            .collect();
        let forces = self.forces(space, &detection.couples, &columns)?;
        Ok(Joined { detection, columns, forces })
    }

    fn failure(&self, line: u64, problem: &str) -> Failure {
        Failure::Unusable(format!("{}:{line}: {problem}", self.name))
    }

    /// The couples in ascending order.
    fn found<const D: usize>(&self, input: &Input, space: &Space<'_, D>) -> Result<Vec<Found<D>>, Failure> {
        let packing = &input.packing;
        let mut places: Vec<(i64, u32)> =
            (0..space.centres.len()).map(|index| (id(packing, index), index as u32)).collect();
        places.sort_unstable();
        let mut found = Vec::with_capacity(self.couples.ids.len());
        for (row, ids) in self.couples.ids.iter().enumerate() {
            let line = self.couples.lines[row];
            let mut ends = [0; 2];
            for (end, id) in ends.iter_mut().zip(ids) {
                let Ok(at) = places.binary_search_by_key(id, |(id, _)| *id) else {
                    let named = if packing.ids.is_some() {
                        ""
                    } else {
                        ", whose elements are numbered by rows from 0"
                    };
                    return Err(
                        self.failure(line, &format!("no element of {} has the id {id}{named}", input.name))
                    );
                };
                *end = places[at].1;
            }
            let [first, second] = ends;
            if first == second {
                let problem =
                    format!("the element {} is a couple with itself: its image is not known", ids[0]);
                return Err(self.failure(line, &problem));
            }
            let (i, j) = (first.min(second), first.max(second));
            let shift = match &space.cell {
                None => [0; D],
                Some(cell) => nearest(space, cell, i, j).ok_or_else(|| {
                    let problem = format!(
                        "it is not clear which periodic image of {} touches {}: two are equally near, or they are many boxes \
                         apart",
                        ids[1], ids[0]
                    );
                    self.failure(line, &problem)
                })?,
            };
            found.push(Found { couple: PeriodicCouple { i, j, shift }, row, turned: first > second });
        }
        found.sort_unstable_by_key(|found| (found.couple, found.row));
        match found.windows(2).find(|pair| pair[0].couple == pair[1].couple) {
            None => Ok(found),
            Some(pair) => {
                let [first, again] = [0, 1].map(|k| self.couples.lines[pair[k].row]);
                let [i, j] = self.couples.ids[pair[1].row];
                Err(self
                    .failure(again, &format!("the couple of {i} and {j} is repeated, first on line {first}")))
            }
        }
    }

    /// The forces: `fx`, `fy` and in space `fz`, or else `force` along the line of the centres.
    fn forces<const D: usize>(
        &self,
        space: &Space<'_, D>,
        couples: &Couples<D>,
        columns: &[(String, Vec<f64>)],
    ) -> Result<Option<Vec<[f64; D]>>, Failure> {
        let column = |wanted: &str| columns.iter().find(|(name, _)| name == wanted).map(|(_, values)| values);
        let components = FORCE.map(column);
        if components.iter().any(Option::is_some) {
            if let Some(axis) = (0..D).find(|&axis| components[axis].is_none()) {
                let problem =
                    format!("there is no column {}: a force in {D}D has {D} components", FORCE[axis]);
                return Err(self.failure(self.couples.header, &problem));
            }
            let force =
                |k: usize| std::array::from_fn(|axis| components[axis].map_or(0.0, |values| values[k]));
            return Ok(Some((0..couples.len()).map(force).collect()));
        }
        let Some(values) = column("force") else { return Ok(None) };
        let along = |(couple, force): (PeriodicCouple<D>, &f64)| {
            let (branch, length) = (space.branch(couple), space.distance(couple));
            // Elements at the same place have no direction: only a force of 0 has none either.
            if length == 0.0 && *force != 0.0 {
                return None;
            }
            Some(branch.map(|part| if *force == 0.0 { 0.0 } else { -force * (part / length) }))
        };
        let forces: Option<Vec<_>> = couples.iter().zip(values).map(along).collect();
        forces.map(Some).ok_or_else(|| {
            let problem = "two elements with a force have the same place, and the force has no direction: name fx, fy and fz";
            self.failure(self.couples.header, problem)
        })
    }
}

/// A couple of a row.
struct Found<const D: usize> {
    couple: PeriodicCouple<D>,
    /// The row of the file, counted from 0.
    row: usize,
    /// Whether the first element of the row is the second of the couple.
    turned: bool,
}

/// The shift of the image of `j` that is nearest to `i`; `None` if it is not clear: another image is as near,
/// up to the digits of a file, or the elements are many boxes apart along an axis that is not periodic.
fn nearest<const D: usize>(
    space: &Space<'_, D>,
    cell: &PeriodicBox<f64, D>,
    i: u32,
    j: u32,
) -> Option<[i32; D]> {
    /// Distances of images that differ by less, relative to the distance, count as equal.
    const DIGITS: f64 = 1e-6;
    /// Most edges between an image and the first one.
    const FAR: f64 = 8.0;
    let [(a, of_i), (b, of_j)] = [i, j].map(|element| space.wrapped(cell, element));
    let (periodic, heights) = (cell.periodic(), cell.heights());
    let (from, to) = (cell.fractions(&a), cell.fractions(&b));
    let round = |edge: usize| if periodic[edge] { (from[edge] - to[edge]).round() as i32 } else { 0 };
    let first: [i32; D] = std::array::from_fn(round);
    let distance = |steps: &[i32; D]| {
        let image = cell.displaced(&b, steps);
        (0..D).map(|axis| (image[axis] - a[axis]).powi(2)).sum::<f64>().sqrt()
    };
    let shift = |steps: &[i32; D]| std::array::from_fn(|edge| steps[edge] + of_i[edge] - of_j[edge]);
    let length = distance(&first);
    // Images are at least the smallest height of the box apart.
    let least = (0..D).filter(|&edge| periodic[edge]).map(|edge| heights[edge]).fold(f64::INFINITY, f64::min);
    if length * (1.0 + DIGITS) < least / 2.0 {
        return Some(shift(&first));
    }
    // A nearer image is in the ball of this radius, whose extent along an edge follows from the height.
    let reach: [f64; D] =
        std::array::from_fn(|edge| if periodic[edge] { (length / heights[edge] + 1.0).floor() } else { 0.0 });
    if reach.iter().any(|reach| *reach > FAR) {
        return None;
    }
    let reach = reach.map(|reach| reach as i32);
    let mut steps = reach.map(|reach| -reach);
    let (mut best, mut second) = ((f64::INFINITY, first), f64::INFINITY);
    loop {
        let image: [i32; D] = std::array::from_fn(|edge| first[edge] + steps[edge]);
        let length = distance(&image);
        if length < best.0 {
            second = best.0;
            best = (length, image);
        } else {
            second = second.min(length);
        }
        let Some(edge) = (0..D).find(|&edge| steps[edge] < reach[edge]) else { break };
        steps[edge] += 1;
        for before in 0..edge {
            steps[before] = -reach[before];
        }
    }
    (second > best.0 * (1.0 + DIGITS)).then(|| shift(&best.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shift<const D: usize>(centres: &[[f64; D]; 2], cell: PeriodicBox<f64, D>) -> Option<[i32; D]> {
        nearest(&Space { centres, cell: Some(cell) }, &cell, 0, 1)
    }

    #[test]
    fn the_nearest_image_counts_from_the_places_of_the_file() {
        let cell = PeriodicBox::orthogonal([0.0; 3], [4.0; 3], [true, true, false]).unwrap();
        assert_eq!(shift(&[[0.5, 1.0, 0.0], [3.5, 1.0, 0.0]], cell), Some([-1, 0, 0]));
        assert_eq!(shift(&[[0.5, 1.0, 0.0], [7.5, 1.0, 0.0]], cell), Some([-2, 0, 0]));
        assert_eq!(shift(&[[-3.5, 1.0, 0.0], [3.5, 1.0, 9.0]], cell), Some([-2, 0, 0]));
        assert_eq!(shift(&[[0.5, 1.0, 0.0], [2.5, 1.0, 0.0]], cell), None, "half an edge apart");
        assert_eq!(shift(&[[0.5, 1.0, 0.0], [0.5, 1.0, 90.0]], cell), None, "many boxes apart");
    }

    /// The image is found by comparison with all images in a wide range.
    #[test]
    fn a_sheared_box_has_nearest_images() {
        let cell = PeriodicBox::triclinic([0.0; 2], [[4.0, 0.0], [7.0, 1.5]], [true; 2]).unwrap();
        for k in 0..50 {
            let t = f64::from(k);
            let centres = [[0.3, 0.2], [(t * 0.71) % 9.0 - 2.0, (t * 0.37) % 5.0 - 1.0]];
            let space = Space { centres: &centres, cell: Some(cell) };
            let all = (-20..=20).flat_map(|x| (-20..=20).map(move |y| [x, y]));
            let distance = |shift: &[i32; 2]| space.distance(PeriodicCouple { i: 0, j: 1, shift: *shift });
            let best = all.min_by(|a, b| distance(a).total_cmp(&distance(b)));
            assert_eq!(shift(&centres, cell), best, "{centres:?}");
        }
    }
}
