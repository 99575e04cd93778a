//! The progress bar of a run: steps done, rate, time left; on standard error, and only where that is a terminal.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::Console;

/// Redraws are no more frequent than this, so that short steps do not wait for the terminal.
const REDRAW_EVERY: Duration = Duration::from_millis(100);

/// Shows how far a run is. Does nothing in a pipe.
pub struct Progress {
    bar: Option<ProgressBar>,
    atoms: usize,
    first: i64,
    started: Instant,
    drawn: Instant,
}

impl Progress {
    /// Begins a run from step `first` to `last`; the console will keep its lines apart from the bar.
    pub fn start(first: i64, last: i64, atoms: usize, quiet: bool, console: &mut Console) -> Self {
        let started = Instant::now();
        let shows = !quiet && last > first && std::io::stderr().is_terminal();
        let bar = shows.then(|| {
            let steps = u64::try_from(last.saturating_sub(first)).unwrap_or(0);
            let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::stderr());
            // A template that indicatif does not like leaves its own style, which does as well.
            if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} steps  {msg}  {eta} left") {
                bar.set_style(style);
            }
            bar
        });
        console.set_bar(bar.clone());
        Self { bar, atoms, first, started, drawn: started }
    }

    /// True where there is a bar to keep up to date.
    pub fn is_shown(&self) -> bool {
        self.bar.is_some()
    }

    /// The run has reached a step. Cheap enough for every step.
    pub fn reach(&mut self, step: i64) {
        let Some(bar) = &self.bar else { return };
        let now = Instant::now();
        if now.duration_since(self.drawn) < REDRAW_EVERY {
            return;
        }
        self.drawn = now;
        let done = step.saturating_sub(self.first);
        bar.set_message(rate_text(done, now.duration_since(self.started), self.atoms));
        bar.set_position(u64::try_from(done).unwrap_or(0));
    }

    /// The run is over: takes the bar away.
    pub fn finish(&mut self, console: &mut Console) {
        console.set_bar(None);
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

/// Steps and millions of atom steps a second.
fn rate_text(steps: i64, elapsed: Duration, atoms: usize) -> String {
    let seconds = elapsed.as_secs_f64();
    let rate = if seconds > 0.0 { steps as f64 / seconds } else { 0.0 };
    format!("{rate:.1} steps/s  {:.2} M atom-steps/s", rate * atoms as f64 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_of_a_run() {
        assert_eq!(rate_text(100, Duration::from_millis(2500), 32_000), "40.0 steps/s  1.28 M atom-steps/s");
        assert_eq!(rate_text(0, Duration::ZERO, 5), "0.0 steps/s  0.00 M atom-steps/s");
    }

    #[test]
    fn a_run_without_a_terminal_has_no_bar() {
        let mut console = Console::discard();
        let mut progress = Progress::start(0, 100, 10, true, &mut console);
        progress.reach(50);
        assert!(!progress.is_shown());
        progress.finish(&mut console);
    }
}
