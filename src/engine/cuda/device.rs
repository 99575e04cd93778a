//! The GPU: whether there is one, memory on it, kernels and their launches.
#![allow(unsafe_code)]

use std::ffi::{CString, c_void};
use std::sync::Arc;

use cudarc::driver::sys::{self, CUdevice_attribute, CUfunction_attribute};
use cudarc::driver::{CudaContext, DriverError, result};

/// Oldest CUDA version of a driver, and oldest compute capability.
const OLDEST_DRIVER: i32 = 12_040;
const OLDEST_CAPABILITY: (i32, i32) = (7, 5);

/// A GPU that can run kernels.
pub struct Device {
    context: Arc<CudaContext>,
    pub name: String,
    pub ordinal: usize,
    pub capability: (i32, i32),
    pub multiprocessors: u32,
    /// CUDA version of the driver, such as "13.0".
    pub driver: String,
}

/// What the driver says went wrong.
pub fn words(error: DriverError) -> String {
    let text =
        |r: Result<&std::ffi::CStr, DriverError>| r.map_or_else(|_| "?".into(), |t| t.to_string_lossy().into_owned());
    format!("CUDA: {} ({})", text(error.error_string()), text(error.error_name()))
}

impl Device {
    /// The GPU of that number among those that CUDA_VISIBLE_DEVICES leaves; the error says what is missing and what helps.
    pub fn open(ordinal: usize) -> Result<Self, String> {
        let count = Self::count()?;
        if ordinal >= count {
            let plural = if count == 1 { "is 1 CUDA device".into() } else { format!("are {count} CUDA devices") };
            return Err(format!(
                "--device {ordinal}: there {plural}, numbered from 0 (CUDA_VISIBLE_DEVICES may hide some)"
            ));
        }
        let context = CudaContext::new(ordinal).map_err(words)?;
        let capability = context.compute_capability().map_err(words)?;
        let name = context.name().map_err(words)?;
        if capability < OLDEST_CAPABILITY {
            return Err(format!(
                "{name} has compute capability {}.{}; octant needs {}.{} (Turing) or newer",
                capability.0, capability.1, OLDEST_CAPABILITY.0, OLDEST_CAPABILITY.1
            ));
        }
        let attribute = |a| context.attribute(a).map_err(words);
        let multiprocessors = attribute(CUdevice_attribute::CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT)? as u32;
        let version = driver_version()?;
        let driver = format!("{}.{}", version / 1000, version % 1000 / 10);
        Ok(Self { context, name, ordinal, capability, multiprocessors, driver })
    }

    /// An error where there is no driver.
    pub fn check_driver() -> Result<(), String> {
        // SAFETY: only asks the loader for a library.
        if unsafe { sys::is_culib_present() } {
            return Ok(());
        }
        Err("there is no NVIDIA driver on this machine (libcuda.so.1 was not found)".into())
    }

    /// How many GPUs there are; an error where there is none.
    pub fn count() -> Result<usize, String> {
        Self::check_driver()?;
        result::init().map_err(|e| match e.0 {
            sys::CUresult::CUDA_ERROR_NO_DEVICE => {
                "no CUDA device: the driver sees none (CUDA_VISIBLE_DEVICES may hide it)".to_string()
            }
            _ => words(e),
        })?;
        let version = driver_version()?;
        if version < OLDEST_DRIVER {
            return Err(format!(
                "the NVIDIA driver is for CUDA {}.{}; octant needs 12.4 or newer (driver 550): update the driver",
                version / 1000,
                version % 1000 / 10
            ));
        }
        match CudaContext::device_count().map_err(words)? {
            count if count > 0 => Ok(count as usize),
            _ => Err("no CUDA device: the driver sees none (CUDA_VISIBLE_DEVICES may hide it)".into()),
        }
    }

    /// "sm_90".
    pub fn architecture(&self) -> String {
        format!("sm_{}{}", self.capability.0, self.capability.1)
    }

    /// Makes the device the current one of this thread.
    pub fn bind(&self) -> Result<(), String> {
        self.context.bind_to_thread().map_err(words)
    }

    /// Free bytes and all bytes.
    pub fn memory(&self) -> (usize, usize) {
        self.context.mem_get_info().unwrap_or((0, 0))
    }

    /// Waits for everything that was launched.
    pub fn wait(&self) -> Result<(), String> {
        self.context.synchronize().map_err(words)
    }
}

fn driver_version() -> Result<i32, String> {
    let mut version = 0;
    // SAFETY: the pointer is valid for the call.
    unsafe { sys::cuDriverGetVersion(&mut version) }.result().map_err(words)?;
    Ok(version)
}

/// Plain data that may be copied to and from the device byte by byte.
///
/// # Safety
/// Any pattern of bytes that a kernel writes is a value, and the type has no padding that matters.
pub unsafe trait Plain: Copy + Default {}
// SAFETY: numbers and arrays of them.
unsafe impl Plain for f64 {}
unsafe impl Plain for f32 {}
unsafe impl Plain for u16 {}
unsafe impl Plain for u32 {}
unsafe impl Plain for i32 {}
unsafe impl Plain for u64 {}
unsafe impl Plain for [i32; 4] {}
unsafe impl Plain for [f64; 4] {}
// SAFETY: structs of numbers in the layout of C.
unsafe impl Plain for super::layout::Control {}
unsafe impl Plain for super::layout::Limit {}

