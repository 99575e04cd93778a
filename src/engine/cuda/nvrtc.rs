//! NVRTC, NVIDIA's run-time compiler, found and loaded when it is needed (CUDA documentation: NVRTC).
#![allow(unsafe_code)]

use std::env;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};

use libloading::Library;

/// Environment variable that names the library or the folder it is in.
pub const VARIABLE: &str = "OCTANT_NVRTC";

/// Oldest version that works.
const OLDEST: (i32, i32) = (12, 4);

type Handle = *mut c_void;
type Status = c_int;

/// The loaded library.
pub struct Nvrtc {
    loaded: Library,
    _parts: Vec<Library>,
    pub path: PathBuf,
    pub version: (i32, i32),
}

/// What comes out of a compilation.
pub struct Compiled {
    pub cubin: Vec<u8>,
    pub ptx: String,
}

impl Nvrtc {
    /// Loads the first library that is new enough; the error says where it was looked for.
    pub fn load() -> Result<Self, String> {
        let mut refused = Vec::new();
        let places = candidates();
        for path in &places {
            match Self::open(path) {
                Ok(nvrtc) if nvrtc.version >= OLDEST => return Ok(nvrtc),
                Ok(nvrtc) => refused.push(format!("{} has version {}", path.display(), nvrtc.version_text())),
                Err(_) => {}
            }
        }
        let refused = if refused.is_empty() { String::new() } else { format!(" ({})", refused.join("; ")) };
        Err(format!(
            "NVRTC {}.{} or newer, NVIDIA's run-time compiler, was not found{refused}. `python3 -m venv .venv && .venv/bin/pip install \
             nvidia-cuda-nvrtc` puts it where octant looks; or set {VARIABLE} to libnvrtc.so or its folder",
            OLDEST.0, OLDEST.1
        ))
    }

    fn open(path: &Path) -> Result<Self, libloading::Error> {
        // NVRTC opens a library of its own by name only; loaded from its folder before, it is found.
        let beside = path.parent().filter(|p| !p.as_os_str().is_empty()).map(entries).unwrap_or_default();
        let is_part =
            |p: &&PathBuf| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with("libnvrtc-builtins.so"));
        // SAFETY: initialization routines of NVRTC's libraries have no preconditions.
        let parts = beside.iter().filter(is_part).filter_map(|part| unsafe { Library::new(part) }.ok()).collect();
        // SAFETY: as above.
        let library = unsafe { Library::new(path) }?;
        let mut version = (0, 0);
        // SAFETY: the signature is that of the documentation; both pointers are valid for the call.
        unsafe {
            let ask = library.get::<unsafe extern "C" fn(*mut c_int, *mut c_int) -> Status>(b"nvrtcVersion\0")?;
            ask(&mut version.0, &mut version.1);
        }
        Ok(Self { loaded: library, _parts: parts, path: path.to_path_buf(), version })
    }

    /// "13.0".
    pub fn version_text(&self) -> String {
        format!("{}.{}", self.version.0, self.version.1)
    }

    /// Compiles for an architecture such as "sm_90"; the error shows the source lines at fault.
    pub fn compile(&self, source: &str, options: &[String]) -> Result<Compiled, String> {
        let text = CString::new(source).map_err(|_| "the source holds a zero byte".to_string())?;
        let options: Vec<CString> =
            options.iter().map(|o| CString::new(o.as_str()).expect("options have no zero bytes")).collect();
        let pointers: Vec<*const c_char> = options.iter().map(|o| o.as_ptr()).collect();
        let missing = |e: libloading::Error| format!("{}: {e}", self.path.display());
        // SAFETY: signatures are those of the documentation; every pointer is valid for its call, buffers have the sizes that
        // the library asks for, and the program is destroyed once, at the end.
        unsafe {
            let nvrtc = &self.loaded;
            type Create = unsafe extern "C" fn(
                *mut Handle,
                *const c_char,
                *const c_char,
                c_int,
                *const *const c_char,
                *const *const c_char,
            ) -> Status;
            let create = nvrtc.get::<Create>(b"nvrtcCreateProgram\0").map_err(missing)?;
            let compile = nvrtc
                .get::<unsafe extern "C" fn(Handle, c_int, *const *const c_char) -> Status>(b"nvrtcCompileProgram\0")
                .map_err(missing)?;
            let destroy =
                nvrtc.get::<unsafe extern "C" fn(*mut Handle) -> Status>(b"nvrtcDestroyProgram\0").map_err(missing)?;
            let mut program: Handle = std::ptr::null_mut();
            let name = c"octant.cu";
            let status = create(&mut program, text.as_ptr(), name.as_ptr(), 0, std::ptr::null(), std::ptr::null());
            if status != 0 {
                return Err(self.message(status));
            }
            let status = compile(program, pointers.len() as c_int, pointers.as_ptr());
            let result = if status == 0 {
                let cubin = self.bytes(program, b"nvrtcGetCUBINSize\0", b"nvrtcGetCUBIN\0");
                let ptx = self.bytes(program, b"nvrtcGetPTXSize\0", b"nvrtcGetPTX\0");
                cubin.and_then(|cubin| Ok(Compiled { cubin, ptx: text_of(&ptx?) }))
            } else {
                let log = self.bytes(program, b"nvrtcGetProgramLogSize\0", b"nvrtcGetProgramLog\0")?;
                Err(format!("{}\n{}", self.message(status), with_lines(&text_of(&log), source)))
            };
            destroy(&mut program);
            result
        }
    }

    /// One of the results of a program.
    ///
    /// # Safety
    /// `program` is alive; the names are those of a size and a getter of NVRTC.
    unsafe fn bytes(&self, program: Handle, size: &[u8], get: &[u8]) -> Result<Vec<u8>, String> {
        let missing = |e: libloading::Error| format!("{}: {e}", self.path.display());
        // SAFETY: as the caller promises; the buffer has the size that is asked for.
        unsafe {
            let size = self.loaded.get::<unsafe extern "C" fn(Handle, *mut usize) -> Status>(size).map_err(missing)?;
            let get = self.loaded.get::<unsafe extern "C" fn(Handle, *mut c_char) -> Status>(get).map_err(missing)?;
            let mut count = 0usize;
            let status = size(program, &mut count);
            if status != 0 {
                return Err(self.message(status));
            }
            let mut bytes = vec![0u8; count];
            match get(program, bytes.as_mut_ptr().cast()) {
                0 => Ok(bytes),
                status => Err(self.message(status)),
            }
        }
    }

    fn message(&self, status: Status) -> String {
        // SAFETY: the library returns a text that lives as long as it does.
        let text = unsafe {
            match self.loaded.get::<unsafe extern "C" fn(Status) -> *const c_char>(b"nvrtcGetErrorString\0") {
                Ok(text) => CStr::from_ptr(text(status)).to_string_lossy().into_owned(),
                Err(_) => format!("error {status}"),
            }
        };
        format!("NVRTC {}: {text}", self.version_text())
    }
}

