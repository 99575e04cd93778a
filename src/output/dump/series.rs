//! The file, or the row of files, that a text dump writes.

use std::collections::VecDeque;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Write};

use crate::Error;

/// One file, or, with a `*` in the name, one a snapshot.
pub(super) struct Series {
    pattern: String,
    /// Digits of the step, filled with zeros.
    pub pad: usize,
    /// How many of several files are kept.
    pub max_files: Option<usize>,
    pub append: bool,
    pub flush: bool,
    open: Option<(String, BufWriter<File>)>,
    /// Several files: those there are, oldest first.
    kept: VecDeque<String>,
    frames: u64,
    bytes: u64,
}

impl Series {
    pub fn new(pattern: &str) -> Self {
        Self {
            pattern: pattern.to_string(),
            pad: 0,
            max_files: None,
            append: false,
            flush: true,
            open: None,
            kept: VecDeque::new(),
            frames: 0,
            bytes: 0,
        }
    }

    pub fn several(&self) -> bool {
        self.pattern.contains('*')
    }

    pub fn pattern(&self) -> &str {
        &self.pattern
    }

    pub fn frames(&self) -> u64 {
        self.frames
    }

    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// True if the next snapshot begins a file.
    pub fn begins_file(&self) -> bool {
        self.several() || self.frames == 0
    }

    /// Opens the one file: LAMMPS, too, leaves an empty file where a run ends before the first snapshot.
    pub fn open(&mut self) -> Result<(), Error> {
        if self.several() || self.open.is_some() { Ok(()) } else { self.begin(0) }
    }

    /// Adds a snapshot.
    pub fn write(&mut self, step: i64, snapshot: &[u8]) -> Result<(), Error> {
        if self.open.is_none() {
            self.begin(step)?;
        }
        let Some((path, writer)) = &mut self.open else { return Ok(()) };
        let mut written = writer.write_all(snapshot);
        if self.flush {
            written = written.and_then(|()| writer.flush());
        }
        written.map_err(|e| Error::file(&*path, "cannot write", e))?;
        self.frames += 1;
        self.bytes += snapshot.len() as u64;
        if self.several() { self.close() } else { Ok(()) }
    }

    fn begin(&mut self, step: i64) -> Result<(), Error> {
        let pad = self.pad;
        let path = self.pattern.replace('*', &format!("{step:0pad$}"));
        // A dump that was closed and goes on must not wipe out what it has written.
        let append = self.append || (!self.several() && self.frames > 0);
        let file = OpenOptions::new().write(true).create(true).append(append).truncate(!append).open(&path);
        let file = file.map_err(|e| Error::file(&path, "cannot write", e))?;
        if self.several() {
            if self.max_files.is_some_and(|most| self.kept.len() >= most)
                && let Some(oldest) = self.kept.pop_front()
            {
                std::fs::remove_file(&oldest).map_err(|e| Error::file(&oldest, "cannot remove", e))?;
            }
            self.kept.push_back(path.clone());
        }
        self.open = Some((path, BufWriter::new(file)));
        Ok(())
    }

    pub fn close(&mut self) -> Result<(), Error> {
        match self.open.take() {
            Some((path, mut writer)) => writer.flush().map_err(|e| Error::file(path, "cannot write", e)),
            None => Ok(()),
        }
    }
}
