//! Filters: which elements may form couples at all, by body, by group, or by category and mask.

use crate::error::{Error, check_lengths};
use crate::memory::{reserve, resize};
use crate::pool::Pool;

/// A filter on couples. Two elements that do not *see* each other form no couple, even where they touch.
///
/// A filter is attached by [`Elements::with_filter`](crate::Elements::with_filter). It is then part of the
/// definition of contact, so every engine honours it. [`Rows`](crate::Rows) tests it a vector at a time
/// together with the distance, and never stores a couple that the filter excludes. The couples and their
/// order are those that filtering the list afterwards would give. There are three kinds; bodies can be
/// combined with either of the others:
/// - *bodies*: elements with the same number are parts of one body, and form no couple. An element that is a
///   body by itself needs a number that no other element has.
/// - *categories and masks*: `i` and `j` see each other if `category_i & mask_j != 0` and
///   `category_j & mask_i != 0`. There are 32 categories; an element may have several.
/// - *groups*: each element belongs to one group, and a symmetric [`GroupMatrix`] says which groups see each
///   other. There may be any number of groups.
///
/// In a periodic box an image has the numbers of its element, so an element and its own image belong to one
/// body.
///
/// # Shapes
/// `[n]` numbers for `n` elements, in their order. The filter borrows them and copies nothing.
///
/// # Cost
/// `Rows` keeps 4 bytes per element for bodies, 4 for groups of a matrix with more than 32 groups, and 8 for
/// masks or fewer groups. A search takes a few instructions more per vector. Attaching groups checks each of
/// them once.
///
/// # Example
/// ```
/// use fdem_contact::{Couple, Elements, Filter, Rows, Search};
///
/// // Two bodies of two discs each, all in a row and touching.
/// let centres = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]];
/// let bodies = [0, 0, 1, 1];
/// let discs = Elements::points(&centres, 1.0)?.with_filter(Filter::bodies(&bodies))?;
/// assert!(discs.touch(1, 2) && !discs.touch(0, 1));
///
/// let mut couples = Vec::new();
/// Rows::new().couples(&discs, &mut couples)?;
/// assert_eq!(couples, [Couple::new(1, 2)]);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[doc(alias = "exclusion")]
#[doc(alias = "collision layers")]
#[derive(Clone, Copy, Debug)]
pub struct Filter<'a> {
    pub(crate) bodies: Option<&'a [u32]>,
    pub(crate) sight: Sight<'a>,
}

/// The second part of a filter, which bodies can be combined with.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Sight<'a> {
    All,
    Masks { categories: &'a [u32], masks: &'a [u32] },
    Groups { groups: &'a [u32], matrix: &'a GroupMatrix },
}

impl<'a> Filter<'a> {
    /// Elements of one body form no couple.
    ///
    /// # Shapes
    /// `bodies` `[n]`: any numbers.
    #[doc(alias = "clump")]
    pub fn bodies(bodies: &'a [u32]) -> Self {
        Self { bodies: Some(bodies), sight: Sight::All }
    }

    /// Elements see each other if each has a category that the mask of the other has.
    ///
    /// # Shapes
    /// `categories`, `masks` `[n]`: 32 bits each. An element without any bit in either sees nothing.
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{Elements, Filter};
    ///
    /// const GRAIN: u32 = 1;
    /// const WALL: u32 = 2;
    /// let categories = [GRAIN, GRAIN, WALL, WALL];
    /// let masks = [GRAIN | WALL, GRAIN | WALL, GRAIN, GRAIN]; // walls do not see walls
    /// let spheres = Elements::points(&[[0.0; 3]; 4], 1.0)?.with_filter(Filter::masks(&categories, &masks))?;
    /// assert!(spheres.touch(0, 1) && spheres.touch(0, 2) && !spheres.touch(2, 3));
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    pub fn masks(categories: &'a [u32], masks: &'a [u32]) -> Self {
        Self { bodies: None, sight: Sight::Masks { categories, masks } }
    }

