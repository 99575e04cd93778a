//! From source to kernels for the device at hand.

use std::cell::{Cell, OnceCell, RefCell};
use std::thread::JoinHandle;
use std::time::Instant;

use super::cache::{self, Kernels};
use super::device::Device;
use super::nvrtc::Nvrtc;
use super::source::Unit;

/// NVRTC on its way from the disk, of which it reads a hundred megabytes.
pub struct Loading(JoinHandle<Result<Nvrtc, String>>);

impl Loading {
    /// Begins to load it on a thread of its own, while the driver wakes the GPU.
    pub fn begin() -> Self {
        Self(std::thread::spawn(|| {
            let nvrtc = Nvrtc::load()?;
            // Where nothing has been compiled yet, something small draws in what the first kernels will wait for.
            if cache::is_unused() {
                let _ = nvrtc.compile("extern \"C\" __global__ void nothing() {}", &cache::options("sm_75"));
            }
            Ok(nvrtc)
        }))
    }
}

/// A device and the compiler for it.
pub struct Compiler {
    pub device: Device,
    loading: Cell<Option<Loading>>,
    nvrtc: OnceCell<Result<Nvrtc, String>>,
    /// What was compiled, for the log.
    notes: RefCell<Vec<String>>,
}

impl Compiler {
    pub fn new(device: Device, loading: Loading) -> Self {
        Self { device, loading: Cell::new(Some(loading)), nvrtc: OnceCell::new(), notes: RefCell::default() }
    }

    /// The compiler, or what is missing.
    pub fn nvrtc(&self) -> &Result<Nvrtc, String> {
        let loaded = |Loading(thread)| thread.join().expect("loading does not panic");
        self.nvrtc.get_or_init(|| self.loading.take().map_or_else(Nvrtc::load, loaded))
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
