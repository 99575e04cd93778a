//! Screen and log file.

use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};

use indicatif::ProgressBar;

use super::writable::why_unwritable;
use crate::Error;

/// How warnings begin.
const WARNING: &str = "WARNING: ";

/// Writes lines to the screen and to the log file, with the rules of LAMMPS's `echo` and `log` commands: a script's lines go
/// to the log unless `echo` says otherwise, everything else goes to both.
///
/// Nothing is lost when the screen goes away: a closed standard output ends screen output only.
pub struct Console {
    screen: Option<Box<dyn Write + Send>>,
    log: Option<LogFile>,
    echo_screen: bool,
    echo_log: bool,
    /// Warnings met inside a thermo table, to be printed below it; `None` outside a table.
    table: Option<Vec<String>>,
    /// Somebody sits at the screen, who reads a warning at once.
    is_terminal: bool,
    /// Texts of all warnings so far.
    warnings: Vec<String>,
    /// What was said since [`Console::held`], until [`Console::release`].
    queue: Option<Vec<Event>>,
    discards: bool,
    bar: Option<ProgressBar>,
    fault: Option<Error>,
}

struct LogFile {
    path: PathBuf,
    writer: BufWriter<File>,
}

/// Something a held console has put off.
#[derive(Debug)]
enum Event {
    Text { text: String, target: Target },
    OpenLog { path: PathBuf, append: bool },
    CloseLog,
}

/// Where a line goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Target {
    Both,
    Screen,
    Log,
}

/// The choices of the `echo` command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Echo {
    /// The script's lines are shown nowhere.
    None,
    /// On the screen.
    Screen,
    /// In the log file.
    #[default]
    Log,
    /// In both.
    Both,
}

impl fmt::Debug for Console {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Console")
            .field("screen", &self.screen.is_some())
            .field("log", &self.log_path())
            .field("queue", &self.queue)
            .field("discards", &self.discards)
            .finish_non_exhaustive()
    }
}

impl Default for Console {
    fn default() -> Self {
        Self::new(false)
    }
}

impl Console {
    /// A console on standard output (silent if `quiet`), without a log file yet.
    pub fn new(quiet: bool) -> Self {
        let mut console = Self::on(if quiet { None } else { Some(Box::new(std::io::stdout())) });
        console.is_terminal = !quiet && std::io::stdout().is_terminal();
        console
    }

    /// A console whose screen is any writer, or none.
    pub fn on(screen: Option<Box<dyn Write + Send>>) -> Self {
        Self {
            screen,
            log: None,
            echo_screen: false,
            echo_log: true,
            table: None,
            is_terminal: false,
            warnings: Vec::new(),
            queue: None,
            discards: false,
            bar: None,
            fault: None,
        }
    }

    /// A console that drops everything (for judging a script).
    pub fn discard() -> Self {
        let mut console = Self::on(None);
        console.discards = true;
        console
    }

    /// Puts off all output, log files included, until [`Console::release`].
    pub fn held(mut self) -> Self {
        self.queue.get_or_insert_default();
        self
    }

    /// Writes what was put off and goes on without delay.
    pub fn release(&mut self) -> Result<(), Error> {
        for event in self.queue.take().unwrap_or_default() {
            match event {
                Event::Text { text, target } => self.put(&text, target),
                Event::OpenLog { path, append } => self.open_log(&path, append)?,
                Event::CloseLog => self.close_log(),
            }
        }
        self.flush();
        Ok(())
    }

    /// A line for both.
    pub fn line(&mut self, text: &str) {
        self.put(text, Target::Both);
    }

    /// A line for the log file alone.
    pub fn log_only(&mut self, text: &str) {
        self.put(text, Target::Log);
    }

    /// A line for the screen alone.
    pub fn screen_only(&mut self, text: &str) {
        self.put(text, Target::Screen);
    }

    /// Lines of the script itself, shown where `echo` says.
    pub fn echo(&mut self, lines: &[String]) {
        let target = match (self.echo_screen, self.echo_log) {
            (true, true) => Target::Both,
            (true, false) => Target::Screen,
            (false, true) => Target::Log,
            (false, false) => return,
        };
        for line in lines {
            self.put(line, target);
        }
    }

    /// The `echo` command.
    pub fn set_echo(&mut self, echo: Echo) {
        self.echo_screen = matches!(echo, Echo::Screen | Echo::Both);
        self.echo_log = matches!(echo, Echo::Log | Echo::Both);
    }

