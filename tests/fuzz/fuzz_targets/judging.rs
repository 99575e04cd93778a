//! Any text is judged as a whole script without a panic: variables, scene, output and runs on paper.
#![no_main]

use libfuzzer_sys::fuzz_target;
use octant::session::{Settings, check_text};

fuzz_target!(|text: &str| {
    if let Err(error) = check_text("fuzz", text, &Settings::default()) {
        let _ = error.to_string();
    }
});
