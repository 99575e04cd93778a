//! One command of a script after substitution: its words, each with its place in the source.

use std::sync::Arc;

use super::source::{InputError, Source, Span};

/// A word of a command: text after quotes and `$` substitutions, and where it stands in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Word {
    pub text: String,
    pub span: Span,
}

/// One command line, `words[0]` being the command's name. Never empty.
#[derive(Clone, Debug)]
pub struct Statement {
    pub source: Arc<Source>,
    pub words: Vec<Word>,
    /// Lines for the log, as LAMMPS echoes them: the line as typed, then, where a `$` was substituted, as it became.
    pub echo: Vec<String>,
    /// Some substituted text came from a value that is not known before the script runs (a judging pass filled in a stand-in).
    pub tentative: bool,
}

/// What is wrong with word `word` of a statement (0 is the command itself).
/// Code that knows no source text returns this; [`Statement::complain`] gives it its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Complaint {
    pub word: usize,
    pub message: String,
    pub help: Option<String>,
}

impl Complaint {
    pub fn new(word: usize, message: impl Into<String>) -> Self {
        Self { word, message: message.into(), help: None }
    }

    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl Statement {
    /// The command's name.
    pub fn name(&self) -> &str {
        &self.words[0].text
    }

    /// Turns a complaint into an error that points at the word.
    pub fn complain(&self, complaint: Complaint) -> InputError {
        let word = &self.words[complaint.word.min(self.words.len() - 1)];
        let mut error = InputError::new(&self.source, word.span, format!("{}: {}", self.name(), complaint.message));
        error.help = complaint.help;
        error
    }

    /// Where it stands, as `file:line`.
    pub fn place(&self) -> String {
        let (line, _) = self.source.line_column(self.words[0].span.start);
        format!("{}:{line}", self.source.name)
    }

    /// Reads the arguments from word `next` on.
    pub fn args_from(&self, next: usize) -> Args<'_> {
        Args { words: &self.words, next }
    }

    /// Reads the arguments one after another.
    pub fn args(&self) -> Args<'_> {
        Args { words: &self.words, next: 1 }
    }
}

/// A cursor over a command's arguments; every getter says what it wants, so that errors can.
#[derive(Clone, Debug)]
pub struct Args<'a> {
    words: &'a [Word],
    next: usize,
}

/// A name that the scene will look up later, with the index of its word for complaints.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    pub text: String,
    pub word: usize,
}

impl<'a> Args<'a> {
    /// Words not yet read.
    pub fn left(&self) -> usize {
        self.words.len() - self.next
    }

    /// Index of the next word in the statement (for complaints).
    pub fn position(&self) -> usize {
        self.next
    }

    pub fn peek(&self) -> Option<&'a str> {
        self.words.get(self.next).map(|w| w.text.as_str())
    }

    /// The next word as text; `what` names it, such as "a region name".
    pub fn text(&mut self, what: &str) -> Result<&'a str, Complaint> {
        let Some(word) = self.words.get(self.next) else {
            return Err(Complaint::new(self.next - 1, format!("expected {what}, got the end of the line")));
        };
        self.next += 1;
        Ok(&word.text)
    }

    /// The next word as a name to be looked up later.
    pub fn name(&mut self, what: &str) -> Result<Name, Complaint> {
        let word = self.next;
        Ok(Name { text: self.text(what)?.to_string(), word })
    }

    /// A finite number.
    pub fn number(&mut self, what: &str) -> Result<f64, Complaint> {
        let word = self.next;
        let text = self.text(what)?;
        match parse_number(text) {
            Some(x) if x.is_finite() => Ok(x),
            Some(_) => Err(Complaint::new(word, format!("expected {what}, a finite number, got '{text}'"))),
            None => Err(Complaint::new(word, format!("expected {what}, a number, got '{text}'"))),
        }
    }

    /// A finite number that `ok` accepts; `bound` says which those are, such as "above 0".
    pub fn number_where(&mut self, what: &str, bound: &str, ok: impl Fn(f64) -> bool) -> Result<f64, Complaint> {
        let word = self.next;
        let x = self.number(what)?;
        if ok(x) {
            Ok(x)
        } else {
            Err(Complaint::new(word, format!("expected {what} {bound}, got '{}'", self.words[word].text)))
        }
    }

    /// A whole number of at least `least`.
    pub fn integer(&mut self, what: &str, least: i64) -> Result<i64, Complaint> {
        let word = self.next;
        let text = self.text(what)?;
        match text.parse::<i64>() {
            Ok(n) if n >= least => Ok(n),
            Ok(_) => Err(Complaint::new(word, format!("expected {what}, at least {least}, got '{text}'"))),
            Err(_) => Err(Complaint::new(word, format!("expected {what}, a whole number, got '{text}'"))),
        }
    }

    /// `yes`/`no` (also on/off, true/false, as LAMMPS takes them).
    pub fn yes_no(&mut self, what: &str) -> Result<bool, Complaint> {
        let word = self.next;
        match self.text(what)? {
            "yes" | "on" | "true" => Ok(true),
            "no" | "off" | "false" => Ok(false),
            other => Err(Complaint::new(word, format!("expected {what}, yes or no, got '{other}'"))),
        }
    }

    /// One of a fixed set of words, by index into `choices`.
    pub fn choice(&mut self, what: &str, choices: &[&str]) -> Result<usize, Complaint> {
        let word = self.next;
        let text = self.text(what)?;
        choices.iter().position(|c| *c == text).ok_or_else(|| {
            Complaint::new(word, format!("expected {what}, one of {}, got '{text}'", choices.join(", ")))
        })
    }

    /// Errors when words are left over.
    pub fn done(&self) -> Result<(), Complaint> {
        match self.words.get(self.next) {
            None => Ok(()),
            Some(w) => Err(Complaint::new(self.next, format!("expected the end of the line, got '{}'", w.text))),
        }
    }
}

/// A number as LAMMPS reads one: Rust's grammar less the words (`inf`, `nan` parse, so that callers can say "not finite").
pub fn parse_number(text: &str) -> Option<f64> {
    text.parse::<f64>().ok()
}