    /// Elements see each other if the matrix says that their groups do.
    ///
    /// # Shapes
    /// `groups` `[n]`: numbers below [`GroupMatrix::groups`].
    ///
    /// # Example
    /// ```
    /// use fdem_contact::{Elements, Filter, GroupMatrix};
    ///
    /// let mut matrix = GroupMatrix::all(2)?;
    /// matrix.set(1, 1, false)?; // walls, group 1, do not see walls
    /// let groups = [0, 0, 1, 1];
    /// let spheres = Elements::points(&[[0.0; 3]; 4], 1.0)?.with_filter(Filter::groups(&groups, &matrix))?;
    /// assert!(spheres.touch(0, 1) && spheres.touch(0, 2) && !spheres.touch(2, 3));
    /// # Ok::<(), fdem_contact::Error>(())
    /// ```
    pub fn groups(groups: &'a [u32], matrix: &'a GroupMatrix) -> Self {
        Self { bodies: None, sight: Sight::Groups { groups, matrix } }
    }

    /// The same filter; in addition, elements of one body form no couple.
    ///
    /// # Shapes
    /// As [`Filter::bodies`].
    #[must_use]
    pub fn with_bodies(mut self, bodies: &'a [u32]) -> Self {
        self.bodies = Some(bodies);
        self
    }

    /// Whether elements `i` and `j` may form a couple; symmetric.
    ///
    /// # Panics
    /// When `i` or `j` is not below the number of elements.
    #[inline]
    pub fn admits(&self, i: usize, j: usize) -> bool {
        self.admits_of(i, self, j)
    }

    /// Whether element `i` may form a couple with element `j` of another filter, which has the same kind and
    /// the same matrix.
    #[inline]
    pub(crate) fn admits_of(&self, i: usize, other: &Self, j: usize) -> bool {
        if let (Some(bodies), Some(others)) = (self.bodies, other.bodies)
            && bodies[i] == others[j]
        {
            return false;
        }
        match (self.sight, other.sight) {
            (Sight::Masks { categories: a, masks }, Sight::Masks { categories: b, masks: others }) => {
                a[i] & others[j] != 0 && b[j] & masks[i] != 0
            }
            (Sight::Groups { groups, matrix }, Sight::Groups { groups: others, .. }) => {
                matrix.sees(groups[i], others[j])
            }
            _ => true,
        }
    }

    /// Whether `other` has the same kinds of numbers and the same matrix.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.bodies.is_some() == other.bodies.is_some()
            && match (self.sight, other.sight) {
                (Sight::All, Sight::All) | (Sight::Masks { .. }, Sight::Masks { .. }) => true,
                (Sight::Groups { matrix: a, .. }, Sight::Groups { matrix: b, .. }) => a == b,
                _ => false,
            }
    }

    /// Checks that there is one number of each kind for each of `elements` elements, and that the matrix has
    /// all groups.
    pub(crate) fn check(&self, elements: usize) -> Result<(), Error> {
        if let Some(bodies) = self.bodies {
            check_lengths("bodies", elements, bodies.len())?;
        }
        match self.sight {
            Sight::All => Ok(()),
            Sight::Masks { categories, masks } => {
                check_lengths("categories", elements, categories.len())?;
                check_lengths("masks", elements, masks.len())
            }
            Sight::Groups { groups, matrix } => {
                check_lengths("groups", elements, groups.len())?;
                groups.iter().enumerate().try_for_each(|(index, &group)| matrix.check(Some(index), group))
            }
        }
    }

    /// The kinds of numbers that a filter needs to be like this one, and the matrix.
    pub(crate) fn kind(&self) -> Result<FilterKind, Error> {
        let masks = matches!(self.sight, Sight::Masks { .. });
        let matrix = self.matrix().map(GroupMatrix::copy).transpose()?;
        Ok(FilterKind { bodies: self.bodies.is_some(), masks, matrix })
    }

    /// The numbers by which another device filters couples.
    pub fn numbers(&self) -> FilterNumbers<'a> {
        let [bodies, firsts, seconds] = self.arrays();
        let (matrix, words): (&[u32], _) =
            self.matrix().map_or((&[], 0), |matrix| (&matrix.bits, matrix.words()));
        FilterNumbers { bodies, firsts, seconds, matrix, words }
    }

    /// The matrix of groups, if the filter has one.
    pub(crate) fn matrix(&self) -> Option<&'a GroupMatrix> {
        if let Sight::Groups { matrix, .. } = self.sight { Some(matrix) } else { None }
    }

    /// The arrays of numbers in the order of [`Labels`].
    fn arrays(&self) -> [&'a [u32]; 3] {
        let [firsts, seconds]: [&[u32]; 2] = match self.sight {
            Sight::All => [&[], &[]],
            Sight::Masks { categories, masks } => [categories, masks],
            Sight::Groups { groups, .. } => [groups, &[]],
        };
        [self.bodies.unwrap_or_default(), firsts, seconds]
    }
}

