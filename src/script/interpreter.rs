//! A script as a stream of commands: `variable`, `next`, `label`, `jump` and `if` are carried out here, all others handed on.

use std::collections::VecDeque;
use std::sync::Arc;

use super::condition;
use super::environment::{Environment, Quantity};
use super::formula::evaluate::LookupError;
use super::lexer::{Token, logical_lines, split_words, strip_comment};
use super::mapped::Mapped;
use super::source::{InputError, Source, Span};
use super::statement::{Complaint, Statement, Word};
use super::substitute::{Substituted, substitute};
use super::variables::Variables;

/// Lines carried out between two commands for the simulation before we say that the script runs in a circle.
const LONGEST_SILENCE: usize = 1_000_000;

/// Reads a script command by command, its variables evaluated as it goes.
#[derive(Clone, Debug)]
pub struct Interpreter {
    source: Arc<Source>,
    lines: Arc<Vec<Mapped>>,
    next_line: usize,
    /// Commands of an `if` still to be carried out, before the next line.
    queue: VecDeque<Queued>,
    variables: Variables,
    /// A loop has come to its end: the next `jump` does nothing.
    skip_jump: bool,
    echo: Vec<String>,
}

/// A command of an `if`.
#[derive(Clone, Debug)]
struct Queued {
    line: Mapped,
    /// False if it is not known whether the simulation will come here.
    known: bool,
}

/// A line ready to be carried out.
struct Line {
    words: Vec<Token>,
    known: bool,
    /// False if an `if` with an unknown condition led here.
    reached: bool,
}

impl Interpreter {
    /// Starts at the top of a script. `presets` are index variables from the command line, which the script's own `variable NAME
    /// index` does not override; a value may hold several words.
    ///
    /// # Errors
    /// A preset's name or value is not one.
    pub fn new(source: Arc<Source>, presets: &[(String, String)]) -> Result<Self, InputError> {
        let mut variables = Variables::default();
        for (name, value) in presets {
            variables.preset(name, value).map_err(|message| {
                let text = format!("-v {name}={value}");
                let span = Span::new(3, text.len());
                InputError::new(&Source::new("command line", text), span, message)
            })?;
        }
        let lines = Arc::new(logical_lines(&source));
        Ok(Self { source, lines, next_line: 0, queue: VecDeque::new(), variables, skip_jump: false, echo: Vec::new() })
    }

    /// The next command for the simulation, its `$` values filled in; `None` at the end of the script.
    pub fn next(&mut self, environment: &mut dyn Environment) -> Result<Option<Statement>, InputError> {
        for _ in 0..LONGEST_SILENCE {
            let queued = match self.queue.pop_front() {
                Some(queued) => queued,
                None => match self.lines.get(self.next_line) {
                    Some(line) => {
                        self.next_line += 1;
                        Queued { line: line.clone(), known: true }
                    }
                    None => return Ok(None),
                },
            };
            let line = self.read(&queued, environment)?;
            let Some(name) = line.words.first().map(|w| w.text.text().to_string()) else { continue };
            match name.as_str() {
                "variable" => self.variable(line, environment)?,
                "next" => {
                    let result = self.variables.next(&line.words);
                    self.skip_jump |= result.map_err(|c| self.statement(&line).complain(c))?;
                }
                "label" => self.one_word(&line, "a label")?,
                "jump" => self.jump(&line)?,
                "if" => self.condition(&line, environment)?,
                _ => {
                    let line = if name == "print" { self.fill_in(line, 1, false, environment)? } else { line };
                    let mut statement = self.statement(&line);
                    statement.echo = std::mem::take(&mut self.echo);
                    return Ok(Some(statement));
                }
            }
        }
        let place = self.lines.get(self.next_line.saturating_sub(1)).map(Mapped::whole).unwrap_or_default();
        let message = format!("expected a command for the simulation, got {LONGEST_SILENCE} lines without one");
        Err(InputError::new(&self.source, place, message).with_help("does a jump lead back to its label for ever?"))
    }

    /// Lines for the log that no statement has carried, such as comments at the end of the file.
    pub fn trailing_echo(&mut self) -> Vec<String> {
        std::mem::take(&mut self.echo)
    }

