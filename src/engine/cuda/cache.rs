//! Compiled kernels on disk, found again by what they were compiled from.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::nvrtc::{Compiled, Nvrtc};

/// Environment variable that names the folder; an empty value switches the cache off.
pub const VARIABLE: &str = "OCTANT_CACHE";

/// A binary and where it came from.
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

/// Kernels for an architecture such as "sm_90": from the cache, or compiled and put there. `load` is asked for the compiler
/// only if nothing is found; without a compiler what any version compiled will do.
pub fn kernels(source: &str, architecture: &str, compiler: &Result<Nvrtc, String>) -> Result<Kernels, String> {
    let options = options(architecture);
    let mut hash = Sha256::new();
    hash.update(source.as_bytes());
    for option in &options {
        hash.update([0]);
        hash.update(option.as_bytes());
    }
    let name: String = hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect();
    let folder = folder();
    let version = compiler.as_ref().ok().map(Nvrtc::version_text);
    if let Some(folder) = &folder {
        let versions = match &version {
            Some(version) => vec![folder.join(format!("nvrtc-{version}"))],
            None => fs::read_dir(folder).into_iter().flatten().filter_map(|e| e.ok().map(|e| e.path())).collect(),
        };
        for version in versions {
            if let Some((cubin, ptx)) = read(&version, architecture, &name) {
                return Ok(Kernels { cubin, ptx, cached: true });
            }
        }
    }
    let compiler = compiler.as_ref().map_err(Clone::clone)?;
    let Compiled { cubin, ptx } = compiler.compile(source, &options)?;
    if let Some(folder) = folder {
        // A cache that cannot be written is no fault.
        let _ = write(&folder.join(format!("nvrtc-{}", compiler.version_text())), architecture, &name, &cubin, &ptx);
    }
    Ok(Kernels { cubin, ptx, cached: false })
}

fn read(folder: &Path, architecture: &str, name: &str) -> Option<(Vec<u8>, String)> {
    let cubin = fs::read(folder.join(format!("{name}.{architecture}.cubin"))).ok()?;
    let ptx = fs::read_to_string(folder.join(format!("{name}.{architecture}.ptx"))).ok()?;
    Some((cubin, ptx))
}

/// Whole files appear or none: each is written beside its place and renamed.
fn write(folder: &Path, architecture: &str, name: &str, cubin: &[u8], ptx: &str) -> std::io::Result<()> {
    fs::create_dir_all(folder)?;
    for (bytes, kind) in [(ptx.as_bytes(), "ptx"), (cubin, "cubin")] {
        let path = folder.join(format!("{name}.{architecture}.{kind}"));
        let beside = folder.join(format!("{name}.{architecture}.{kind}.{}", std::process::id()));
        fs::write(&beside, bytes)?;
        fs::rename(&beside, path)?;
    }
    Ok(())
}

/// The user's cache folder.
fn folder() -> Option<PathBuf> {
    match env::var_os(VARIABLE) {
        Some(named) => (!named.is_empty()).then(|| PathBuf::from(named)),
        None => {
            let home = || env::var_os("HOME").map(|home| PathBuf::from(home).join(".cache"));
            let root = env::var_os("XDG_CACHE_HOME").filter(|v| !v.is_empty()).map(PathBuf::from).or_else(home)?;
            Some(root.join("octant"))
        }
    }
}