/// The numbers of a [`Filter`]; arrays of kinds that it lacks are empty.
///
/// Elements `i` and `j` may form a couple if `bodies` differ, and, with a matrix, if bit `firsts[j] % 32` of
/// `matrix[firsts[i] * words + firsts[j] / 32]` is 1, or, without one, if `firsts[i] & seconds[j]` and
/// `firsts[j] & seconds[i]` are not 0.
#[derive(Clone, Copy, Debug)]
pub struct FilterNumbers<'a> {
    /// The body of each element.
    pub bodies: &'a [u32],
    /// The categories, or the groups, of each element.
    pub firsts: &'a [u32],
    /// The mask of each element.
    pub seconds: &'a [u32],
    /// The rows of the matrix of groups.
    pub matrix: &'a [u32],
    /// Words of a row of the matrix.
    pub words: usize,
}

/// The kinds of numbers of a filter, and its matrix.
#[derive(Clone, Debug)]
pub(crate) struct FilterKind {
    bodies: bool,
    masks: bool,
    matrix: Option<GroupMatrix>,
}

impl FilterKind {
    /// Whether `filter` [is like](Filter::is_like) the one of this kind.
    pub(crate) fn is_of(&self, filter: &Filter<'_>) -> bool {
        self.bodies == filter.bodies.is_some()
            && self.masks == matches!(filter.sight, Sight::Masks { .. })
            && self.matrix.as_ref() == filter.matrix()
    }
}

/// A symmetric matrix of bits: which groups see each other.
///
/// # Cost
/// Memory: `g²` bits for `g` groups, each row rounded up to a multiple of 32. [`Rows`](crate::Rows) tests
/// matrices of up to 32 groups as categories and masks.
///
/// # Example
/// ```
/// let mut matrix = fdem_contact::GroupMatrix::none(40)?;
/// matrix.set(39, 3, true)?;
/// assert!(matrix.sees(3, 39) && matrix.sees(39, 3) && !matrix.sees(3, 3));
/// # Ok::<(), fdem_contact::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GroupMatrix {
    groups: usize,
    /// The rows one after the other, in whole words; bits behind the last group are 0.
    bits: Vec<u32>,
}

impl GroupMatrix {
    /// Every group sees every group, itself included.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn all(groups: usize) -> Result<Self, Error> {
        let mut matrix = Self::none(groups)?;
        let words = matrix.words();
        for row in matrix.bits.chunks_exact_mut(words.max(1)) {
            row.fill(u32::MAX);
            if !groups.is_multiple_of(WORD) {
                row[words - 1] = (1 << (groups % WORD)) - 1;
            }
        }
        Ok(matrix)
    }

    /// No group sees any group.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn none(groups: usize) -> Result<Self, Error> {
        let words = groups.saturating_mul(groups.div_ceil(WORD));
        let mut bits = Vec::new();
        let out_of_memory = |_| Error::OutOfMemory { bytes: words.saturating_mul(size_of::<u32>()) };
        bits.try_reserve_exact(words).map_err(out_of_memory)?;
        bits.resize(words, 0);
        Ok(Self { groups, bits })
    }

    /// A copy of the matrix, or an error if there is no memory for it.
    pub(crate) fn copy(&self) -> Result<Self, Error> {
        let mut copy = Self::none(self.groups)?;
        copy.bits.copy_from_slice(&self.bits);
        Ok(copy)
    }

    /// Sets whether groups `a` and `b` see each other.
    ///
    /// # Errors
    /// [`Error::UnknownGroup`].
    pub fn set(&mut self, a: u32, b: u32, see: bool) -> Result<(), Error> {
        self.check(None, a)?;
        self.check(None, b)?;
        for (row, column) in [(a, b), (b, a)] {
            let word = row as usize * self.words() + column as usize / WORD;
            let bit = 1 << (column as usize % WORD);
            if see {
                self.bits[word] |= bit;
            } else {
                self.bits[word] &= !bit;
            }
        }
        Ok(())
    }

    /// Whether groups `a` and `b` see each other.
    ///
    /// # Panics
    /// When `a` or `b` is not below [`GroupMatrix::groups`].
    #[inline]
    pub fn sees(&self, a: u32, b: u32) -> bool {
        assert!((b as usize) < self.groups, "there is no group {b}");
        self.row(a)[b as usize / WORD] >> (b as usize % WORD) & 1 == 1
    }

    /// Number of groups.
    pub fn groups(&self) -> usize {
        self.groups
    }

    /// The groups that a group sees: one bit each.
    #[inline]
    pub(crate) fn row(&self, group: u32) -> &[u32] {
        &self.bits[group as usize * self.words()..][..self.words()]
    }

    fn words(&self) -> usize {
        self.groups.div_ceil(WORD)
    }

    fn check(&self, index: Option<usize>, group: u32) -> Result<(), Error> {
        if (group as usize) < self.groups {
            return Ok(());
        }
        Err(Error::UnknownGroup { index, group, groups: self.groups })
    }
}

