//! From source to kernels for the device at hand.

use std::cell::{OnceCell, RefCell};
use std::time::Instant;

use super::cache::{self, Kernels};
use super::device::Device;
use super::nvrtc::Nvrtc;
use super::source::Unit;

/// A device and the compiler for it, which is loaded when it is first needed.
pub struct Compiler {
    pub device: Device,
    nvrtc: OnceCell<Result<Nvrtc, String>>,
    /// What was compiled, for the log.
    notes: RefCell<Vec<String>>,
}

impl Compiler {
    pub fn new(device: Device) -> Self {
        Self { device, nvrtc: OnceCell::new(), notes: RefCell::default() }
    }

    /// The compiler, or what is missing.
    pub fn nvrtc(&self) -> &Result<Nvrtc, String> {
        self.nvrtc.get_or_init(Nvrtc::load)
    }

    /// Kernels of all units, which are compiled side by side.
    pub fn kernels(&self, units: &[Unit]) -> Result<Vec<Kernels>, String> {
        let clock = Instant::now();
        let (folder, architecture, nvrtc) = (cache::folder(), self.device.architecture(), self.nvrtc());
        let (folder, target) = (folder.as_deref(), architecture.as_str());
        let all = std::thread::scope(|scope| {
            let one = |unit| scope.spawn(move || cache::kernels(folder, unit, target, nvrtc));
            let threads: Vec<_> = units.iter().map(|unit| one(&unit.text)).collect();
            threads.into_iter().map(|t| t.join().expect("the compiler does not panic")).collect::<Result<Vec<_>, _>>()
        })?;
        let seconds = clock.elapsed().as_secs_f64();
        let version = self.nvrtc().as_ref().map_or("?".into(), Nvrtc::version_text);
        let note = match all.iter().all(|kernels| kernels.cached) {
            true => format!("Kernels: from the cache in {seconds:.3} s"),
            false => format!("Kernels: compiled in {seconds:.2} s (NVRTC {version}, {architecture})"),
        };
        self.notes.borrow_mut().push(note);
        Ok(all)
    }

    /// What was compiled since the last call.
    pub fn take_notes(&self) -> Vec<String> {
        self.notes.take()
    }
}
