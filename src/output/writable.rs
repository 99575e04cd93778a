//! Can a file be written? Asked while a script is judged, so without touching anything.

use std::path::Path;

/// Says why `path` could not be created or overwritten; creates nothing. The answer is a forecast: disks fill, folders go.
pub fn check_writable(path: impl AsRef<Path>) -> Result<(), String> {
    let path = path.as_ref();
    if path.as_os_str().is_empty() {
        return Err("expected a file name, got an empty one".into());
    }
    why_unwritable(path).map_err(|why| format!("cannot write '{}': {why}", path.display()))
}

/// [`check_writable`]'s reason alone.
pub fn why_unwritable(path: &Path) -> Result<(), String> {
    match std::fs::metadata(path) {
        Ok(found) if found.is_dir() => return Err("it is a folder".into()),
        Ok(found) if found.is_file() => {
            // Opening for append changes nothing, not even the time of modification.
            return std::fs::OpenOptions::new().append(true).open(path).map(|_| ()).map_err(|e| e.to_string());
        }
        // Pipes and devices: opening one may block.
        Ok(_) => return Ok(()),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => (),
        Err(e) => return Err(e.to_string()),
    }
    if path.file_name().is_none() || path.to_string_lossy().ends_with('/') {
        return Err("it is not a file name".into());
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    match std::fs::metadata(folder) {
        Ok(found) if !found.is_dir() => Err(format!("'{}' is not a folder", folder.display())),
        Ok(found) if found.permissions().readonly() => Err(format!("the folder '{}' is read-only", folder.display())),
        Ok(_) => Ok(()),
        Err(e) => Err(format!("the folder '{}': {e}", folder.display())),
    }
}

#[cfg(test)]
mod tests {
    use super::check_writable;

    #[test]
    fn tells_what_is_wrong_and_creates_nothing() {
        let folder = std::env::temp_dir().join(format!("octant-writable-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("new.dump");
        assert!(check_writable(&file).is_ok());
        assert!(!file.exists());
        assert!(check_writable(&folder).unwrap_err().contains("is a folder"));
        assert!(check_writable(folder.join("absent").join("x")).unwrap_err().contains("absent"));
        std::fs::write(&file, "kept").unwrap();
        assert!(check_writable(&file).is_ok());
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "kept");
        assert!(check_writable(file.join("below")).is_err());
        assert!(check_writable("").is_err());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