/// Bits per word of the matrix.
const WORD: usize = 32;

/// The arrays of numbers of a filter in the order of [`Labels`]; empty without a filter.
fn numbers_of(filter: Option<Filter<'_>>) -> [&[u32]; 3] {
    filter.map(|filter| filter.arrays()).unwrap_or_default()
}

/// A copy of the numbers of a filter: in another order, for more elements, or to compare with later ones.
///
/// # Shapes
/// One array for each kind of number in the order bodies, categories or groups, masks. Arrays of kinds that
/// the filter lacks are empty.
#[derive(Clone, Debug, Default)]
pub(crate) struct Labels {
    arrays: [Vec<u32>; 3],
    /// All groups of [`Labels::arrange`] are below this number; 0 where it kept none.
    groups: usize,
}

/// A filter whose numbers [`Labels`] holds in the order of a layout, checked: its groups, the padding
/// included, are groups of its matrix.
///
/// Kernels look groups up without a check, so only [`Labels::arranged`] makes this.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arranged<'a>(Filter<'a>);

impl<'a> Arranged<'a> {
    pub(crate) fn filter(&self) -> &Filter<'a> {
        &self.0
    }
}

impl Labels {
    /// Numbers per element that [`Labels::arrange`] keeps.
    pub(crate) fn numbers_of(filter: &Filter<'_>) -> usize {
        let sight = match filter.sight {
            Sight::All => 0,
            Sight::Groups { matrix, .. } if matrix.groups() > WORD => 1,
            Sight::Masks { .. } | Sight::Groups { .. } => 2,
        };
        sight + usize::from(filter.bodies.is_some())
    }

    /// Takes the numbers of the elements `order`, followed by `padding` unused entries. Groups that fit into
    /// a word become categories and masks.
    ///
    /// Without a filter, the arrays become empty but keep their memory.
    pub(crate) fn arrange(
        &mut self,
        filter: Option<Filter<'_>>,
        order: &[u32],
        padding: usize,
        pool: &Pool,
    ) -> Result<(), Error> {
        self.clear();
        let Some(filter) = filter else { return Ok(()) };
        let [bodies, firsts, seconds] = &mut self.arrays;
        let gather = |into: &mut Vec<u32>, number: &(dyn Fn(usize) -> u32 + Sync)| {
            resize(into, order.len() + padding, 0)?;
            let stretch = order.len().div_ceil(pool.threads()).max(1);
            pool.run(into.chunks_mut(stretch).zip(order.chunks(stretch)), |(into, order)| {
                for (into, &element) in into.iter_mut().zip(order) {
                    *into = number(element as usize);
                }
            });
            Ok(())
        };
        if let Some(theirs) = filter.bodies {
            gather(bodies, &|element| theirs[element])?;
        }
        match filter.sight {
            Sight::All => Ok(()),
            Sight::Masks { categories, masks } => {
                gather(firsts, &|element| categories[element])?;
                gather(seconds, &|element| masks[element])
            }
            Sight::Groups { groups, matrix } if matrix.groups() <= WORD => {
                gather(firsts, &|element| 1 << groups[element])?;
                gather(seconds, &|element| matrix.row(groups[element])[0])
            }
            Sight::Groups { groups, matrix } => {
                self.groups = matrix.groups();
                gather(firsts, &|element| {
                    assert!((groups[element] as usize) < matrix.groups());
                    groups[element]
                })
            }
        }
    }

    /// Takes the numbers of all elements.
    pub(crate) fn copy(&mut self, filter: Option<Filter<'_>>) -> Result<(), Error> {
        self.clear();
        for (into, numbers) in self.arrays.iter_mut().zip(numbers_of(filter)) {
            reserve(into, numbers.len())?;
            into.extend_from_slice(numbers);
        }
        Ok(())
    }

