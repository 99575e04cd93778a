//! The kernels of a shape, loaded.

use std::ffi::c_void;

use super::compiler::Compiler;
use super::device::{Kernel, Module};
use super::layout::{BLOCK, LIST_BLOCK, MOST_RECORDS};
use super::shape::Shape;
use super::source::{recording_unit, units};
use crate::engine::Program;

/// Compiled kernels of a shape.
pub struct Compiled {
    pub shape: Shape,
    _modules: Vec<Module>,
    pub advance: Launch,
    pub sort: Launch,
    pub list: Launch,
    pub conclude: Launch,
    /// Once a run has asked for it.
    pub recording: Option<Recording>,
    /// Intermediate code.
    pub ptx: String,
}

/// Kernels that record sums of steps as they pass.
pub struct Recording {
    _module: Module,
    /// They record the whole virial.
    pub tensor: bool,
    /// Takes the place of the other `advance`.
    pub advance: Launch,
    pub sum: Launch,
}

/// A kernel and the blocks that it is launched with.
pub struct Launch {
    pub kernel: Kernel,
    pub blocks: u32,
    /// Threads of a block.
    threads: u32,
}

impl Compiled {
    /// Blocks of the largest launch.
    pub fn blocks(&self) -> u32 {
        self.launches().map(|(_, launch)| launch.blocks).into_iter().max().unwrap_or(1)
    }

    /// All launches by the names of their kernels.
    pub fn launches(&self) -> [(&'static str, &Launch); 4] {
        let Self { advance, sort, list, conclude, .. } = self;
        [("advance", advance), ("sort", sort), ("list", list), ("conclude", conclude)]
    }

    /// No launch has more blocks from here on.
    pub fn limit(&mut self, blocks: u32) {
        let all = [&mut self.advance, &mut self.sort, &mut self.list, &mut self.conclude];
        all.into_iter().for_each(|launch| launch.blocks = launch.blocks.min(blocks));
    }
}

impl Launch {
    /// Launches it after what was launched before.
    pub fn go(&self, parameters: &[*const c_void]) -> Result<(), String> {
        self.kernel.launch(self.blocks, self.threads, parameters)
    }
}

/// Kernels for a program of that shape and so many particles.
pub fn compile(compiler: &Compiler, program: &Program, shape: &Shape, n: usize) -> Result<Compiled, String> {
    let units = units(program, shape);
    let compiled = compiler.kernels(&units)?;
    let modules = compiled.iter().map(|kernels| Module::load(&kernels.cubin)).collect::<Result<Vec<_>, _>>()?;
    let processors = compiler.device.multiprocessors;
    let find = |name: &str, block: u32, threads: u64| -> Result<Launch, String> {
        let at = units.iter().position(|unit| unit.kernels.contains(&name)).expect("the kernel is one of the scene's");
        let kernel = modules[at].kernel(name, block)?;
        let resident = processors * kernel.resident.max(1);
        let useful = (n as u64 * threads).div_ceil(block.into());
        let blocks = useful.clamp(processors.into(), resident.into()) as u32;
        Ok(Launch { kernel, blocks, threads: block })
    };
    let lanes = u64::from(shape.lanes);
    let mut advance = find("advance", BLOCK, lanes)?;
    let mut conclude = find("conclude", BLOCK, lanes)?;
    // As many as fit in any case, and not more where there happens to be room: sums do not show which kernel added them up.
    conclude.blocks = conclude.blocks.min(processors * shape.blocks_at_least);
    if shape.thermostats > 0 {
        // Either adds up kinetic energies of groups.
        let blocks = advance.blocks.min(conclude.blocks);
        (advance.blocks, conclude.blocks) = (blocks, blocks);
    }
    Ok(Compiled {
        advance,
        sort: find("sort", BLOCK, 1)?,
        list: find("list", LIST_BLOCK, 32)?,
        conclude,
        recording: None,
        shape: shape.clone(),
        _modules: modules,
        ptx: compiled.into_iter().map(|kernels| kernels.ptx).collect(),
    })
}

/// Kernels that record, the whole virial or its trace, beside those of the same scene: with as many blocks as `conclude`, whose sums theirs are to equal.
pub fn compile_recording(
    compiler: &Compiler,
    program: &Program,
    beside: &Compiled,
    tensor: bool,
) -> Result<Recording, String> {
    let unit = recording_unit(program, &beside.shape, tensor);
    let compiled = compiler.kernels(std::slice::from_ref(&unit))?;
    let module = Module::load(&compiled[0].cubin)?;
    let processors = compiler.device.multiprocessors;
    let find = |name: &str, blocks: u32| -> Result<Launch, String> {
        let kernel = module.kernel(name, BLOCK)?;
        let blocks = blocks.min(processors * kernel.resident.max(1));
        Ok(Launch { kernel, blocks, threads: BLOCK })
    };
    let advance = find("advance_recording", beside.conclude.blocks)?;
    let sum = find("sum_records", MOST_RECORDS)?;
    Ok(Recording { _module: module, tensor, advance, sum })
}
