//! `octant run` and `octant check`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use super::{EngineArgs, PrecisionArg, ScriptArgs, radius, search};
use crate::Error;
use crate::engine::Precision;
use crate::neighbor::SearchPlan;
use crate::session::{self, OnError, Outcome, Settings};

/// Exit code of a program that Ctrl-C ended, as shells count it.
pub const INTERRUPTED: u8 = 130;

/// What `octant run --help` tells below the options.
pub const RUN_HELP: &str = "\
A run whose dynamics go wrong ends with exit code 1 and writes the last good state (the latest that has passed all checks, never
one from after a warning of energy or temperature) as a data file, which read_data takes; so does a run whose output or device
fails, and one that is interrupted (its last step).
A timestep that is too large is said in a warning: the fastest atom goes farther than half the skin, or too far for its
collisions; the total energy changes by more than 10 % of the kinetic energy beside what truncation does; the temperature jumps.";

#[derive(Args)]
pub struct RunArgs {
    #[command(flatten)]
    script: ScriptArgs,
    #[command(flatten)]
    engine: EngineArgs,
    /// Arithmetic: all f32; f64 positions and f32 pairs; all f64.
    #[arg(long, value_enum, default_value_t)]
    precision: PrecisionArg,
    /// Neighbor search, NAME or NAME:EDGE with the edge of its cells in neighbor cutoffs; all give the same pairs. NAME: trimmed,
    /// octant (edges of at least 2), midplane (octant, less cells that are out of reach), standard, brute. With +zorder cells lie
    /// along a Z-order curve in memory, with +rows row after row on a GPU too, with +radix particles are sorted by radix.
    #[arg(long, value_name = "NAME[:EDGE][+..]", default_value_t, value_parser = search)]
    search: SearchPlan,
    /// Log file.
    #[arg(long, value_name = "FILE", default_value = "log.octant")]
    log: PathBuf,
    /// Write a report of the run as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Print what the engine was specialized to and what it left out.
    #[arg(long)]
    explain: bool,
    /// Nothing on the screen; the log is written all the same.
    #[arg(long, short)]
    quiet: bool,
    /// What is kept of the particles, in last-good.data beside the log: on a stop the last good state; with checkpoint good
    /// states on the way as well, for a kill or a power failure.
    #[arg(long, value_enum, default_value_t)]
    on_error: OnErrorArg,
    /// Wall seconds between two checkpoints; longer where they would take more than a twentieth of the time.
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = radius)]
    checkpoint_every: f64,
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum OnErrorArg {
    #[default]
    Stop,
    Checkpoint,
}

impl RunArgs {
    fn settings(self) -> (PathBuf, Settings) {
        let settings = Settings {
            variables: self.script.variables,
            precision: Precision::ALL[self.precision as usize],
            search: self.search,
            log: Some(self.log),
            json: self.json,
            explain: self.explain,
            quiet: self.quiet,
            on_error: match self.on_error {
                OnErrorArg::Stop => OnError::Stop,
                OnErrorArg::Checkpoint => OnError::Checkpoint { seconds: self.checkpoint_every },
            },
            ..self.engine.settings()
        };
        (self.script.script, settings)
    }
}

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