    /// Takes the numbers of the given elements.
    pub(crate) fn pick<'a>(
        &mut self,
        filter: Option<Filter<'_>>,
        elements: &(impl Iterator<Item = &'a u32> + Clone),
    ) -> Result<(), Error> {
        self.clear();
        for (into, numbers) in self.arrays.iter_mut().zip(numbers_of(filter)) {
            if !numbers.is_empty() {
                reserve(into, elements.clone().count())?;
                into.extend(elements.clone().map(|&element| numbers[element as usize]));
            }
        }
        Ok(())
    }

    /// `filter`, with the numbers that [`Labels::arrange`] took from it.
    ///
    /// # Panics
    /// If the groups were not arranged, or for a matrix of another size.
    pub(crate) fn arranged<'a>(&'a self, filter: Filter<'a>) -> Arranged<'a> {
        let arranged = self.filter(filter);
        if let Some(matrix) = arranged.matrix() {
            assert_eq!(matrix.groups(), self.groups, "groups arranged for another matrix");
        }
        Arranged(arranged)
    }

    /// Returns `filter` with these numbers in place of its own.
    pub(crate) fn filter<'a>(&'a self, filter: Filter<'a>) -> Filter<'a> {
        let [bodies, firsts, seconds] = &self.arrays;
        let sight = match filter.sight {
            Sight::All => Sight::All,
            Sight::Groups { matrix, .. } if seconds.is_empty() => Sight::Groups { groups: firsts, matrix },
            Sight::Masks { .. } | Sight::Groups { .. } => Sight::Masks { categories: firsts, masks: seconds },
        };
        Filter { bodies: filter.bodies.map(|_| bodies.as_slice()), sight }
    }

    /// The filter that [`Labels::copy`] was given, with its `matrix`; `None` also if there were no elements.
    pub(crate) fn as_filter<'a>(&'a self, matrix: Option<&'a GroupMatrix>) -> Option<Filter<'a>> {
        let [bodies, firsts, seconds] = &self.arrays;
        let sight = match matrix {
            Some(matrix) => Sight::Groups { groups: firsts, matrix },
            None if seconds.is_empty() => Sight::All,
            None => Sight::Masks { categories: firsts, masks: seconds },
        };
        let bodies = (!bodies.is_empty()).then_some(bodies.as_slice());
        (bodies.is_some() || !firsts.is_empty()).then_some(Filter { bodies, sight })
    }

    /// Whether these numbers are those of `filter`.
    pub(crate) fn equal(&self, filter: Option<Filter<'_>>) -> bool {
        self.arrays == numbers_of(filter)
    }

    /// The first element whose number differs in `filter`; `None` if there is none, or if the two have
    /// different arrays.
    pub(crate) fn first_change(&self, filter: Option<Filter<'_>>) -> Option<usize> {
        let theirs = numbers_of(filter);
        if self.arrays.iter().zip(theirs).any(|(ours, theirs)| ours.len() != theirs.len()) {
            return None;
        }
        let change = |(ours, theirs): (&Vec<u32>, &[u32])| ours.iter().zip(theirs).position(|(a, b)| a != b);
        self.arrays.iter().zip(theirs).filter_map(change).min()
    }

    pub(crate) fn bytes(&self) -> usize {
        self.arrays.iter().map(Vec::capacity).sum::<usize>() * size_of::<u32>()
    }

    fn clear(&mut self) {
        self.arrays.iter_mut().for_each(Vec::clear);
        self.groups = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row of the matrix of 40 groups has no bit for group 69: a kernel that looked it up would read behind
    /// the row.
    #[test]
    #[should_panic(expected = "another matrix")]
    fn groups_go_with_the_matrix_that_they_were_checked_against() {
        let (large, small) = (GroupMatrix::all(70).unwrap(), GroupMatrix::all(40).unwrap());
        let mut labels = Labels::default();
        labels.arrange(Some(Filter::groups(&[69], &large)), &[0], 16, &Pool::default()).unwrap();
        labels.arranged(Filter::groups(&[0], &small));
    }

    #[test]
    #[should_panic(expected = "matrix.groups()")]
    fn a_group_that_the_matrix_lacks_is_not_arranged() {
        let matrix = GroupMatrix::all(40).unwrap();
        let unchecked = Filter::groups(&[40], &matrix);
        Labels::default().arrange(Some(unchecked), &[0], 16, &Pool::default()).unwrap();
    }
}
