//! Common code of the fuzz targets: makes elements from arbitrary bytes.

use arbitrary::{Result, Unstructured};
use fdem_contact::{Couple, CrossCouple, Direct, Elements, Error, Filter, GroupMatrix, Real, Search};

/// A float type that can be made from arbitrary bits.
pub trait Number: Real {
    /// Any value of the type, including NaN, infinite and subnormal ones.
    fn any_bits(bytes: &mut Unstructured<'_>) -> Result<Self>;

    /// A small integer.
    fn small(value: i8) -> Self;

    /// The magnitude.
    fn magnitude(self) -> Self;
}

macro_rules! impl_number {
    ($type:ty, $bits:ty) => {
        impl Number for $type {
            fn any_bits(bytes: &mut Unstructured<'_>) -> Result<Self> {
                Ok(Self::from_bits(bytes.arbitrary::<$bits>()?))
            }

            fn small(value: i8) -> Self {
                Self::from(value)
            }

            fn magnitude(self) -> Self {
                self.abs()
            }
        }
    };
}

impl_number!(f32, u32);
impl_number!(f64, u64);

/// Largest number of elements: small enough for all-against-all to be fast, large enough for rows longer than
/// a few vectors.
const MOST_ELEMENTS: usize = 300;

/// The shape of the elements.
#[derive(Debug)]
enum Shape<T, const D: usize> {
    Points(T),
    Spheres(T),
    Radii(Box<[T]>),
    Boxes(Box<[[T; D]]>),
}

/// The numbers of a filter.
#[derive(Debug)]
struct Labels {
    kind: u8,
    bodies: Box<[u32]>,
    categories: Box<[u32]>,
    masks: Box<[u32]>,
    groups: Box<[u32]>,
    matrix: GroupMatrix,
}

impl Labels {
    /// Makes labels from one byte per element; `kind` is the kind for all elements.
    fn new(kind: u8, of_each: &[u8]) -> Self {
        let numbers = |number: fn(u32) -> u32| of_each.iter().map(|&byte| number(byte.into())).collect();
        // A matrix of 32 groups becomes masks internally; one of 70 does not.
        let of_groups: [fn(u32) -> u32; 2] = [|byte| byte % 32, |byte| byte % 70];
        let few = kind % 2 == 0;
        let count = if few { 32 } else { 70 };
        let mut matrix = GroupMatrix::none(count as usize).expect("there is room for a few words");
        for (a, b) in (0..count).flat_map(|a| (0..=a).map(move |b| (a, b))) {
            matrix.set(a, b, (a * a + 3 * b) % 5 < 3).expect("both are groups of the matrix");
        }
        Self {
            kind,
            bodies: numbers(|byte| byte % 3),
            categories: numbers(|byte| byte % 8),
            masks: numbers(|byte| byte / 8 % 8),
            groups: numbers(of_groups[usize::from(!few)]),
            matrix,
        }
    }

    fn filter(&self) -> Option<Filter<'_>> {
        match self.kind {
            0 => Some(Filter::bodies(&self.bodies)),
            1 => Some(Filter::masks(&self.categories, &self.masks)),
            2 | 3 => Some(Filter::groups(&self.groups, &self.matrix)),
            4 => Some(Filter::masks(&self.categories, &self.masks).with_bodies(&self.bodies)),
            5 => Some(Filter::groups(&self.groups, &self.matrix).with_bodies(&self.bodies)),
            _ => None,
        }
    }

    /// Whether element `i` sees element `j` of another set with the same kind of labels.
    fn see(&self, i: usize, other: &Self, j: usize) -> bool {
        let bodies = self.bodies[i] != other.bodies[j];
        let masks = self.categories[i] & other.masks[j] != 0 && other.categories[j] & self.masks[i] != 0;
        let groups = || self.matrix.sees(self.groups[i], other.groups[j]);
        match self.kind {
            0 => bodies,
            1 => masks,
            2 | 3 => groups(),
            4 => masks && bodies,
            5 => groups() && bodies,
            _ => true,
        }
    }
}