    /// Number of variable `name`, at full precision (thermo column `v_name`, fixes that take variables).
    pub fn variable_value(&mut self, name: &str, environment: &mut dyn Environment) -> Result<Quantity, String> {
        match self.variables.value(name, environment) {
            Ok(Some(quantity)) => Ok(quantity),
            Ok(None) => Err(format!("undefined variable '{name}'")),
            Err(LookupError::Here(message)) => Err(message),
            Err(LookupError::Placed(error)) => {
                Err(InputError::new(&self.source, error.span, error.to_string()).to_string())
            }
        }
    }

    pub fn has_variable(&self, name: &str) -> bool {
        self.variables.has(name)
    }

    /// Comment off, values in, words apart; every stage of the line goes to the echo.
    fn read(&mut self, queued: &Queued, environment: &mut dyn Environment) -> Result<Line, InputError> {
        self.echo.push(queued.line.text().to_string());
        let line = strip_comment(&self.source, &queued.line)?;
        let echo = &mut self.echo;
        let Substituted { text, known } =
            substitute(&self.source, &line, &mut self.variables, environment, |step| echo.push(step))?;
        Ok(Line { words: split_words(&self.source, &text)?, known: known && queued.known, reached: queued.known })
    }

    /// Fills in the values of word `index`, which kept its `$` because of quotes.
    fn fill_in(
        &mut self,
        mut line: Line,
        index: usize,
        echoed: bool,
        environment: &mut dyn Environment,
    ) -> Result<Line, InputError> {
        if let Some(word) = line.words.get_mut(index) {
            let echo = &mut self.echo;
            let filled = substitute(&self.source, &word.text, &mut self.variables, environment, |step| {
                if echoed {
                    echo.push(step);
                }
            })?;
            word.text = filled.text;
            line.known &= filled.known;
        }
        Ok(line)
    }

    fn statement(&self, line: &Line) -> Statement {
        let words = line.words.iter().map(|w| Word { text: w.text.text().to_string(), span: w.span }).collect();
        Statement { source: self.source.clone(), words, echo: Vec::new(), tentative: !line.known }
    }

    fn complain(&self, line: &Line, word: usize, message: impl Into<String>) -> InputError {
        self.statement(line).complain(Complaint::new(word, message))
    }

    fn variable(&mut self, line: Line, environment: &mut dyn Environment) -> Result<(), InputError> {
        let is_string = line.words.get(2).is_some_and(|w| w.text.text() == "string");
        let line = if is_string { self.fill_in(line, 3, true, environment)? } else { line };
        self.variables.define(&line.words, line.known).map_err(|c| self.statement(&line).complain(c))
    }

    fn one_word(&self, line: &Line, what: &str) -> Result<(), InputError> {
        match line.words.get(2) {
            _ if line.words.len() < 2 => {
                Err(self.complain(line, 0, format!("expected {what}, got the end of the line")))
            }
            Some(extra) => {
                Err(self.complain(line, 2, format!("expected the end of the line, got '{}'", extra.text.text())))
            }
            None => Ok(()),
        }
    }

    /// `jump SELF [label]`. Lines on the way are skipped unread, as in LAMMPS.
    fn jump(&mut self, line: &Line) -> Result<(), InputError> {
        let Some(file) = line.words.get(1) else {
            return Err(self.complain(line, 0, "expected SELF and a label, got the end of the line"));
        };
        if file.text.text() != "SELF" {
            let message =
                format!("expected SELF, got '{}': jumps into other files are not part of octant", file.text.text());
            return Err(self.complain(line, 1, message));
        }
        if let Some(extra) = line.words.get(3) {
            return Err(self.complain(line, 3, format!("expected the end of the line, got '{}'", extra.text.text())));
        }
        if std::mem::take(&mut self.skip_jump) {
            return Ok(());
        }
        let target = match line.words.get(2) {
            None => 0,
            Some(label) => match self.find_label(label.text.text())? {
                Some(target) => target,
                None => {
                    let message = format!("expected a label of this script, got '{}'", label.text.text());
                    return Err(self.complain(line, 2, message));
                }
            },
        };
        // Where an unknown condition led here, a jump might never be left again: go on with the next line instead.
        if line.reached {
            self.next_line = target;
            self.queue.clear();
        }
        Ok(())
    }

