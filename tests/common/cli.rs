//! The binary in a folder of its own.
#![allow(dead_code)]

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use assert_cmd::Command;

/// The folder that fixtures are in: the package's own, or the one that OCTANT_TEST_ROOT names where tests run on another
/// machine than the one they were compiled on.
pub fn root() -> PathBuf {
    std::env::var_os("OCTANT_TEST_ROOT").map_or_else(|| env!("CARGO_MANIFEST_DIR").into(), PathBuf::from)
}

/// An empty folder, removed when dropped.
pub struct Folder(pub PathBuf);

impl Folder {
    /// `name` must differ from all others of the same test file.
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("octant-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// Names and contents of what lies in it.
    pub fn files(&self) -> BTreeMap<String, Vec<u8>> {
        let entries = fs::read_dir(&self.0).unwrap().map(|entry| entry.unwrap().path());
        entries.map(|p| (p.file_name().unwrap().to_string_lossy().into_owned(), fs::read(p).unwrap())).collect()
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn has(&self, name: &str) -> bool {
        self.0.join(name).exists()
    }

    /// `octant ARGS` in the folder; `args` are parted at blanks.
    pub fn octant(&self, args: &str) -> Command {
        let mut octant = Command::cargo_bin("octant").unwrap();
        octant.current_dir(&self.0).args(args.split(' '));
        octant.timeout(std::time::Duration::from_secs(120));
        octant
    }

    /// Standard output of a run that must succeed.
    pub fn says(&self, args: &str) -> String {
        let done = self.octant(args).output().unwrap();
        let error = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!((done.status.code(), error.as_str()), (Some(0), ""), "octant {args}");
        String::from_utf8(done.stdout).unwrap()
    }

    /// Standard error of a run that must end with exit code `code`.
    pub fn fails(&self, code: i32, args: &str) -> String {
        let done = self.octant(args).output().unwrap();
        let error = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(code), "octant {args}: {error}");
        error
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A small melt; `{RUN}` stands for what follows the set-up.
pub fn melt(run: &str) -> String {
    format!(
        "units lj\nlattice fcc 0.8442\nregion box block 0 4 0 4 0 4\ncreate_box 1 box\ncreate_atoms 1 box\nmass 1 1.0\n\
         velocity all create 3.0 87287\npair_style lj/cut 2.5\npair_coeff 1 1 1.0 1.0\nfix 1 all nve\n{run}\n"
    )
}
