//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a file under another name first, so that whoever finds it finds it whole, and a failure leaves what was there.
/// Pipes and devices, which must not be replaced, are written to directly; links are followed.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let found = fs::metadata(path);
    if found.as_ref().is_ok_and(|found| !found.is_file()) {
        let mut out = BufWriter::new(File::options().write(true).open(path)?);
        write(&mut out)?;
        return out.flush();
    }
    let target = if found.is_ok() { fs::canonicalize(path)? } else { path.to_path_buf() };
    let partial = partial_name(&target);
    let written = File::create(&partial).and_then(|file| {
        let mut out = BufWriter::new(file);
        write(&mut out)?;
        out.into_inner().map_err(|e| e.into_error())?.sync_all()?;
        fs::rename(&partial, &target)
    });
    if written.is_err() {
        // The first error is the one to tell; a leftover partial file is no further harm.
        let _ = fs::remove_file(&partial);
    }
    written
}

/// A name beside the target that no one else uses.
fn partial_name(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.partial", std::process::id()));
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_the_old_file() {
        let folder = std::env::temp_dir().join(format!("octant-whole-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("file");
        write_whole(&path, |out| out.write_all(b"old")).unwrap();
        let failed = write_whole(&path, |out| {
            out.write_all(b"new")?;
            Err(io::Error::other("full"))
        });
        assert_eq!(failed.unwrap_err().to_string(), "full");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn links_and_devices_stay_what_they_are() {
        let folder = std::env::temp_dir().join(format!("octant-whole-link-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let (path, link, device) = (folder.join("file"), folder.join("link"), folder.join("device"));
        fs::write(&path, "old").unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        std::os::unix::fs::symlink("/dev/null", &device).unwrap();
        write_whole(&link, |out| out.write_all(b"new")).unwrap();
        write_whole(&device, |out| out.write_all(b"gone")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert!([&link, &device].iter().all(|p| fs::symlink_metadata(p).unwrap().is_symlink()));
        fs::remove_dir_all(&folder).unwrap();
    }
}