    /// A warning for both; one met inside a thermo table is printed below the table, for readers of logs
    /// take every line in between for data. A terminal shows it at once.
    pub fn warning(&mut self, text: &str) {
        self.warnings.push(text.to_string());
        let line = format!("{WARNING}{text}");
        match &mut self.table {
            Some(waiting) => {
                waiting.push(line.clone());
                if self.is_terminal {
                    self.screen_only(&line);
                }
            }
            None => self.line(&line),
        }
    }

    /// What a command has to say: a line, or a warning if it begins like one.
    pub fn message(&mut self, line: &str) {
        match line.strip_prefix(WARNING) {
            Some(text) => self.warning(text),
            None => self.line(line),
        }
    }

    /// Texts of all warnings so far.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// From here on warnings wait.
    pub fn begin_table(&mut self) {
        self.table.get_or_insert_default();
    }

    /// The table is complete: prints the warnings that waited.
    pub fn end_table(&mut self) {
        let target = if self.is_terminal { Target::Log } else { Target::Both };
        for line in self.table.take().unwrap_or_default() {
            self.put(&line, target);
        }
    }

    /// Closes the log file, if there is one, and goes on in another (`log FILE [append]`).
    pub fn open_log(&mut self, path: &Path, append: bool) -> Result<(), Error> {
        if self.discards || self.queue.is_some() {
            why_unwritable(path).map_err(|why| Error::file(path, "cannot write", std::io::Error::other(why)))?;
        }
        if self.discards {
            return Ok(());
        }
        if let Some(queue) = &mut self.queue {
            queue.push(Event::OpenLog { path: path.to_path_buf(), append });
            return Ok(());
        }
        self.close_log();
        let file = OpenOptions::new().write(true).create(true).append(append).truncate(!append).open(path);
        let file = file.map_err(|e| Error::file(path, "cannot write", e))?;
        self.log = Some(LogFile { path: path.to_path_buf(), writer: BufWriter::new(file) });
        Ok(())
    }

    /// `log none`.
    pub fn close_log(&mut self) {
        if let Some(queue) = &mut self.queue {
            queue.push(Event::CloseLog);
            return;
        }
        self.flush();
        self.log = None;
    }

    /// Path of the open log file.
    pub fn log_path(&self) -> Option<&Path> {
        self.log.as_ref().map(|log| log.path.as_path())
    }

    /// Hands over everything written so far to the operating system.
    pub fn flush(&mut self) {
        if let Some(screen) = &mut self.screen
            && screen.flush().is_err()
        {
            self.screen = None;
        }
        if let Some(log) = &mut self.log
            && let Err(error) = log.writer.flush()
        {
            self.log_failed(error);
        }
    }

    /// The first thing that went wrong with the log file (a full disk), once. Output to it has stopped then.
    pub fn take_fault(&mut self) -> Option<Error> {
        self.fault.take()
    }

    /// A progress bar that screen lines must not tear; `None` when it is gone.
    pub fn set_bar(&mut self, bar: Option<ProgressBar>) {
        self.bar = bar;
    }

    fn put(&mut self, text: &str, target: Target) {
        if self.discards {
            return;
        }
        if let Some(queue) = &mut self.queue {
            queue.push(Event::Text { text: text.to_string(), target });
            return;
        }
        if target != Target::Log
            && let Some(screen) = &mut self.screen
        {
            let written = match &self.bar {
                Some(bar) => bar.suspend(|| writeln!(screen, "{text}").and_then(|()| screen.flush())),
                None => writeln!(screen, "{text}"),
            };
            // The reader of our standard output has gone: the run goes on for the files.
            if written.is_err() {
                self.screen = None;
            }
        }
        if target != Target::Screen
            && let Some(log) = &mut self.log
            && let Err(error) = writeln!(log.writer, "{text}")
        {
            self.log_failed(error);
        }
    }

    fn log_failed(&mut self, error: std::io::Error) {
        if let Some(log) = self.log.take() {
            // What is still in the buffer cannot be written either: drop it without another try.
            let _ = log.writer.into_parts();
            self.fault.get_or_insert(Error::file(log.path, "cannot write", error));
        }
    }
}

impl Drop for Console {
    fn drop(&mut self) {
        self.flush();
    }
}

#[cfg(test)]
#[path = "console_tests.rs"]
mod tests;
