//! The arrays of a scene on the device.

use std::collections::BTreeMap;

use super::arrays::{Array, Count, arrays};
use super::device::{Buffer, Device};
use super::layout::{Control, MOST_LOST, RUNS};
use super::shape::Shape;
use crate::neighbor::OCTANTS;

/// How long arrays are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sizes {
    pub pitch: u64,
    pub buckets: u64,
    pub blocks: u64,
    /// Steps that a launch may record; 0 as long as no run asks for it.
    pub records: u64,
    /// Entries of the list.
    pub list: u64,
    pub values: Values,
}

/// Entries of a column for so many particles.
pub fn pitch(n: usize) -> u64 {
    (n as u64).next_multiple_of(32).max(32)
}

/// Lengths of the arrays of constants.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Values {
    pub visits: u64,
    pub types: u64,
    pub coefficients: u64,
    pub codes: u64,
    pub baths: u64,
}

/// All arrays, and their addresses in the order of the struct.
#[derive(Default)]
pub struct Memory {
    buffers: BTreeMap<&'static str, Buffer>,
    pub table: Vec<u64>,
}

impl Memory {
    /// Zeros everywhere; the error says what is wanted and how much would fit.
    pub fn new(device: &Device, shape: &Shape, sizes: &Sizes, n: usize) -> Result<Self, String> {
        let wanted = arrays(shape);
        let mut memory = Self::default();
        for array in &wanted {
            match Buffer::new(bytes(array, sizes) as usize)? {
                Some(buffer) => memory.buffers.insert(array.name, buffer),
                None => {
                    drop(memory);
                    return Err(out_of_memory(device, shape, sizes, n));
                }
            };
        }
        memory.point(&wanted);
        Ok(memory)
    }

    fn point(&mut self, wanted: &[Array]) {
        self.table = wanted.iter().map(|array| self.buffers[array.name].address()).collect();
    }

    /// Makes one array anew, if the scene has it; what it held is lost.
    pub fn renew(
        &mut self,
        name: &'static str,
        device: &Device,
        shape: &Shape,
        sizes: &Sizes,
        n: usize,
    ) -> Result<(), String> {
        let wanted = arrays(shape);
        let Some(array) = wanted.iter().find(|a| a.name == name) else { return Ok(()) };
        // Given back first: it may be the largest there is.
        self.buffers.remove(name);
        match Buffer::new(bytes(array, sizes) as usize)? {
            Some(buffer) => self.buffers.insert(name, buffer),
            None => return Err(out_of_memory(device, shape, sizes, n)),
        };
        self.point(&wanted);
        Ok(())
    }

    pub fn get(&self, name: &str) -> &Buffer {
        self.find(name).expect("the array is one of the scene's")
    }

    /// An array that not every scene has.
    pub fn find(&self, name: &str) -> Option<&Buffer> {
        self.buffers.get(name)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.buffers.values().map(Buffer::bytes).sum()
    }
}

fn bytes(array: &Array, sizes: &Sizes) -> u64 {
    let count = match (array.count, array.name) {
        (Count::Columns(columns), _) => columns as u64 * sizes.pitch,
        (Count::Buckets, _) => sizes.buckets + 1,
        (Count::Runs, _) => sizes.buckets * u64::from(RUNS),
        (Count::Blocks(each), _) => each as u64 * sizes.blocks,
        (Count::Records(each), _) => each as u64 * sizes.records,
        (Count::RecordBlocks(each), _) => each as u64 * sizes.records * sizes.blocks,
        (Count::List, _) => sizes.list,
        (Count::Values, "control") => return size_of::<Control>() as u64,
        (Count::Values, "visits") => sizes.values.visits,
        (Count::Values, "visit_starts") => (OCTANTS * OCTANTS) as u64 + 1,
        (Count::Values, "limits") => sizes.values.types.pow(2),
        (Count::Values, "coefficients") => sizes.values.coefficients,
        (Count::Values, "masses" | "half_kicks") => sizes.values.types,
        (Count::Values, "losses") => 3 * u64::from(MOST_LOST),
        (Count::Values, "baths") => sizes.values.baths,
        (Count::Values, _) => sizes.values.codes,
    };
    count * array.entry.1 as u64
}

/// Bytes of all arrays.
pub fn wanted_bytes(shape: &Shape, sizes: &Sizes) -> u64 {
    arrays(shape).iter().map(|array| bytes(array, sizes)).sum()
}

fn out_of_memory(device: &Device, shape: &Shape, sizes: &Sizes, n: usize) -> String {
    let wanted = wanted_bytes(shape, sizes);
    let (free, all) = device.memory();
    let each = wanted as f64 / n.max(1) as f64;
    format!(
        "out of GPU memory: {n} atoms want {wanted} bytes ({each:.0} an atom); {} has {free} of {all} bytes free, enough for \
         about {} atoms of this density",
        device.name,
        (free as f64 / each) as u64
    )
}