/// A set of elements, valid or not, in arrays of exactly its length, so that the sanitizer detects a read
/// behind them.
#[derive(Debug)]
pub struct Scene<T, const D: usize> {
    points: Box<[[T; D]]>,
    shape: Shape<T, D>,
    tolerance: T,
    labels: Labels,
}

impl<T: Number, const D: usize> Scene<T, D> {
    fn new(bytes: &mut Unstructured<'_>) -> Result<Self> {
        let numbers = Numbers::new(bytes)?;
        let (shape, filter) = (bytes.int_in_range(0..=3)?, bytes.int_in_range(0..=11)?);
        Self::of(&numbers, shape, filter, MOST_ELEMENTS, bytes)
    }

    /// At most `most` elements, as far as the bytes suffice.
    fn of(
        numbers: &Numbers<T>,
        shape: u8,
        filter: u8,
        most: usize,
        bytes: &mut Unstructured<'_>,
    ) -> Result<Self> {
        let tolerance = if bytes.ratio(1, 2)? { T::ZERO } else { numbers.length(bytes)? };
        let size = numbers.length(bytes)?;
        let (mut points, mut radii, mut corners) = (Vec::new(), Vec::new(), Vec::new());
        let mut labels = Vec::new();
        while !bytes.is_empty() && points.len() < most {
            let point = numbers.point(bytes)?;
            points.push(point);
            labels.push(if filter < 6 { bytes.arbitrary()? } else { 0 });
            match shape {
                2 => radii.push(numbers.length(bytes)?),
                3 => {
                    let edges: [T; D] = numbers.lengths(bytes)?;
                    corners.push(std::array::from_fn(|axis| point[axis] + edges[axis]));
                }
                _ => {}
            }
        }
        let shape = match shape {
            0 => Shape::Points(size),
            1 => Shape::Spheres(size),
            2 => Shape::Radii(radii.into()),
            _ => Shape::Boxes(corners.into()),
        };
        Ok(Self { points: points.into(), shape, tolerance, labels: Labels::new(filter, &labels) })
    }

    /// # Errors
    /// The errors of [`Elements`].
    pub fn elements(&self) -> std::result::Result<Elements<'_, T, D>, Error> {
        let elements = match &self.shape {
            Shape::Points(cutoff) => Elements::points(&self.points, *cutoff),
            Shape::Spheres(radius) => Elements::spheres(&self.points, *radius),
            Shape::Radii(radii) => Elements::spheres_with_radii(&self.points, radii),
            Shape::Boxes(max) => Elements::boxes(&self.points, max),
        }?
        .with_tolerance(self.tolerance)?;
        match self.labels.filter() {
            Some(filter) => elements.with_filter(filter),
            None => Ok(elements),
        }
    }
}

/// Two sets of elements with numbers from one lattice, so that they touch often, and points for queries.
#[derive(Debug)]
pub struct Pair<T, const D: usize> {
    /// The querying elements.
    pub moving: Scene<T, D>,
    /// The elements of the index.
    pub fixed: Scene<T, D>,
    /// Points for queries.
    pub points: Box<[[T; D]]>,
    /// Distance of the queries.
    pub r: T,
    /// Number of nearest elements.
    pub k: usize,
}

impl<T: Number, const D: usize> Pair<T, D> {
    fn new(bytes: &mut Unstructured<'_>) -> Result<Self> {
        let numbers = Numbers::new(bytes)?;
        let shape = bytes.int_in_range(0..=3)?;
        let filter = bytes.int_in_range(0..=11)?;
        // The shapes are mostly equal, because otherwise every search would be refused.
        let other_shape = if shape < 3 { bytes.int_in_range(0..=2)? } else { 3 };
        let other_shape = if bytes.ratio(1, 16)? { bytes.int_in_range(0..=3)? } else { other_shape };
        let other_filter = if bytes.ratio(1, 16)? { bytes.int_in_range(0..=11)? } else { filter };
        let r = numbers.length(bytes)?;
        let k = usize::from(bytes.arbitrary::<u8>()? % 40);
        let most = |bytes: &mut Unstructured<'_>| Ok(usize::from(bytes.arbitrary::<u8>()?));
        let (points_at_most, moving_at_most, fixed_at_most) = (most(bytes)? % 64, most(bytes)?, most(bytes)?);
        let mut points = Vec::new();
        while !bytes.is_empty() && points.len() < points_at_most {
            points.push(numbers.point(bytes)?);
        }
        let moving = Scene::of(&numbers, other_shape, other_filter, moving_at_most, bytes)?;
        let fixed = Scene::of(&numbers, shape, filter, fixed_at_most, bytes)?;
        Ok(Self { moving, fixed, points: points.into(), r, k })
    }
}

