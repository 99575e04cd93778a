//! Compiled kernels on disk, found again by what they were compiled from.

use std::env;
use std::ffi::OsString;
use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use sha2::{Digest, Sha256};

use super::nvrtc::{Compiled, Nvrtc};

/// Environment variable that names the folder; an empty value switches the cache off.
pub const VARIABLE: &str = "OCTANT_CACHE";

/// What turns a source into binaries: NVRTC, or what stands for it in a test.
pub trait SourceCompiler {
    /// Version, by which binaries are kept apart.
    fn version_text(&self) -> String;
    /// Compiles; the error says what is wrong with the source.
    fn compile(&self, source: &str, options: &[String]) -> Result<Compiled, String>;
}

impl SourceCompiler for Nvrtc {
    fn version_text(&self) -> String {
        Nvrtc::version_text(self)
    }

    fn compile(&self, source: &str, options: &[String]) -> Result<Compiled, String> {
        Nvrtc::compile(self, source, options)
    }
}

/// A binary and where it came from.
#[derive(Debug)]
pub struct Kernels {
    pub cubin: Vec<u8>,
    /// Intermediate code, for what is told of it.
    pub ptx: String,
    /// It was on disk.
    pub cached: bool,
}

/// Options that a scene's kernels are compiled with.
pub fn options(architecture: &str) -> Vec<String> {
    // Divisions and square roots in f32 may be off by a unit in the last place.
    [
        &format!("--gpu-architecture={architecture}"),
        "--std=c++17",
        "--prec-div=false",
        "--prec-sqrt=false",
        "-diag-suppress=177",
    ]
    .map(String::from)
    .to_vec()
}

/// Kernels for an architecture such as "sm_90": from the folder, if there is one, or compiled and put there. Without a compiler
/// what any version compiled will do; the error says what is wrong with the source or how to get a compiler.
pub fn kernels<C: SourceCompiler>(
    folder: Option<&Path>,
    source: &str,
    architecture: &str,
    compiler: &Result<C, String>,
) -> Result<Kernels, String> {
    let options = options(architecture);
    let mut hash = Sha256::new();
    hash.update(source.as_bytes());
    for option in &options {
        hash.update([0]);
        hash.update(option.as_bytes());
    }
    let hash: String = hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect();
    let name = format!("{hash}.{architecture}");
    let of_version = |folder: &Path, compiler: &C| folder.join(format!("nvrtc-{}", compiler.version_text()));
    if let Some(folder) = folder {
        let versions = match compiler {
            Ok(compiler) => vec![of_version(folder, compiler)],
            Err(_) => fs::read_dir(folder).into_iter().flatten().filter_map(|e| e.ok().map(|e| e.path())).collect(),
        };
        for version in versions {
            if let Some((cubin, ptx)) = read(&version, &name) {
                return Ok(Kernels { cubin, ptx, cached: true });
            }
        }
    }
    let compiler = compiler.as_ref().map_err(Clone::clone)?;
    let Compiled { cubin, ptx } = compiler.compile(source, &options)?;
    if let Some(folder) = folder {
        // A cache that cannot be written is no fault.
        let _ = write(&of_version(folder, compiler), &name, &cubin, &ptx);
    }
    Ok(Kernels { cubin, ptx, cached: false })
}

/// Whether nothing has ever been put into the user's folder, or there is none.
pub fn is_unused() -> bool {
    folder().and_then(|folder| fs::read_dir(folder).ok()).is_none_or(|mut entries| entries.next().is_none())
}

/// Binary and intermediate code of that name; an empty file, which a machine that lost its power may leave, is none.
fn read(folder: &Path, name: &str) -> Option<(Vec<u8>, String)> {
    let cubin = fs::read(folder.join(format!("{name}.cubin"))).ok()?;
    let ptx = fs::read_to_string(folder.join(format!("{name}.ptx"))).ok()?;
    (!cubin.is_empty() && !ptx.is_empty()).then_some((cubin, ptx))
}

fn write(folder: &Path, name: &str, cubin: &[u8], ptx: &str) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    for (bytes, kind) in [(ptx.as_bytes(), "ptx"), (cubin, "cubin")] {
        write_one(folder, &format!("{name}.{kind}"), bytes)?;
    }
    Ok(())
}

