//! From source to kernels for the device at hand.

use std::cell::{OnceCell, RefCell};
use std::time::Instant;

use super::cache::{self, Kernels};
use super::device::Device;
use super::nvrtc::Nvrtc;

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

    /// Kernels of a source.
    pub fn kernels(&self, source: &str) -> Result<Kernels, String> {
        let clock = Instant::now();
        let (folder, architecture) = (cache::folder(), self.device.architecture());
        let kernels = cache::kernels(folder.as_deref(), source, &architecture, self.nvrtc())?;
        let seconds = clock.elapsed().as_secs_f64();
        let version = self.nvrtc().as_ref().map_or("?".into(), Nvrtc::version_text);
        let note = match kernels.cached {
            true => format!("Kernels: from the cache in {seconds:.3} s"),
            false => format!("Kernels: compiled in {seconds:.2} s (NVRTC {version}, {architecture})"),
        };
        self.notes.borrow_mut().push(note);
        Ok(kernels)
    }

    /// What was compiled since the last call.
    pub fn take_notes(&self) -> Vec<String> {
        self.notes.take()
    }
}
