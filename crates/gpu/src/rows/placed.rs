//! A search over elements that are on the device already.

use bytemuck::{Pod, Zeroable};
use fdem_contact::{Couple, Elements, Error, Real, Rows, RowsExtremes, RowsInput};

use crate::array::Array;
use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{Extremes, ExtremesArguments, Kernel, SCANNED, SampleArguments, THREADS};
use crate::primitives::{launch, launch_blocks};
use crate::rows::{DeviceRows, check_dimensions};
use crate::sorted::{Places, SortedRows};

/// Spheres whose numbers are on a device, as another library or a kernel has left them.
///
/// # Shapes
/// `points`: `count` points of as many numbers as there are dimensions, one after the other; radii: `count`
/// numbers. Memory may be longer.
#[derive(Debug)]
pub struct PlacedElements<'m, M, T> {
    /// Number of elements.
    pub count: usize,
    /// The centres.
    pub points: &'m M,
    /// The radii.
    pub radii: PlacedRadii<'m, M, T>,
    /// The gap that still counts as contact.
    pub tolerance: T,
}

/// The radii of elements on a device.
#[derive(Debug)]
pub enum PlacedRadii<'m, M, T> {
    /// One for all: half of the cut-off of points.
    One(T),
    /// One each.
    Each(&'m M),
}

/// A list of couples on a device.
pub struct PlacedCouples<'s, D: Device> {
    device: &'s D,
    list: &'s Array<D::Memory, [u32; 2]>,
    count: usize,
}

impl<'s, D: Device> PlacedCouples<'s, D> {
    /// Number of couples.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The memory that begins with them: two numbers of 32 bits each, the smaller one first. `None` if there
    /// were never any.
    pub fn memory(&self) -> Option<&'s D::Memory> {
        self.list.memory()
    }

    /// Copies them from the device.
    ///
    /// # Errors
    /// [`Error::Device`] with the words of [`GpuError::OutOfMemory`] or [`GpuError::Driver`].
    pub fn read(&self) -> Result<Vec<Couple>, Error> {
        let list = self.list.to_vec(self.device, self.count)?;
        Ok(list.into_iter().map(|[i, j]| Couple { i, j }).collect())
    }
}

