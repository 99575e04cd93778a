//! The kernels of a shape, loaded.

use super::compiler::Compiler;
use super::device::{Kernel, Module};
use super::layout::BLOCK;
use super::shape::Shape;
use super::source::source;
use crate::engine::Program;

/// Compiled kernels of a shape.
pub struct Compiled {
    pub shape: Shape,
    _module: Module,
    pub advance: Kernel,
    pub kinetic: Kernel,
    pub ptx: String,
    /// Blocks of a launch.
    pub blocks: u32,
}

/// Kernels for a program of that shape and so many particles.
pub fn compile(compiler: &Compiler, program: &Program, shape: &Shape, n: usize) -> Result<Compiled, String> {
    let kernels = compiler.kernels(&source(program, shape))?;
    let module = Module::load(&kernels.cubin)?;
    let advance = module.kernel("advance", BLOCK)?;
    let kinetic = module.kernel("kinetic", BLOCK)?;
    let processors = compiler.device.multiprocessors;
    let resident = processors * advance.resident.min(kinetic.resident).max(1);
    let useful = (n as u64 * u64::from(shape.lanes)).div_ceil(BLOCK.into());
    let blocks = useful.clamp(processors.into(), resident.into()) as u32;
    Ok(Compiled { shape: shape.clone(), _module: module, advance, kinetic, ptx: kernels.ptx, blocks })
}