/// The whole file appears or none: it is written beside its place, under a name that no other thread or process has, and renamed.
fn write_one(folder: &Path, name: &str, bytes: &[u8]) -> io::Result<()> {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    let (beside, mut file) = loop {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let beside = folder.join(format!("{name}.{}-{number}", std::process::id()));
        // Processes of two machines that share the folder may have the same number.
        match OpenOptions::new().write(true).create_new(true).open(&beside) {
            Ok(file) => break (beside, file),
            Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
            Err(e) => return Err(e),
        }
    };
    let written = file.write_all(bytes).and_then(|()| fs::rename(&beside, folder.join(name)));
    if written.is_err() {
        // What went wrong first is what counts.
        let _ = fs::remove_file(&beside);
    }
    written
}

/// The user's cache folder; none if it is switched off or nobody's.
pub fn folder() -> Option<PathBuf> {
    folder_of(env::var_os(VARIABLE), env::var_os("XDG_CACHE_HOME"), env::var_os("HOME"))
}

/// The same from the environment's values: the folder named by [`VARIABLE`], the user's folder for caches, the home folder.
fn folder_of(named: Option<OsString>, caches: Option<OsString>, home: Option<OsString>) -> Option<PathBuf> {
    let there = |value: &OsString| !value.is_empty();
    match named {
        Some(named) => there(&named).then(|| PathBuf::from(named)),
        None => {
            let home = || home.filter(there).map(|home| PathBuf::from(home).join(".cache"));
            Some(caches.filter(there).map(PathBuf::from).or_else(home)?.join("octant"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Barrier;
    use std::sync::atomic::AtomicUsize;

    /// Stands for a compiler: counts, and answers with what it was asked.
    struct Counting {
        version: &'static str,
        compiled: AtomicUsize,
        /// Bytes of what it makes.
        size: usize,
    }

    impl SourceCompiler for Counting {
        fn version_text(&self) -> String {
            self.version.into()
        }

        fn compile(&self, source: &str, options: &[String]) -> Result<Compiled, String> {
            self.compiled.fetch_add(1, Ordering::Relaxed);
            let text = format!("{source} {options:?} {}\n", self.version);
            let text = text.repeat(self.size.div_ceil(text.len()));
            Ok(Compiled { cubin: text.clone().into_bytes(), ptx: text })
        }
    }

    fn version(version: &'static str) -> Result<Counting, String> {
        Ok(Counting { version, compiled: AtomicUsize::new(0), size: 1 })
    }

    fn count(compiler: &Result<Counting, String>) -> usize {
        compiler.as_ref().unwrap().compiled.load(Ordering::Relaxed)
    }

    /// A place for a cache, which is not there yet; removed when dropped.
    struct Place(PathBuf);

    impl Place {
        fn new(name: &str) -> Self {
            let path = env::temp_dir().join(format!("octant-cache-{}-{name}", std::process::id()));
            let _ = fs::remove_dir_all(&path);
            Self(path)
        }

        /// Everything in the folders of versions.
        fn files(&self) -> Vec<PathBuf> {
            let paths = |folder: &Path| -> Vec<PathBuf> {
                fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
            };
            paths(&self.0).iter().flat_map(|version| paths(version)).collect()
        }

        fn only(&self, kind: &str) -> PathBuf {
            let mut of_kind = self.files().into_iter().filter(|path| path.extension().is_some_and(|e| e == kind));
            let path = of_kind.next().unwrap();
            assert_eq!(of_kind.next(), None);
            path
        }
    }

    impl Drop for Place {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn is_asked_by_source_architecture_and_version() {
        let place = Place::new("by");
        let (folder, older, newer) = (Some(&*place.0), version("12.4"), version("13.0"));
        let first = kernels(folder, "a", "sm_80", &older).unwrap();
        let again = kernels(folder, "a", "sm_80", &older).unwrap();
        assert!(!first.cached && again.cached && count(&older) == 1);
        assert_eq!((&first.cubin, &first.ptx), (&again.cubin, &again.ptx));
        let others = [("b", "sm_80", &older, 2), ("a", "sm_90", &older, 3), ("a", "sm_80", &newer, 1)];
        for (source, architecture, compiler, compiled) in others {
            let other = kernels(folder, source, architecture, compiler).unwrap();
            assert!(!other.cached && count(compiler) == compiled, "{source}, {architecture}");
            assert_ne!(other.cubin, first.cubin, "{source}, {architecture}");
            assert!(kernels(folder, source, architecture, compiler).unwrap().cached);
        }
        assert_eq!((count(&older), count(&newer), place.files().len()), (3, 1, 8));
    }

    #[test]
    fn without_a_compiler_any_version_will_do() {
        let place = Place::new("any");
        let (folder, none) = (Some(&*place.0), Err::<Counting, _>("no compiler".to_string()));
        assert_eq!(kernels(folder, "a", "sm_80", &none).unwrap_err(), "no compiler");
        let made = kernels(folder, "a", "sm_80", &version("12.4")).unwrap();
        let found = kernels(folder, "a", "sm_80", &none).unwrap();
        assert!(found.cached && found.cubin == made.cubin && found.ptx == made.ptx);
        assert_eq!(kernels(folder, "a", "sm_90", &none).unwrap_err(), "no compiler");
        assert_eq!(kernels(None, "a", "sm_80", &none).unwrap_err(), "no compiler");
    }

    #[test]
    fn what_is_not_whole_is_compiled_again() {
        let place = Place::new("half");
        let (folder, compiler) = (Some(&*place.0), version("13.0"));
        let made = kernels(folder, "a", "sm_80", &compiler).unwrap();
        let (ptx, cubin) = (place.only("ptx"), place.only("cubin"));
        let empty = |path: &Path| fs::write(path, "").unwrap();
        let remove = |path: &Path| fs::remove_file(path).unwrap();
        let spoil: [&dyn Fn(); 4] = [&|| remove(&cubin), &|| empty(&cubin), &|| remove(&ptx), &|| empty(&ptx)];
        for (k, spoil) in spoil.iter().enumerate() {
            spoil();
            let again = kernels(folder, "a", "sm_80", &compiler).unwrap();
            assert!(!again.cached && count(&compiler) == k + 2, "{k}");
            assert!(kernels(folder, "a", "sm_80", &compiler).unwrap().cached, "{k}");
            assert_eq!(fs::read(&cubin).unwrap(), made.cubin);
            assert_eq!(fs::read_to_string(&ptx).unwrap(), made.ptx);
        }
    }

    #[test]
    fn many_threads_at_once_leave_whole_files() {
        const THREADS: usize = 16;
        let place = Place::new("threads");
        let size = 3_000_000;
        let compiler = Ok(Counting { version: "13.0", compiled: AtomicUsize::new(0), size });
        let made = compiler.as_ref().map(|c: &Counting| c.compile("a", &options("sm_80")).unwrap()).unwrap();
        // Several rounds, since threads may miss each other in one.
        for round in 0..4 {
            let start = Barrier::new(THREADS);
            let ask = || {
                start.wait();
                for _ in 0..2 {
                    let got = kernels(Some(&place.0), "a", "sm_80", &compiler).unwrap();
                    assert!(got.cubin == made.cubin && got.ptx == made.ptx, "half a file was read in round {round}");
                }
            };
            std::thread::scope(|scope| {
                for thread in (0..THREADS).map(|_| scope.spawn(ask)).collect::<Vec<_>>() {
                    thread.join().unwrap();
                }
            });
            assert_eq!(place.files().len(), 2, "{:?}", place.files());
            assert!(fs::read(place.only("cubin")).unwrap() == made.cubin);
            assert!(fs::read(place.only("ptx")).unwrap() == made.ptx.as_bytes());
            fs::remove_file(place.only("cubin")).unwrap();
        }
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_no_fault() {
        let place = Place::new("file");
        fs::write(&place.0, "a file where the folder should be").unwrap();
        let compiler = version("13.0");
        for folder in [place.0.clone(), place.0.join("below")] {
            for _ in 0..2 {
                assert!(!kernels(Some(&folder), "a", "sm_80", &compiler).unwrap().cached);
            }
        }
        assert_eq!(count(&compiler), 4);
        fs::remove_file(&place.0).unwrap();
    }

    #[test]
    fn an_empty_name_switches_it_off() {
        let value = |text: &str| Some(OsString::from(text));
        assert_eq!(folder_of(value(""), value("/caches"), value("/home/me")), None);
        assert_eq!(folder_of(value("/here"), value("/caches"), None), Some("/here".into()));
        assert_eq!(folder_of(None, value("/caches"), value("/home/me")), Some("/caches/octant".into()));
        assert_eq!(folder_of(None, value(""), value("/home/me")), Some("/home/me/.cache/octant".into()));
        assert_eq!(folder_of(None, None, None), None);
        let compiler = version("13.0");
        for _ in 0..2 {
            assert!(!kernels(None, "a", "sm_80", &compiler).unwrap().cached);
        }
        assert_eq!(count(&compiler), 2);
    }
}
