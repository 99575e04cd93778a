//! Screen and log file.

use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use indicatif::ProgressBar;

use super::writable::why_unwritable;
use crate::Error;

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
        Self::on(if quiet { None } else { Some(Box::new(std::io::stdout())) })
    }

    /// A console whose screen is any writer, or none.
    pub fn on(screen: Option<Box<dyn Write + Send>>) -> Self {
        Self {
            screen,
            log: None,
            echo_screen: false,
            echo_log: true,
            table: None,
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
    /// take every line in between for data.
    pub fn warning(&mut self, text: &str) {
        let line = format!("WARNING: {text}");
        match &mut self.table {
            Some(waiting) => waiting.push(line),
            None => self.line(&line),
        }
    }

    /// From here on warnings wait.
    pub fn begin_table(&mut self) {
        self.table.get_or_insert_default();
    }

    /// The table is complete: prints the warnings that waited.
    pub fn end_table(&mut self) {
        for line in self.table.take().unwrap_or_default() {
            self.line(&line);
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
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;

    #[derive(Clone, Default)]
    struct Screen(Arc<Mutex<Vec<u8>>>);

    impl Write for Screen {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    impl Screen {
        fn text(&self) -> String {
            String::from_utf8(self.0.lock().unwrap().clone()).unwrap()
        }
    }

    struct Closed;

    impl Write for Closed {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(std::io::ErrorKind::BrokenPipe.into())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    fn scratch(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("octant-console-{}-{name}", std::process::id()))
    }

    #[test]
    fn held_output_is_replayed_with_its_log_files() {
        let (one, two) = (scratch("one.log"), scratch("two.log"));
        let screen = Screen::default();
        let mut console = Console::on(Some(Box::new(screen.clone()))).held();
        console.open_log(&one, false).unwrap();
        console.echo(&["units lj".into()]);
        console.line("hello");
        console.open_log(&two, false).unwrap();
        console.set_echo(Echo::Screen);
        console.echo(&["run 1".into()]);
        console.log_only("quietly");
        assert!(screen.text().is_empty() && !one.exists() && !two.exists());
        console.release().unwrap();
        console.line("bye");
        console.flush();
        assert_eq!(screen.text(), "hello\nrun 1\nbye\n");
        assert_eq!(std::fs::read_to_string(&one).unwrap(), "units lj\nhello\n");
        assert_eq!(std::fs::read_to_string(&two).unwrap(), "quietly\nbye\n");
        console.open_log(&one, true).unwrap();
        console.line("again");
        console.close_log();
        console.line("to the screen");
        assert_eq!(std::fs::read_to_string(&one).unwrap(), "units lj\nhello\nagain\n");
        std::fs::remove_file(one).unwrap();
        std::fs::remove_file(two).unwrap();
    }

    #[test]
    fn warnings_wait_for_the_end_of_the_table() {
        let screen = Screen::default();
        let mut console = Console::on(Some(Box::new(screen.clone())));
        console.begin_table();
        console.line("row 1");
        console.warning("careful");
        console.line("row 2");
        console.end_table();
        console.warning("again");
        assert_eq!(screen.text(), "row 1\nrow 2\nWARNING: careful\nWARNING: again\n");
    }

    #[test]
    fn a_closed_screen_is_no_fault() {
        let mut console = Console::on(Some(Box::new(Closed)));
        console.line("nobody reads this");
        console.line("nor this");
        assert!(console.take_fault().is_none());
    }

    #[test]
    fn a_held_or_discarding_console_still_refuses_what_cannot_be_written() {
        let nowhere = scratch("no-such-folder").join("a.log");
        assert!(Console::discard().open_log(&nowhere, false).is_err());
        assert!(Console::on(None).held().open_log(&nowhere, true).is_err());
    }
}