impl<D: Device, T: Real + Pod, const N: usize> DeviceRows<'_, D, T, N> {
    /// The couples of elements that are on the device, which stay there until the next search: those of
    /// [`Rows`], in its order. Nothing is copied to the host but extremes, counts, and at most 4096 points.
    ///
    /// # Errors
    /// The errors of [`Elements`], which name the first number that is refused. [`Error::Device`] with the
    /// words of [`GpuError::ShortMemory`], and of the errors of a search.
    pub fn find_placed(
        &mut self,
        elements: &PlacedElements<'_, D::Memory, T>,
    ) -> Result<PlacedCouples<'_, D>, Error> {
        check_dimensions(N)?;
        let mut count = 0;
        if elements.count > 0 {
            let mut places = self.places(elements)?;
            let input = self.input_of(elements, &mut places)?;
            count = self.listed(places, &input)?;
        }
        Ok(PlacedCouples { device: self.device, list: &self.couples, count })
    }

    /// The memory that begins with the couples of the last search, and is freed when it is dropped; `None` if
    /// there were never any. All other memory of the search is freed now.
    pub fn into_couples(self) -> Option<D::Memory> {
        self.couples.into_memory()
    }

    /// Where the elements are; memory that is too short is refused.
    fn places(&self, elements: &PlacedElements<'_, D::Memory, T>) -> Result<Places, GpuError> {
        let device = self.device;
        let address = |what, memory, numbers: Option<usize>| {
            let needed =
                numbers.and_then(|numbers| numbers.checked_mul(size_of::<T>())).unwrap_or(usize::MAX);
            let bytes = device.bytes(memory);
            if bytes < needed {
                Err(GpuError::ShortMemory { what, bytes, needed })
            } else {
                Ok(device.address(memory))
            }
        };
        let count = elements.count;
        let points = address("points", elements.points, count.checked_mul(N))?;
        let radii = match elements.radii {
            PlacedRadii::One(_) => 0,
            PlacedRadii::Each(radii) => address("radii", radii, Some(count))?,
        };
        Ok(Places { points, radii, count })
    }

    /// The input of a search. Radii that are all equal are taken out of `places`.
    fn input_of(
        &mut self,
        elements: &PlacedElements<'_, D::Memory, T>,
        places: &mut Places,
    ) -> Result<RowsInput<'static, T, N>, Error> {
        let extremes = self.extremes(*places)?;
        let radius = match elements.radii {
            PlacedRadii::One(radius) => {
                Elements::<T, N>::spheres(&[], radius)?;
                radius
            }
            PlacedRadii::Each(radii) => {
                if extremes.wrong_radius != u64::MAX {
                    let index = extremes.wrong_radius as usize;
                    let value = self.number(radii, index)?.to_f64();
                    let limit = T::MAX_MAGNITUDE.to_f64();
                    return Err(Error::InvalidRadius { index: Some(index), value, limit });
                }
                T::nearest(extremes.radii[1])
            }
        };
        if extremes.wrong_number != u64::MAX {
            let place = extremes.wrong_number as usize;
            let (index, axis, limit) = (place / N, place % N, T::MAX_MAGNITUDE.to_f64());
            let value = self.number(elements.points, place)?;
            let (is_finite, value) = (value.is_finite(), value.to_f64());
            return Err(if is_finite {
                Error::CoordinateTooLarge { index, axis, value, limit }
            } else {
                Error::NonFiniteCoordinate { index, axis, value }
            });
        }
        if extremes.radii[0] == extremes.radii[1] {
            places.radii = 0;
        }
        let corner = |x: &[f64; 3]| std::array::from_fn(|axis| T::nearest(x[axis]));
        let extremes = RowsExtremes {
            elements: places.count,
            min: corner(&extremes.min),
            max: corner(&extremes.max),
            radius,
            tolerance: elements.tolerance,
        };
        Rows::input_elsewhere(&extremes, &self.sample(*places)?)
    }

    /// The extremes of the elements.
    fn extremes(&mut self, places: Places) -> Result<Extremes, GpuError> {
        let device = self.device;
        let blocks = places.count.div_ceil(THREADS * SCANNED);
        let arguments = ExtremesArguments {
            points: places.points,
            radii: places.radii,
            extremes: self.extremes.resize(device, blocks + 1)?,
            count: places.count as u64,
            blocks: blocks as u64,
            limit: T::MAX_MAGNITUDE.to_f64(),
            dimensions: N as u32,
            single: SortedRows::<D::Memory, T, N>::SINGLE,
        };
        launch_blocks(device, Kernel::ExtremesOfBlocks, blocks, &arguments)?;
        launch_blocks(device, Kernel::ExtremesOfAll, 1, &arguments)?;
        let mut extremes = [Extremes::zeroed()];
        self.extremes.read(device, blocks, &mut extremes)?;
        let [extremes] = extremes;
        Ok(extremes)
    }

    /// The sample by which the width of cells is chosen.
    fn sample(&mut self, places: Places) -> Result<Vec<[T; N]>, GpuError> {
        let (device, [count, step]) = (self.device, Rows::<T, N>::sample(places.count));
        if count == 0 {
            return Ok(Vec::new());
        }
        let arguments = SampleArguments {
            points: places.points,
            sample: self.sample.resize(device, N * count)?,
            count: count as u64,
            step: step as u64,
            dimensions: N as u32,
            single: SortedRows::<D::Memory, T, N>::SINGLE,
        };
        launch(device, Kernel::SamplePoints, N * count, &arguments)?;
        Ok(self.sample.to_vec(device, N * count)?.as_chunks().0.to_vec())
    }

    /// A number of an array on the device.
    fn number(&self, memory: &D::Memory, place: usize) -> Result<T, GpuError> {
        let mut number = [T::zeroed()];
        self.device.read(memory, place * size_of::<T>(), bytemuck::cast_slice_mut(&mut number))?;
        let [number] = number;
        Ok(number)
    }
}
