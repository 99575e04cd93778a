//! Kernels of a scene as text and machine code, without a GPU: for tests, and for what is told of a run.

use super::cache::options;
use super::nvrtc::{Compiled, Nvrtc};
use super::plan::{Given, Plan, Tuning};
pub use super::source::Unit;
use super::source::units;
use crate::Error;
use crate::engine::{Precision, Program};
use crate::system::{SimulationBox, State};

/// A scene's kernels.
pub struct Inspected {
    /// CUDA C.
    pub source: String,
    /// Intermediate code.
    pub ptx: String,
    /// Machine code.
    pub cubin: Vec<u8>,
}

/// Comments in the intermediate code around the loop over a particle's row.
pub const PAIR_LOOP: (&str, &str) = ("// pair loop", "// end of pair loop");

/// Text of the kernels that a scene runs, in the parts that are compiled by themselves.
pub fn units_of(program: &Program, state: &State, simulation_box: &SimulationBox, precision: Precision) -> Vec<Unit> {
    let (bounds, n, tuning) = (state.bounds(), state.len(), Tuning::default());
    let plan = Plan::new(&Given { program, simulation_box, bounds, n, precision, double_pairs: false, tuning });
    units(program, &plan.shape)
}

/// Compiles kernels for an architecture such as "sm_90"; needs NVRTC, but no GPU.
pub fn inspect(source: String, architecture: &str) -> Result<Inspected, Error> {
    let compiled = Nvrtc::load().and_then(|nvrtc| nvrtc.compile(&source, &options(architecture)));
    let Compiled { cubin, ptx } = compiled.map_err(Error::Unavailable)?;
    Ok(Inspected { source, ptx, cubin })
}

/// Whether NVRTC is there; the error says how to get it.
pub fn compiler() -> Result<String, String> {
    Nvrtc::load().map(|nvrtc| nvrtc.version_text())
}

/// Arithmetic instructions on f64 in some intermediate code: conversions, comparisons, additions and so on.
pub fn double_instructions(ptx: &str) -> usize {
    let moves = ["ld.", "st.", "mov.", "selp.", "shfl.", "cvta"];
    let is_double = |line: &str| {
        let line = line.trim_start();
        let line = line.strip_prefix('@').and_then(|l| l.split_once(' ')).map_or(line, |(_, rest)| rest.trim_start());
        let opcode = line.split_whitespace().next().unwrap_or("");
        opcode.contains(".f64") && !moves.iter().any(|m| opcode.starts_with(m))
    };
    ptx.lines().filter(|line| is_double(line)).count()
}

/// The parts of some intermediate code between the comments of [`PAIR_LOOP`].
pub fn pair_loops(ptx: &str) -> Vec<String> {
    let mut loops = Vec::new();
    let mut inside: Option<String> = None;
    for line in ptx.lines() {
        match line.trim() {
            text if text == PAIR_LOOP.0 => inside = Some(String::new()),
            text if text == PAIR_LOOP.1 => loops.extend(inside.take()),
            _ => {
                if let Some(text) = &mut inside {
                    text.push_str(line);
                    text.push('\n');
                }
            }
        }
    }
    loops
}
