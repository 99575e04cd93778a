//! `octant report`.

use std::io::IsTerminal;
use std::process::ExitCode;
use std::time::Instant;

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::ReportArgs;
use super::run::INTERRUPTED;
use crate::Error;
use crate::bench::Ended;
use crate::engine::Precision;
use crate::report::{self, Options, Said};
use crate::session::{self, Settings};

/// Steps of the bar, whatever the work.
const TICKS: u64 = 1000;

/// Studies a scene; shows on standard error how far it is, where that is a terminal.
pub fn report(args: ReportArgs) -> Result<ExitCode, Error> {
    let mut precisions: Vec<Precision> = Vec::new();
    for precision in args.precision.iter().map(|p| Precision::ALL[*p as usize]) {
        if !precisions.contains(&precision) {
            precisions.push(precision);
        }
    }
    let settings = Settings { variables: args.script.variables, quiet: true, ..args.engine.settings() };
    let options = Options {
        script: args.script.script,
        settings,
        precisions,
        dts: args.dt,
        skins: args.skin,
        reference: args.reference,
        quick: args.quick,
        out: args.out,
        python: args.python,
    };
    session::stop_on_interrupt(INTERRUPTED.into())?;
    let bar = bar();
    let started = Instant::now();
    let ended = report::run(&options, &mut |said| match said {
        Said::Note(note) => {
            bar.suspend(|| {
                say!("{note}");
            });
        }
        Said::Advice(advice) => {
            bar.suspend(|| {
                say!("{advice}");
            });
        }
        Said::Progress { done, all, work: (spent, work), next } => {
            bar.set_position((TICKS as f64 * spent / work.max(1.0)) as u64);
            // A rate is known as soon as something is done.
            let left = started.elapsed().mul_f64(if spent > 0.0 { (work - spent) / spent } else { 0.0 });
            let left = if spent > 0.0 { format!("{} left, ", HumanDuration(left)) } else { String::new() };
            bar.set_message(format!("{}/{all}  {left}{next}", done + 1));
            bar.tick();
        }
    });
    bar.finish_and_clear();
    let ended = ended?;
    if ended == Ended::Interrupted {
        say!("Interrupted: what is there so far is in {}; the same command goes on", options.out.display());
        return Ok(INTERRUPTED.into());
    }
    say!("Wrote {}", options.out.join("report.html").display());
    Ok(ExitCode::SUCCESS)
}

/// On standard error; hidden where that is no terminal.
fn bar() -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(TICKS), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {msg}") {
        bar.set_style(style);
    }
    bar
}
