//! `run`.

use crate::script::statement::{Args, Complaint};

/// `run N [upto] [start N] [stop N] [pre yes|no] [post yes|no]` (doc page `run`).
#[derive(Clone, Debug, PartialEq)]
pub struct RunCommand {
    /// Steps to run, or with `upto` the step to run to.
    pub steps: i64,
    pub upto: bool,
    /// First and last step that `ramp` and its like count from, if not this run's.
    pub start: Option<i64>,
    pub stop: Option<i64>,
    /// Set up anew before the first step.
    pub pre: bool,
    /// Print the timing breakdown at the end.
    pub post: bool,
}

impl RunCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let steps = args.integer("a number of steps", 0)?;
        let mut command = Self { steps, upto: false, start: None, stop: None, pre: true, post: true };
        while args.left() > 0 {
            let word = args.position();
            match args.choice("a keyword", &["upto", "start", "stop", "pre", "post", "every"])? {
                0 => command.upto = true,
                1 => command.start = Some(args.integer("a first step", 0)?),
                2 => command.stop = Some(args.integer("a last step", 0)?),
                3 => command.pre = args.yes_no("whether to set up before the run")?,
                4 => command.post = args.yes_no("whether to print the timing after the run")?,
                _ => {
                    let help = "a loop variable with next and jump does the same";
                    return Err(Complaint::new(word, "run every is not part of octant").with_help(help));
                }
            }
        }
        Ok(command)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Command, tests::parse};
    use super::*;

    #[test]
    fn keywords_and_their_limits() {
        let expected = RunCommand { steps: 500, upto: true, start: Some(10), stop: None, pre: false, post: true };
        assert_eq!(parse("run 500 upto pre no start 10"), Ok(Command::Run(expected)));
        let error = |line| parse(line).unwrap_err();
        assert!(error("run 10 every 5 NULL").starts_with("in:1:8: run: run every is not part of octant"));
        assert!(error("run -5").contains("expected a number of steps, at least 0, got '-5'"));
        assert!(error("run 1e3").contains("expected a number of steps, a whole number, got '1e3'"));
    }
}
