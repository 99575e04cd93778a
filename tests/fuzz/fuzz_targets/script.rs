//! Any text goes through lines, substitution, formulas and command parsers without a panic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use octant::script::{Command, Interpreter, NoSimulation, Source};

/// Statements read before a script that jumps in circles is given up.
const ENOUGH: usize = 200;

fuzz_target!(|text: &str| {
    let presets = [("x".to_string(), "1 2".to_string())];
    let Ok(mut script) = Interpreter::new(Source::new("fuzz", text), &presets) else { return };
    for _ in 0..ENOUGH {
        let Ok(Some(statement)) = script.next(&mut NoSimulation) else { return };
        if let Err(complaint) = Command::parse(&statement) {
            let _ = statement.complain(complaint).to_string();
        }
    }
});