fn text_of(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).trim_end_matches('\0').to_string()
}

/// A compiler log with the source line below each message that names one.
fn with_lines(log: &str, source: &str) -> String {
    let mut text = String::new();
    for line in log.lines() {
        text += line;
        text.push('\n');
        let place = line.split_once("): ").and_then(|(before, _)| before.rsplit_once('('));
        if let Some((file, Ok(number))) = place.map(|(file, number)| (file, number.parse::<usize>()))
            && let Some(shown) = line_of(source, file, number)
        {
            text += &format!("{number:>6} | {shown}\n");
        }
    }
    text
}

/// A line of one of the files that `#line` names in the source; the text before the first is `octant.cu`.
fn line_of<'a>(source: &'a str, file: &str, number: usize) -> Option<&'a str> {
    let mut now = ("octant.cu", 0);
    for line in source.lines() {
        if let Some(name) = line.strip_prefix("#line 1 \"") {
            now = (name.trim_end_matches('"'), 0);
            continue;
        }
        now.1 += 1;
        if now.0 == file && now.1 == number {
            return Some(line);
        }
    }
    None
}

/// Where the library may be, in the order of trying.
fn candidates() -> Vec<PathBuf> {
    let mut found = Vec::new();
    if let Some(named) = env::var_os(VARIABLE).filter(|v| !v.is_empty()).map(PathBuf::from) {
        if named.is_dir() {
            add_libraries(&named, &mut found);
        } else {
            found.push(named);
        }
        // The user's word is the only one.
        return found;
    }
    let mut environments: Vec<PathBuf> = env::var_os("VIRTUAL_ENV").map(PathBuf::from).into_iter().collect();
    let beside = env::current_exe().ok();
    let folders = beside.iter().flat_map(|exe| exe.ancestors().skip(1)).map(Path::to_path_buf);
    environments.extend(env::current_dir().into_iter().chain(folders).map(|folder| folder.join(".venv")));
    for environment in environments {
        for python in entries(&environment.join("lib")) {
            for package in entries(&python.join("site-packages/nvidia")) {
                add_libraries(&package.join("lib"), &mut found);
            }
        }
    }
    for name in ["CUDA_PATH", "CUDA_HOME"] {
        if let Some(root) = env::var_os(name).map(PathBuf::from) {
            add_libraries(&root.join("lib64"), &mut found);
        }
    }
    found.extend(
        ["libnvrtc.so", "libnvrtc.so.13", "libnvrtc.so.12", "nvrtc64_130_0.dll", "nvrtc64_120_0.dll"]
            .map(PathBuf::from),
    );
    add_libraries(Path::new("/usr/local/cuda/lib64"), &mut found);
    found
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> =
        std::fs::read_dir(folder).into_iter().flatten().filter_map(|e| e.ok().map(|e| e.path())).collect();
    found.sort();
    found
}

/// Libraries of NVRTC in a folder, the newest first.
fn add_libraries(folder: &Path, found: &mut Vec<PathBuf>) {
    let is_nvrtc = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        name.starts_with("libnvrtc.so") || (name.starts_with("nvrtc64_") && name.ends_with(".dll"))
    };
    found.extend(entries(folder).into_iter().filter(is_nvrtc).rev());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_show_the_line_of_their_file() {
        let source = "#define A\n#line 1 \"kernels/b.cuh\"\nint x;\nint y = z;\n";
        let log = "kernels/b.cuh(2): error: identifier \"z\" is undefined\noctant.cu(1): warning: nothing\n";
        let text = with_lines(log, source);
        assert!(text.contains("     2 | int y = z;\n"), "{text}");
        assert!(text.contains("     1 | #define A\n"), "{text}");
    }
}
