//! Kernels of a scene as text and machine code, without a GPU: for tests.

use super::arrays::arrays;
use super::cache::options;
use super::layout::{Order, Scene};
use super::nvrtc::{Compiled, Nvrtc};
use super::plan::{Given, Plan, Tuning};
pub use super::source::Unit;
use super::source::{recording_unit, units};
use crate::Error;
use crate::engine::{Precision, Program};
use crate::system::{SimulationBox, State};

/// A scene's kernels.
pub struct Inspected {
    /// Intermediate code.
    pub ptx: String,
    /// Machine code.
    pub cubin: Vec<u8>,
}

/// Text of the kernels that a scene runs, in the parts that are compiled by themselves.
pub fn units_of(program: &Program, state: &State, simulation_box: &SimulationBox, precision: Precision) -> Vec<Unit> {
    units(program, &plan_of(program, state, simulation_box, precision).shape)
}

/// Those that a run with many outputs has besides; of the virial they record the trace, or all of it.
pub fn recording_unit_of(
    program: &Program,
    state: &State,
    simulation_box: &SimulationBox,
    precision: Precision,
    tensor: bool,
) -> Unit {
    recording_unit(program, &plan_of(program, state, simulation_box, precision).shape, tensor)
}

/// Names of a scene's entry points, and bytes of each argument that the host launches them with.
pub fn arguments_of(
    program: &Program,
    state: &State,
    simulation_box: &SimulationBox,
    precision: Precision,
) -> Vec<(String, Vec<usize>)> {
    let shape = plan_of(program, state, simulation_box, precision).shape;
    let bytes = vec![arrays(&shape).len() * size_of::<u64>(), size_of::<Scene>(), size_of::<Order>()];
    let units = units(program, &shape).into_iter().chain([recording_unit(program, &shape, true)]);
    units.flat_map(|unit| unit.kernels).map(|kernel| (kernel.to_string(), bytes.clone())).collect()
}

fn plan_of(program: &Program, state: &State, simulation_box: &SimulationBox, precision: Precision) -> Plan {
    let (bounds, n, tuning) = (state.bounds(), state.len(), Tuning::default());
    // No device is asked for: the choices are those of the architecture that has been tuned.
    let architecture = "sm_90";
    Plan::new(&Given {
        program,
        simulation_box,
        bounds,
        n,
        precision,
        double_pairs: false,
        long_runs: false,
        tuning,
        architecture,
    })
}

/// Compiles kernels for an architecture such as "sm_90", or to intermediate code alone for one such as "compute_90"; needs NVRTC,
/// but no GPU.
pub fn inspect(source: &str, architecture: &str) -> Result<Inspected, Error> {
    let compiled = Nvrtc::load().and_then(|nvrtc| nvrtc.compile(source, &options(architecture)));
    let Compiled { cubin, ptx } = compiled.map_err(Error::Unavailable)?;
    Ok(Inspected { ptx, cubin })
}

/// Whether NVRTC is there; the error says how to get it.
pub fn compiler() -> Result<String, String> {
    Nvrtc::load().map(|nvrtc| nvrtc.version_text())
}
