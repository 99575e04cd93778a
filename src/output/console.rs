//! Screen and log file.

/// Writes lines to the screen and to the log file.
#[derive(Debug, Default)]
pub struct Console;

impl Console {
    /// A line for both.
    pub fn line(&mut self, text: &str) {
        println!("{text}");
    }
}