    /// Index of the line after the first `label NAME`.
    fn find_label(&self, name: &str) -> Result<Option<usize>, InputError> {
        for (k, line) in self.lines.iter().enumerate() {
            if line.text().trim_start().starts_with("label") {
                let words = split_words(&self.source, &strip_comment(&self.source, line)?)?;
                if let [command, label] = words.as_slice()
                    && command.text.text() == "label"
                    && label.text.text() == name
                {
                    return Ok(Some(k + 1));
                }
            }
        }
        Ok(None)
    }

    /// `if CONDITION then COMMAND... [elif CONDITION COMMAND...]... [else COMMAND...]`
    fn condition(&mut self, line: &Line, environment: &mut dyn Environment) -> Result<(), InputError> {
        let text = |k: usize| line.words.get(k).map(|w| w.text.text());
        match text(2) {
            Some("then") if line.words.len() > 3 => (),
            Some("then") => {
                return Err(self.complain(line, 2, "expected a command after then, got the end of the line"));
            }
            Some(other) => return Err(self.complain(line, 2, format!("expected then, got '{other}'"))),
            None => {
                let what = if line.words.len() < 2 { "a condition" } else { "then" };
                return Err(self.complain(
                    line,
                    line.words.len() - 1,
                    format!("expected {what}, got the end of the line"),
                ));
            }
        }
        let mut known = line.known;
        let (mut condition, mut first) = (Some(1), 3);
        loop {
            let end = (first..line.words.len()).find(|k| matches!(text(*k), Some("elif" | "else")));
            let chosen = match condition.and_then(|k| line.words.get(k)) {
                None => true,
                Some(word) => {
                    let filled = substitute(&self.source, &word.text, &mut self.variables, environment, |_| ())?;
                    known &= filled.known;
                    condition::holds(filled.text.text()).map_err(|error| {
                        let error = error.place(&filled.text);
                        InputError::new(&self.source, error.span, format!("if: {}", error.message))
                    })?
                }
            };
            if chosen {
                return self.enqueue(line, first..end.unwrap_or(line.words.len()), known);
            }
            match end {
                None => return Ok(()),
                Some(k) if text(k) == Some("else") => (condition, first) = (None, k + 1),
                Some(k) if k + 1 < line.words.len() => (condition, first) = (Some(k + 1), k + 2),
                Some(k) => {
                    return Err(self.complain(line, k, "expected a condition after elif, got the end of the line"));
                }
            }
        }
    }

