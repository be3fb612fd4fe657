//! Some rows of arrays on a device: rows that the host reads or changes, and arrays that grow.

use bytemuck::{Pod, cast_slice, cast_slice_mut};

use crate::array::Array;
use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{Address, Kernel, MovedRowArguments};
use crate::primitives::launch;

/// The columns of an array: a number of some type for each row in each column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Columns {
    pub(crate) columns: usize,
    /// Numbers from the beginning of a column to that of the next.
    pub(crate) stride: usize,
}

impl Columns {
    /// One column.
    pub(crate) const ONE: Self = Self { columns: 1, stride: 0 };
}

/// Lists of rows, and their values on the way from or to the host.
pub(crate) struct Rows<M> {
    numbers: Array<M, u32>,
    values: Array<M, u32>,
    count: usize,
}

impl<M> Rows<M> {
    pub(crate) const fn new() -> Self {
        Self { numbers: Array::new(), values: Array::new(), count: 0 }
    }

    /// Chooses the rows for the next calls.
    pub(crate) fn choose(&mut self, device: &impl Device<Memory = M>, rows: &[u32]) -> Result<(), GpuError> {
        self.count = rows.len();
        self.numbers.write(device, rows)?;
        Ok(())
    }

    /// Reads the chosen rows of an array, `W` numbers in each column: all rows of a column after each other.
    pub(crate) fn read<T: Pod>(
        &mut self,
        device: &impl Device<Memory = M>,
        from: &Array<M, T>,
        of: Columns,
        values: &mut [T],
    ) -> Result<(), GpuError> {
        if values.is_empty() {
            return Ok(());
        }
        let words = size_of_val(values) / size_of::<u32>();
        let arguments = MovedRowArguments {
            from: from.address(device),
            to: self.values.resize(device, words)?,
            from_rows: self.numbers.address(device),
            to_rows: 0,
            from_stride: of.stride as u64,
            to_stride: self.count as u64,
            rows: self.count as u64,
            columns: of.columns as u64,
            words: (words / self.count / of.columns) as u64,
        };
        launch(device, Kernel::MoveRows, words, &arguments)?;
        self.values.read(device, 0, cast_slice_mut(values))
    }

    /// Writes the chosen rows of an array, in the order of [`Rows::read`].
    pub(crate) fn write<T: Pod>(
        &mut self,
        device: &impl Device<Memory = M>,
        to: &Array<M, T>,
        of: Columns,
        values: &[T],
    ) -> Result<(), GpuError> {
        if values.is_empty() {
            return Ok(());
        }
        let words = cast_slice::<T, u32>(values);
        let arguments = MovedRowArguments {
            from: self.values.write(device, words)?,
            to: to.address(device),
            from_rows: 0,
            to_rows: self.numbers.address(device),
            from_stride: self.count as u64,
            to_stride: of.stride as u64,
            rows: self.count as u64,
            columns: of.columns as u64,
            words: (words.len() / self.count / of.columns) as u64,
        };
        launch(device, Kernel::MoveRows, words.len(), &arguments)
    }
}

/// Makes room for more numbers of an array. Those that are there stay.
pub(crate) fn grow<V: Device, T: Pod>(
    device: &V,
    array: &mut Array<V::Memory, T>,
    count: usize,
) -> Result<(), GpuError> {
    let Some((former, room)) = array.extend(device, count)? else { return Ok(()) };
    move_all::<V, T>(device, [device.address(&former), array.address(device)], [Columns::ONE; 2], room)
}

/// Gives the columns of an array another stride. `rows`: number of rows that stay in each column.
pub(crate) fn stretch<V: Device, T: Pod>(
    device: &V,
    array: &mut Array<V::Memory, T>,
    [before, now]: [Columns; 2],
    rows: usize,
) -> Result<(), GpuError> {
    let mut stretched = Array::new();
    let to = stretched.resize(device, now.columns * now.stride)?;
    move_all::<V, T>(device, [array.address(device), to], [before, now], rows)?;
    *array = stretched;
    Ok(())
}

/// Copies the first rows of an array.
fn move_all<V: Device, T: Pod>(
    device: &V,
    [from, to]: [Address; 2],
    [before, now]: [Columns; 2],
    rows: usize,
) -> Result<(), GpuError> {
    let words = size_of::<T>() / size_of::<u32>();
    let arguments = MovedRowArguments {
        from,
        to,
        from_rows: 0,
        to_rows: 0,
        from_stride: before.stride as u64,
        to_stride: now.stride as u64,
        rows: rows as u64,
        columns: before.columns as u64,
        words: words as u64,
    };
    launch(device, Kernel::MoveRows, rows * before.columns * words, &arguments)
}
