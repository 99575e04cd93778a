//! A data file as lines of words, each with its place.

use std::str::{FromStr, SplitAsciiWhitespace};
use std::sync::Arc;

use crate::script::{InputError, Source, Span, Word};

/// A line without its comment.
#[derive(Clone, Copy, Debug)]
pub struct Line<'a> {
    /// Text before `#`, trimmed.
    pub text: &'a str,
    /// Text after `#`, trimmed.
    pub comment: Option<&'a str>,
}

/// A cursor over the lines that are not blank.
#[derive(Clone, Debug)]
pub struct Lines<'a> {
    pub source: &'a Arc<Source>,
    rest: std::str::Lines<'a>,
}

impl<'a> Lines<'a> {
    pub fn new(source: &'a Arc<Source>) -> Self {
        Self { source, rest: source.text.lines() }
    }

    /// The first line, which is a title and means nothing.
    pub fn title(&mut self) -> Option<Line<'a>> {
        self.rest.next().map(split_comment)
    }

    /// The next line that says something.
    pub fn next(&mut self) -> Option<Line<'a>> {
        self.rest.by_ref().map(split_comment).find(|line| !line.text.is_empty())
    }

    /// The place of a piece of the file's text.
    pub fn span(&self, piece: &str) -> Span {
        let start = (piece.as_ptr() as usize).saturating_sub(self.source.text.as_ptr() as usize);
        Span::new(start, start + piece.len())
    }

    pub fn word(&self, piece: &str) -> Word {
        Word { text: piece.to_string(), span: self.span(piece) }
    }

    /// An error at a piece of the text.
    pub fn error(&self, piece: &str, message: String) -> InputError {
        InputError::new(self.source, self.span(piece), message)
    }

    /// An error at the end of the file.
    pub fn error_at_end(&self, message: String) -> InputError {
        let end = self.source.text.trim_end().len();
        InputError::new(self.source, Span::new(end, end), message)
    }

    /// The words of a line of a section, to be read one after another.
    pub fn fields(&self, section: &'a str, line: Line<'a>) -> Fields<'a, '_> {
        Fields { lines: self, section, line: line.text, words: line.text.split_ascii_whitespace() }
    }
}

fn split_comment(line: &str) -> Line<'_> {
    match line.split_once('#') {
        Some((text, comment)) => Line { text: text.trim(), comment: Some(comment.trim()) },
        None => Line { text: line.trim(), comment: None },
    }
}

/// The words of one line; every getter says what it wants, so that errors can.
pub struct Fields<'a, 'l> {
    lines: &'l Lines<'a>,
    section: &'a str,
    line: &'a str,
    words: SplitAsciiWhitespace<'a>,
}

impl<'a> Fields<'a, '_> {
    pub fn error(&self, piece: &str, message: String) -> InputError {
        self.lines.error(piece, format!("{}: {message}", self.section))
    }

    pub fn text(&mut self, what: &str) -> Result<&'a str, InputError> {
        self.words.next().ok_or_else(|| {
            let last = self.line.split_ascii_whitespace().next_back().unwrap_or(self.line);
            self.error(last, format!("expected {what} after '{last}', got the end of the line"))
        })
    }

    /// A whole number from `least` to `most`.
    pub fn integer<T: FromStr + PartialOrd + std::fmt::Display>(
        &mut self,
        what: &str,
        least: T,
        most: T,
    ) -> Result<(T, &'a str), InputError> {
        let text = self.text(what)?;
        match text.parse::<T>() {
            Ok(n) if n >= least && n <= most => Ok((n, text)),
            _ => Err(self.error(text, format!("expected {what}, a whole number from {least} to {most}, got '{text}'"))),
        }
    }

    /// A finite number.
    pub fn number(&mut self, what: &str) -> Result<(f64, &'a str), InputError> {
        let text = self.text(what)?;
        match text.parse::<f64>() {
            Ok(x) if x.is_finite() => Ok((x, text)),
            Ok(_) => Err(self.error(text, format!("expected {what}, a finite number, got '{text}'"))),
            Err(_) => Err(self.error(text, format!("expected {what}, a number, got '{text}'"))),
        }
    }

    /// The words not yet read.
    pub fn rest(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.words.clone()
    }

    pub fn done(&mut self) -> Result<(), InputError> {
        match self.words.next() {
            None => Ok(()),
            Some(word) => Err(self.error(word, format!("expected the end of the line, got '{word}'"))),
        }
    }
}
