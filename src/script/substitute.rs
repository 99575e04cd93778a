//! `$x`, `${x}`, `$(formula)` and `$(formula:%format)` in a line (doc page `Commands_parse`).

use std::sync::Arc;

use super::environment::Environment;
use super::formula::evaluate::LookupError;
use super::formula::{Looked, Lookup};
use super::lexer::QuoteTracker;
use super::mapped::Mapped;
use super::source::{InputError, Source, Span};
use super::variables::{Variables, format_value};
use crate::output::Printf;

/// Significant digits of `$(formula)`.
const IMMEDIATE_DIGITS: usize = 20;

/// A line with its values filled in.
#[derive(Clone, Debug)]
pub struct Substituted {
    pub text: Mapped,
    /// False if a value was only a stand-in.
    pub known: bool,
}

/// Replaces every `$` outside quotes, left to right, values being taken as they are. `echo` gets the whole line after each replacement.
pub fn substitute(
    source: &Arc<Source>,
    line: &Mapped,
    variables: &mut Variables,
    environment: &mut dyn Environment,
    mut echo: impl FnMut(String),
) -> Result<Substituted, InputError> {
    let text = line.text();
    let mut result = Substituted { text: Mapped::default(), known: true };
    let mut quotes = QuoteTracker::default();
    let (mut copied, mut at) = (0, 0);
    while at < text.len() {
        if quotes.is_open() || !text[at..].starts_with('$') {
            at += quotes.advance(text, at);
            continue;
        }
        let end =
            expression_end(text, at).map_err(|message| InputError::new(source, line.span(at..at + 1), message))?;
        let span = line.span(at..end);
        let Looked { text: value, known } = value_of(source, line, at, end, span, variables, environment)?;
        result.known &= known;
        result.text.append(&line.slice(copied..at));
        result.text.push_standing_for(&value, span);
        (copied, at) = (end, end);
        echo(format!("{}{}", result.text.text(), &text[end..]));
    }
    quotes.finish(source, line)?;
    result.text.append(&line.slice(copied..text.len()));
    Ok(result)
}

/// End of the `$` expression at `at`.
fn expression_end(text: &str, at: usize) -> Result<usize, String> {
    let rest = &text[at + 1..];
    match rest.chars().next() {
        None => Err("expected a variable name after $, got the end of the line".to_string()),
        Some('{') => match rest.find('}') {
            Some(k) => Ok(at + 1 + k + 1),
            None => Err("expected a closing '}' after ${, got the end of the line".to_string()),
        },
        Some('(') => {
            let mut depth = 0usize;
            for (k, c) in rest.char_indices() {
                match c {
                    '(' => depth += 1,
                    ')' if depth == 1 => return Ok(at + 1 + k + 1),
                    ')' => depth -= 1,
                    _ => (),
                }
            }
            Err("expected a closing ')' after $(, got the end of the line".to_string())
        }
        Some(c) => Ok(at + 1 + c.len_utf8()),
    }
}

/// Text that stands for the `$` expression from `at` to `end`.
fn value_of(
    source: &Arc<Source>,
    line: &Mapped,
    at: usize,
    end: usize,
    span: Span,
    variables: &mut Variables,
    environment: &mut dyn Environment,
) -> Result<Looked, InputError> {
    let text = line.text();
    if text[at + 1..].starts_with('(') {
        let inside = at + 2..end - 1;
        let format = text[inside.clone()].find(":%").map(|k| inside.start + k);
        let formula = line.slice(inside.start..format.unwrap_or(inside.end));
        let quantity = variables
            .immediate(&formula, environment)
            .map_err(|error| InputError::new(source, error.span, error.to_string()))?;
        let text = match format {
            None => format_value(quantity.value, IMMEDIATE_DIGITS),
            Some(k) => {
                let place = k + 1..inside.end;
                let format = number_format(&text[place.clone()])
                    .map_err(|message| InputError::new(source, line.span(place), message))?;
                format.float(quantity.value + 0.0)
            }
        };
        return Ok(Looked { text, known: quantity.known });
    }
    let name = if text[at + 1..].starts_with('{') { &text[at + 2..end - 1] } else { &text[at + 1..end] };
    match variables.look_up(name, environment, 0) {
        Ok(Some(looked)) => Ok(looked),
        Ok(None) => Err(InputError::new(source, span, format!("undefined variable '{name}'"))),
        Err(LookupError::Here(message)) => Err(InputError::new(source, span, message)),
        Err(LookupError::Placed(error)) => Err(InputError::new(source, error.span, error.to_string())),
    }
}

/// LAMMPS takes formats with a precision and one of `e f g` in `$(...)`, such as `%.3f` or `%8.4g`, and no flags but zero and blank.
fn number_format(format: &str) -> Result<Printf, String> {
    let expected = || format!("expected a format such as %.6g or %8.3f, got '{format}'");
    let width =
        format.strip_prefix('%').ok_or_else(expected)?.trim_start_matches(|c: char| c.is_ascii_digit() || c == ' ');
    let precision = width.strip_prefix('.').ok_or_else(expected)?;
    let conversion = precision.trim_start_matches(|c: char| c.is_ascii_digit());
    if conversion.len() == precision.len() || !conversion.starts_with(['e', 'f', 'g', 'E', 'F', 'G']) {
        return Err(expected());
    }
    Printf::parse(format)
}