/// Bytes on the device.
#[derive(Default)]
pub struct Buffer {
    address: sys::CUdeviceptr,
    bytes: usize,
}

impl Buffer {
    /// Zeros. `None` where memory is out.
    pub fn new(bytes: usize) -> Result<Option<Self>, String> {
        // No array is empty for the driver.
        let bytes = bytes.max(16).next_multiple_of(16);
        // SAFETY: the memory is freed once, on drop.
        let address = match unsafe { result::malloc_sync(bytes) } {
            Ok(address) => address,
            Err(DriverError(sys::CUresult::CUDA_ERROR_OUT_OF_MEMORY)) => return Ok(None),
            Err(e) => return Err(words(e)),
        };
        let buffer = Self { address, bytes };
        buffer.clear()?;
        Ok(Some(buffer))
    }

    /// Zeros again.
    pub fn clear(&self) -> Result<(), String> {
        // SAFETY: the range is this buffer.
        unsafe { result::memset_d8_sync(self.address, 0, self.bytes) }.map_err(words)
    }

    pub fn address(&self) -> u64 {
        self.address
    }

    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Copies values to the device, from entry `at` on.
    pub fn write<T: Plain>(&self, at: usize, values: &[T]) -> Result<(), String> {
        if values.is_empty() {
            return Ok(());
        }
        let begin = at * size_of::<T>();
        assert!(begin + size_of_val(values) <= self.bytes, "a copy stays inside its array");
        // SAFETY: the range lies inside the buffer.
        unsafe { result::memcpy_htod_sync(self.address + begin as u64, values) }.map_err(words)
    }

    /// Copies `count` values from entry `at` on to the host.
    pub fn read<T: Plain>(&self, at: usize, count: usize) -> Result<Vec<T>, String> {
        let begin = at * size_of::<T>();
        assert!(begin + count * size_of::<T>() <= self.bytes, "a copy stays inside its array");
        let mut values = vec![T::default(); count];
        if count > 0 {
            // SAFETY: the range lies inside the buffer, and any bytes are a value.
            unsafe { result::memcpy_dtoh_sync(&mut values, self.address + begin as u64) }.map_err(words)?;
        }
        Ok(values)
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        if self.address != 0 {
            // SAFETY: allocated in `new`, freed only here. An error would repeat an earlier one.
            let _ = unsafe { result::free_sync(self.address) };
        }
    }
}

/// A kernel and what it takes of a multiprocessor.
pub struct Kernel {
    function: sys::CUfunction,
    pub registers: i32,
    pub shared_bytes: i32,
    /// Bytes of a thread that its registers do not hold.
    pub local_bytes: i32,
    /// Blocks that fit on a multiprocessor at the same time.
    pub resident: u32,
}

/// Loaded kernels.
pub struct Module {
    module: sys::CUmodule,
}

// SAFETY: handles of the driver may be used from any thread on which the context is current.
unsafe impl Send for Module {}
unsafe impl Send for Kernel {}

impl Module {
    /// Loads a binary.
    pub fn load(cubin: &[u8]) -> Result<Self, String> {
        // SAFETY: the driver copies the image, whose header tells its size.
        let module = unsafe { result::module::load_data(cubin.as_ptr().cast::<c_void>()) }.map_err(words)?;
        Ok(Self { module })
    }

    /// A kernel by its name, for blocks of so many threads.
    pub fn kernel(&self, name: &str, block: u32) -> Result<Kernel, String> {
        let text = CString::new(name).expect("names have no zero bytes");
        // SAFETY: the module is loaded and the function belongs to it.
        unsafe {
            let function = result::module::get_function(self.module, text).map_err(words)?;
            let attribute = |a| result::function::get_function_attribute(function, a).map_err(words);
            let resident =
                result::occupancy::max_active_block_per_multiprocessor(function, block as i32, 0).map_err(words)?;
            Ok(Kernel {
                function,
                registers: attribute(CUfunction_attribute::CU_FUNC_ATTRIBUTE_NUM_REGS)?,
                shared_bytes: attribute(CUfunction_attribute::CU_FUNC_ATTRIBUTE_SHARED_SIZE_BYTES)?,
                local_bytes: attribute(CUfunction_attribute::CU_FUNC_ATTRIBUTE_LOCAL_SIZE_BYTES)?,
                resident: resident.max(0) as u32,
            })
        }
    }
}

impl Drop for Module {
    fn drop(&mut self) {
        // SAFETY: loaded in `load`, unloaded only here.
        let _ = unsafe { result::module::unload(self.module) };
    }
}

impl Kernel {
    /// Launches the kernel with all its blocks resident at the same time. Parameters are structs in the layout of the kernel's
    /// text, which was generated from the same types.
    pub fn launch(&self, blocks: u32, block: u32, parameters: &[*const c_void]) -> Result<(), String> {
        let mut pointers: Vec<*mut c_void> = parameters.iter().map(|p| p.cast_mut()).collect();
        // SAFETY: the driver copies parameters before it returns; the caller's structs are those of the kernel's text, and
        // the arrays they point to live until the device is waited for.
        unsafe {
            result::launch_cooperative_kernel(
                self.function,
                (blocks, 1, 1),
                (block, 1, 1),
                0,
                std::ptr::null_mut(),
                &mut pointers,
            )
        }
        .map_err(words)
    }
}
