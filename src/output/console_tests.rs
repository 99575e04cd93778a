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