impl<T: Number, const D: usize> Scene<T, D> {
    /// The centres, or the minimum corners of boxes.
    pub fn points(&self) -> &[[T; D]] {
        &self.points
    }

    /// The couples that the documentation of `Index` specifies for elements of this scene and of another one,
    /// ascending; or the specified error.
    ///
    /// # Errors
    /// [`Error::UnlikeShapes`], [`Error::UnlikeFilters`].
    pub fn couples_with(&self, other: &Self) -> std::result::Result<Vec<CrossCouple>, Error> {
        let boxes = |scene: &Self| matches!(scene.shape, Shape::Boxes(_));
        if boxes(self) != boxes(other) {
            return Err(Error::UnlikeShapes);
        }
        if self.points.is_empty() || other.points.is_empty() {
            return Ok(Vec::new());
        }
        let kind = |scene: &Self| scene.labels.filter().is_some().then_some(scene.labels.kind);
        if kind(self) != kind(other) {
            return Err(Error::UnlikeFilters);
        }
        let all = (0..self.points.len()).flat_map(|i| (0..other.points.len()).map(move |j| (i, j)));
        let touching = all.filter(|&(i, j)| self.labels.see(i, &other.labels, j) && self.touch(i, other, j));
        Ok(touching.map(|(i, j)| CrossCouple { i: i as u32, j: j as u32 }).collect())
    }

    /// The comparison documented at `Elements`, with the larger of the tolerances.
    fn touch(&self, i: usize, other: &Self, j: usize) -> bool {
        let tolerance = if self.tolerance > other.tolerance { self.tolerance } else { other.tolerance };
        if let (Shape::Boxes(far), Shape::Boxes(others)) = (&self.shape, &other.shape) {
            return (0..D).all(|axis| {
                self.points[i][axis] <= others[j][axis] + tolerance
                    && other.points[j][axis] <= far[i][axis] + tolerance
            });
        }
        let reach = (self.radius(i) + other.radius(j)) + tolerance;
        distance_squared(&self.points[i], &other.points[j]) <= reach * reach
    }

    fn radius(&self, index: usize) -> T {
        match &self.shape {
            Shape::Points(cutoff) => *cutoff * T::HALF,
            Shape::Spheres(radius) => *radius,
            Shape::Radii(radii) => radii[index],
            Shape::Boxes(_) => T::ZERO,
        }
    }
}

/// The sum documented at `Elements::distance_squared`.
pub fn distance_squared<T: Real, const D: usize>(a: &[T; D], b: &[T; D]) -> T {
    (0..D).fold(T::ZERO, |sum, axis| sum + (a[axis] - b[axis]) * (a[axis] - b[axis]))
}

/// How one scene draws its numbers: mostly from a small lattice, where touching is common and exact.
struct Numbers<T> {
    origin: T,
    step: T,
    /// Whether values may have arbitrary bits that are refused.
    wild: bool,
}

