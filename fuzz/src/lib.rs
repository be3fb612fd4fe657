//! What the fuzz targets share: elements out of arbitrary bytes.

use arbitrary::{Result, Unstructured};
use fdem_contact::{Couple, Direct, Elements, Error, Filter, GroupMatrix, Real, Search};

/// A float type with bits.
pub trait Number: Real {
    /// Any value of the type: NaN, infinite and subnormal ones too.
    fn any_bits(bytes: &mut Unstructured<'_>) -> Result<Self>;

    /// A small whole number.
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

/// The largest set: all-against-all must stay quick, and rows longer than a few vectors must occur.
const MOST_ELEMENTS: usize = 300;

/// What the elements are.
#[derive(Debug)]
enum Shape<T, const D: usize> {
    Points(T),
    Spheres(T),
    Radii(Box<[T]>),
    Boxes(Box<[[T; D]]>),
}

/// Which elements see each other.
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
    /// Made of one byte for each element; the kind is one of them all.
    fn new(kind: u8, of_each: &[u8]) -> Self {
        let numbers = |number: fn(u32) -> u32| of_each.iter().map(|&byte| number(byte.into())).collect();
        // A matrix of 32 groups becomes masks inside, one of 70 does not.
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
}

/// A set of elements, valid or not, in arrays that are exactly as long as it: the sanitizer sees a read behind them.
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
        let shape = bytes.int_in_range(0..=3)?;
        let tolerance = if bytes.ratio(1, 2)? { T::ZERO } else { numbers.length(bytes)? };
        let size = numbers.length(bytes)?;
        let filter = bytes.int_in_range(0..=11)?;
        let (mut points, mut radii, mut corners) = (Vec::new(), Vec::new(), Vec::new());
        let mut labels = Vec::new();
        while !bytes.is_empty() && points.len() < MOST_ELEMENTS {
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
    /// Those of [`Elements`].
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

/// How one scene draws its numbers: mostly from a small lattice, where touching is common and exact.
struct Numbers<T> {
    origin: T,
    step: T,
    /// Values with arbitrary bits may be ones that are refused.
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

    /// Small beside the lattice, so that not all touch all.
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

/// `value` unless it is one that [`Elements`] refuses.
fn tame<T: Number>(value: T, otherwise: T) -> Result<T> {
    // NaN compares with nothing.
    Ok(if value.magnitude() <= T::MAX_MAGNITUDE { value } else { otherwise })
}

/// What is required of every scene.
pub trait Law {
    /// Panics if `elements` break the law.
    fn check<T: Number, const D: usize>(elements: &Elements<'_, T, D>);
}

/// Checks `L` with the elements that `bytes` stand for, in 2D or 3D, `f32` or `f64`; those that are refused pass.
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

/// The couples of the oracle, in ascending order.
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