    /// Puts commands of an `if` before all that is still to come.
    fn enqueue(&mut self, line: &Line, range: std::ops::Range<usize>, known: bool) -> Result<(), InputError> {
        for k in range.rev() {
            let Some(word) = line.words.get(k) else { continue };
            if word.text.text().is_empty() {
                return Err(self.complain(line, k, "expected a command, got empty quotes"));
            }
            self.queue.push_front(Queued { line: word.text.clone(), known });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::NoSimulation;

    /// Runs a script; its log as LAMMPS writes it: echoed lines, and what `print` prints.
    fn log(text: &str, presets: &[(String, String)]) -> Result<Vec<String>, String> {
        let mut script = Interpreter::new(Source::new("in", text), presets).map_err(|e| e.to_string())?;
        let mut lines = Vec::new();
        while let Some(statement) = script.next(&mut NoSimulation).map_err(|e| e.to_string())? {
            lines.extend(statement.echo.clone());
            if statement.name() == "print" {
                lines.push(statement.words[1].text.clone());
            }
        }
        lines.extend(script.trailing_echo());
        Ok(lines)
    }

    /// Log of LAMMPS 22Jul2025 for the same lines.
    #[test]
    fn echo_is_that_of_lammps() {
        let script = "# start $x\nvariable x index 7 8\nprint \"x is $x\" # c\n\ngroup $x$x type ${x}\n\
                      variable s string \"a $(1+1) $x\"\nif \"$x > 4\" then \"print 's ${s}'\" \"variable y equal $x*2\"\n\
                      print ${y}\n# end";
        let expected = [
            "# start $x",
            "variable x index 7 8",
            "print \"x is $x\" # c",
            "x is 7",
            "",
            "group $x$x type ${x}",
            "group 7$x type ${x}",
            "group 77 type ${x}",
            "group 77 type 7",
            "variable s string \"a $(1+1) $x\"",
            "a 2 $x",
            "a 2 7",
            "if \"$x > 4\" then \"print 's ${s}'\" \"variable y equal $x*2\"",
            "print 's ${s}'",
            "s a 2 7",
            "variable y equal $x*2",
            "variable y equal 7*2",
            "print ${y}",
            "print 14",
            "14",
            "# end",
        ];
        assert_eq!(log(script, &[]).unwrap(), expected);
    }

    #[test]
    fn loops_end_where_lammps_ends_them() {
        let script = "variable i loop 3 9 pad\nlabel here # again\nprint 'i $i'\nif \"$i == 5\" then \"jump SELF out\" \"print no\"\n\
                      next i\njump SELF here\nlabel out\nvariable i delete\nvariable j index a b\nlabel top\nprint $j\nnext j\njump SELF top\n";
        let printed: Vec<String> = log(script, &[]).unwrap().into_iter().filter(|l| !l.contains(['$', ' '])).collect();
        assert_eq!(printed, ["a", "b"]);
        let rounds = log(script, &[]).unwrap().into_iter().filter(|l| l.starts_with("i ")).collect::<Vec<_>>();
        assert_eq!(rounds, ["i 3", "i 4", "i 5"]);
        // A loop that has run out takes its variable along; the jump after it does nothing, once.
        let script = "variable i index 1\nnext i\njump SELF\nprint done\njump SELF nowhere";
        assert_eq!(log(script, &[]).unwrap_err(), "in:5:11: jump: expected a label of this script, got 'nowhere'");
        assert!(log("label a\njump SELF a", &[]).unwrap_err().contains("lines without one"));
    }

    #[test]
    fn branches_are_chosen_as_in_lammps() {
        let script =
            "if '1>2' then 'print a' elif 2>1 'print b' 'print c' else 'print d'\nif 0 then 'print e' else 'print f'";
        let printed: Vec<String> = log(script, &[]).unwrap().into_iter().filter(|l| l.len() == 1).collect();
        assert_eq!(printed, ["b", "c", "f"]);
        let error = |text| log(text, &[]).unwrap_err();
        assert_eq!(error("if 1 thn 'print a'"), "in:1:6: if: expected then, got 'thn'");
        assert_eq!(
            error("if 'a == $(1+1)' then 'print a'"),
            "in:1:5: if: expected two numbers or two words to compare, got a number and 'a'"
        );
        assert_eq!(error("if 1 then 'print \"$(2*(1/0))\"'"), "in:1:23: formula: division by zero");
    }

    #[test]
    fn presets_win_over_index_variables_only() {
        let preset = |name: &str, value: &str| vec![(name.to_string(), value.to_string())];
        let printed = log("variable n index 5\nprint '${n}'\nnext n\nprint $n", &preset("n", "10 20")).unwrap();
        assert_eq!((printed[2].as_str(), printed.last().unwrap().as_str()), ("10", "20"));
        assert!(log("variable n equal 5", &preset("n", "1")).unwrap_err().contains("variable n has style index"));
        let wrong = Interpreter::new(Source::new("in", ""), &preset("a-b", "1")).unwrap_err();
        assert!(wrong.to_string().starts_with("command line:1:4: expected a variable name"), "{wrong}");
    }

    #[test]
    fn words_point_at_what_was_typed() {
        let source = Source::new("in", "variable n index '10 every'\nrun  ${n} 'a b' &\n $(1+1)");
        let mut script = Interpreter::new(source.clone(), &[]).unwrap();
        let statement = script.next(&mut NoSimulation).unwrap().unwrap();
        let words: Vec<(&str, &str)> =
            statement.words.iter().map(|w| (w.text.as_str(), &source.text[w.span.start..w.span.end])).collect();
        let expected = [("run", "run"), ("10", "${n}"), ("every", "${n}"), ("a b", "'a b'"), ("2", "$(1+1)")];
        assert_eq!(words, expected);
    }
}
