//! `octant run` and `octant check`.

use std::process::ExitCode;

use super::{RunArgs, ScriptArgs};
use crate::Error;
use crate::session::{self, Outcome, Settings};

/// Exit code of a program that Ctrl-C ended, as shells count it.
pub const INTERRUPTED: u8 = 130;

/// Runs a script.
pub fn run(args: RunArgs) -> Result<ExitCode, Error> {
    let (script, settings) = args.settings();
    session::stop_on_interrupt(INTERRUPTED.into())?;
    Ok(match session::run(&script, &settings)? {
        Outcome::Finished => ExitCode::SUCCESS,
        Outcome::Interrupted => INTERRUPTED.into(),
    })
}

/// Judges a script.
pub fn check(args: ScriptArgs) -> Result<ExitCode, Error> {
    let settings = Settings { variables: args.variables, ..Settings::default() };
    let summary = session::check(&args.script, &settings)?;
    say!("{}: {summary}", args.script.display());
    Ok(ExitCode::SUCCESS)
}