impl<T: Number> Numbers<T> {
    fn new(bytes: &mut Unstructured<'_>) -> Result<Self> {
        let special = |bytes: &mut Unstructured<'_>, usual: T| {
            if bytes.ratio(3, 4)? { Ok(usual) } else { tame(T::any_bits(bytes)?, usual) }
        };
        let origin = special(bytes, T::ZERO)?;
        let step = special(bytes, T::HALF)?;
        Ok(Self { origin, step, wild: bytes.ratio(1, 8)? })
    }

    fn coordinate(&self, bytes: &mut Unstructured<'_>) -> Result<T> {
        let choice = bytes.arbitrary::<u8>()?;
        if choice < 240 {
            return Ok(self.origin + self.step * T::small((choice % 24) as i8 - 12));
        }
        let any = T::any_bits(bytes)?;
        if self.wild { Ok(any) } else { tame(any, self.origin) }
    }

    fn point<const D: usize>(&self, bytes: &mut Unstructured<'_>) -> Result<[T; D]> {
        let mut point = [T::ZERO; D];
        for x in &mut point {
            *x = self.coordinate(bytes)?;
        }
        Ok(point)
    }

    /// A length that is small compared with the lattice, so that not all elements touch.
    fn length(&self, bytes: &mut Unstructured<'_>) -> Result<T> {
        let choice = bytes.arbitrary::<u8>()?;
        if choice < 250 {
            return Ok(self.step.magnitude() * T::HALF * T::small((choice % 4) as i8));
        }
        let any = T::any_bits(bytes)?;
        if self.wild { Ok(any) } else { tame(any.magnitude(), T::ZERO) }
    }

    fn lengths<const D: usize>(&self, bytes: &mut Unstructured<'_>) -> Result<[T; D]> {
        let mut lengths = [T::ZERO; D];
        for x in &mut lengths {
            *x = self.length(bytes)?;
        }
        Ok(lengths)
    }
}

/// `value`, or `otherwise` if [`Elements`] would refuse it.
fn tame<T: Number>(value: T, otherwise: T) -> Result<T> {
    // NaN compares with nothing.
    Ok(if value.magnitude() <= T::MAX_MAGNITUDE { value } else { otherwise })
}

/// A property that every scene must have.
pub trait Law {
    /// Panics if `elements` violate the property.
    fn check<T: Number, const D: usize>(elements: &Elements<'_, T, D>);
}

/// Checks `L` with the elements made from `bytes`, in 2D or 3D, `f32` or `f64`. Elements that are refused
/// pass.
pub fn check<L: Law>(bytes: &[u8]) {
    let bytes = &mut Unstructured::new(bytes);
    let Ok(kind) = bytes.int_in_range(0..=3) else { return };
    match kind {
        0 => check_as::<L, f32, 2>(bytes),
        1 => check_as::<L, f32, 3>(bytes),
        2 => check_as::<L, f64, 2>(bytes),
        _ => check_as::<L, f64, 3>(bytes),
    }
}

fn check_as<L: Law, T: Number, const D: usize>(bytes: &mut Unstructured<'_>) {
    let Ok(scene) = Scene::<T, D>::new(bytes) else { return };
    if let Ok(elements) = scene.elements() {
        L::check(&elements);
    }
}

/// A property that every pair of scenes must have.
pub trait PairLaw {
    /// Panics if a pair violates the property; its elements may be invalid.
    fn check<T: Number, const D: usize>(pair: &Pair<T, D>);
}

/// Checks `L` with the pair of scenes made from `bytes`, in 2D or 3D, `f32` or `f64`.
pub fn check_pair<L: PairLaw>(bytes: &[u8]) {
    fn check_as<L: PairLaw, T: Number, const D: usize>(bytes: &mut Unstructured<'_>) {
        if let Ok(pair) = Pair::<T, D>::new(bytes) {
            L::check(&pair);
        }
    }
    let bytes = &mut Unstructured::new(bytes);
    let Ok(kind) = bytes.int_in_range(0..=3) else { return };
    match kind {
        0 => check_as::<L, f32, 2>(bytes),
        1 => check_as::<L, f32, 3>(bytes),
        2 => check_as::<L, f64, 2>(bytes),
        _ => check_as::<L, f64, 3>(bytes),
    }
}

/// The couples by brute force, in ascending order.
pub fn expected<T: Real, const D: usize>(elements: &Elements<'_, T, D>) -> Vec<Couple> {
    let mut couples = Vec::new();
    Direct.couples(elements, &mut couples).expect("the oracle holds any number of elements");
    couples.sort_unstable();
    couples
}

/// The same couples in ascending order.
pub fn ascending(couples: &[Couple]) -> Vec<Couple> {
    let mut couples = couples.to_vec();
    couples.sort_unstable();
    couples
}
