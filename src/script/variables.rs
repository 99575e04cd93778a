//! The `variable` and `next` commands (doc pages `variable`, `next`): what variables hold and how they change.

use std::collections::BTreeMap;

use super::environment::{Environment, Quantity};
use super::formula::evaluate::LookupError;
use super::formula::{Evaluator, Formula, FormulaError, Looked, Lookup};
use super::lexer::Token;
use super::mapped::Mapped;
use super::ranmar::RanMar;
use super::statement::{Complaint, parse_number};
use crate::output::printf::format_g;

/// Significant digits of `${name}` for an equal-style variable; also what `v_name` sees of it.
const EQUAL_DIGITS: usize = 15;

/// Styles LAMMPS has and octant lacks.
const FOREIGN_STYLES: [&str; 12] = [
    "world", "universe", "uloop", "getenv", "file", "atomfile", "format", "python", "timer", "internal", "atom",
    "vector",
];

/// What a variable holds.
#[derive(Clone, Debug)]
enum Variable {
    /// Strings, of which one is current.
    Index {
        values: Vec<String>,
        current: usize,
        known: bool,
    },
    /// Whole numbers from `now` to `last`, padded with zeros to `width`.
    Loop {
        now: i64,
        last: i64,
        width: usize,
    },
    Text {
        value: String,
        known: bool,
    },
    Equal {
        formula: Result<Formula, FormulaError>,
        known: bool,
        evaluating: bool,
    },
}

impl Variable {
    fn style(&self) -> &'static str {
        match self {
            Self::Index { .. } => "index",
            Self::Loop { .. } => "loop",
            Self::Text { .. } => "string",
            Self::Equal { .. } => "equal",
        }
    }
}

/// All variables of a script, and the random stream its formulas share.
#[derive(Clone, Debug, Default)]
pub struct Variables {
    variables: BTreeMap<String, Variable>,
    random: Option<RanMar>,
}

impl Variables {
    pub fn has(&self, name: &str) -> bool {
        self.variables.contains_key(name)
    }

    /// Presets an index variable from the command line; an earlier one of that name stays. The error says what is wrong with the name.
    pub fn preset(&mut self, name: &str, value: &str) -> Result<(), String> {
        check_name(name)?;
        let values: Vec<String> = value.split_whitespace().map(str::to_string).collect();
        if values.is_empty() {
            return Err(format!("expected a value for variable {name}, got nothing"));
        }
        self.variables.entry(name.to_string()).or_insert(Variable::Index { values, current: 0, known: true });
        Ok(())
    }

    /// Carries out `variable NAME STYLE ...`; `words[0]` is the command. Text for a string variable comes substituted.
    /// `known` is false if a substituted value was only a stand-in.
    pub fn define(&mut self, words: &[Token], known: bool) -> Result<(), Complaint> {
        let word = |k: usize| words.get(k).map(|w| w.text.text());
        let missing = |what: &str| {
            Complaint::new(words.len().saturating_sub(1), format!("expected {what}, got the end of the line"))
        };
        let name = word(1).ok_or_else(|| missing("a variable name"))?;
        let style = word(2).ok_or_else(|| missing("a variable style"))?;
        check_name(name).map_err(|message| Complaint::new(1, message))?;
        let arguments = words.get(3..).unwrap_or_default();
        if style != "delete" && arguments.is_empty() {
            return Err(missing("a value"));
        }
        match style {
            "delete" => {
                at_most(words, 3)?;
                self.variables.remove(name);
            }
            "index" if !self.has(name) => {
                let values = arguments.iter().map(|w| w.text.text().to_string()).collect();
                self.variables.insert(name.to_string(), Variable::Index { values, current: 0, known });
            }
            "loop" if !self.has(name) => {
                let variable = parse_loop(arguments)?;
                self.variables.insert(name.to_string(), variable);
            }
            "index" | "loop" => (), // defined already: the loop it steers goes on
            "string" | "equal" => {
                if style == "string" {
                    at_most(words, 4)?;
                }
                if let Some(old) = self.variables.get(name).map(Variable::style).filter(|old| *old != style) {
                    let message = format!("variable {name} has style {old} and cannot get style {style}");
                    return Err(Complaint::new(2, message).with_help("delete it first: variable NAME delete"));
                }
                let text = joined(arguments);
                let variable = if style == "string" {
                    Variable::Text { value: text.text().to_string(), known }
                } else {
                    Variable::Equal { formula: Formula::parse(&text), known, evaluating: false }
                };
                self.variables.insert(name.to_string(), variable);
            }
            other => {
                let message = if FOREIGN_STYLES.contains(&other) {
                    format!("variable style {other} is not part of octant")
                } else {
                    format!("unknown variable style '{other}'")
                };
                return Err(Complaint::new(2, format!("{message}; available: index, loop, string, equal, delete")));
            }
        }
        Ok(())
    }

    /// Carries out `next NAME ...`: true if a variable had no further value, and all named are gone (the next `jump` is then skipped).
    pub fn next(&mut self, words: &[Token]) -> Result<bool, Complaint> {
        let names: Vec<&str> = words.iter().skip(1).map(|w| w.text.text()).collect();
        if names.is_empty() {
            return Err(Complaint::new(0, "expected a variable name, got the end of the line"));
        }
        let mut first_style = None;
        for (k, name) in names.iter().enumerate() {
            let style = match self.variables.get(*name).map(Variable::style) {
                None => return Err(Complaint::new(k + 1, format!("undefined variable '{name}'"))),
                Some(style @ ("index" | "loop")) => style,
                Some(style) => {
                    let message = format!("expected an index or loop variable, got {name} of style {style}");
                    return Err(Complaint::new(k + 1, message));
                }
            };
            let first = *first_style.get_or_insert(style);
            if first != style {
                let message = format!("expected variables of one style, got {first} and {style}");
                return Err(Complaint::new(k + 1, message));
            }
        }
        let mut exhausted = false;
        for name in &names {
            match self.variables.get_mut(*name) {
                Some(Variable::Index { values, current, .. }) if *current + 1 < values.len() => *current += 1,
                Some(Variable::Loop { now, last, .. }) if *now < *last => *now += 1,
                _ => exhausted = true,
            }
        }
        if exhausted {
            self.variables.retain(|name, _| !names.contains(&name.as_str()));
        }
        Ok(exhausted)
    }

    /// The variable's number at full precision: an equal-style formula's value, or other variables' text read as a number.
    /// `Ok(None)` where there is no such variable.
    pub fn value(&mut self, name: &str, environment: &mut dyn Environment) -> Result<Option<Quantity>, LookupError> {
        if let Some(Variable::Equal { .. }) = self.variables.get(name) {
            return self.evaluate(name, environment, 0).map(Some);
        }
        let Some(Looked { text, known }) = self.look_up(name, environment, 0)? else { return Ok(None) };
        match parse_number(&text).filter(|x| x.is_finite()) {
            Some(value) => Ok(Some(Quantity { value, known })),
            None => Err(LookupError::Here(format!("expected a finite number in variable {name}, got '{text}'"))),
        }
    }

    fn evaluate(
        &mut self,
        name: &str,
        environment: &mut dyn Environment,
        depth: usize,
    ) -> Result<Quantity, LookupError> {
        let in_variable =
            |error: FormulaError| FormulaError { variable: error.variable.or(Some(name.to_string())), ..error };
        let Some(Variable::Equal { formula, known, evaluating }) = self.variables.get_mut(name) else {
            return Err(LookupError::Here(format!("undefined variable '{name}'")));
        };
        if *evaluating {
            return Err(LookupError::Here(format!("variable {name} is defined through itself")));
        }
        let known = *known;
        let formula = formula.clone().map_err(|error| LookupError::Placed(in_variable(error)))?;
        *evaluating = true;
        let result = Evaluator::new(self, environment, depth).evaluate(&formula);
        if let Some(Variable::Equal { evaluating, .. }) = self.variables.get_mut(name) {
            *evaluating = false;
        }
        match result {
            Ok(quantity) => Ok(Quantity { known: quantity.known && known, ..quantity }),
            Err(error) => Err(LookupError::Placed(in_variable(error))),
        }
    }

    /// Value of the formula in `$(...)`.
    pub fn immediate(&mut self, formula: &Mapped, environment: &mut dyn Environment) -> Result<Quantity, FormulaError> {
        Evaluator::new(self, environment, 0).evaluate(&Formula::parse(formula)?)
    }
}

impl Lookup for Variables {
    fn look_up(
        &mut self,
        name: &str,
        environment: &mut dyn Environment,
        depth: usize,
    ) -> Result<Option<Looked>, LookupError> {
        Ok(Some(match self.variables.get(name) {
            None => return Ok(None),
            Some(Variable::Index { values, current, known }) => {
                Looked { text: values.get(*current).cloned().unwrap_or_default(), known: *known }
            }
            Some(Variable::Loop { now, width, .. }) => Looked { text: pad_with_zeros(*now, *width), known: true },
            Some(Variable::Text { value, known }) => Looked { text: value.clone(), known: *known },
            Some(Variable::Equal { .. }) => {
                let Quantity { value, known } = self.evaluate(name, environment, depth)?;
                Looked { text: format_value(value, EQUAL_DIGITS), known }
            }
        }))
    }

    fn random(&mut self) -> &mut Option<RanMar> {
        &mut self.random
    }
}

/// A formula's value as `%.<digits>g`. LAMMPS prints a negative zero without its sign.
pub fn format_value(value: f64, digits: usize) -> String {
    format_g(value + 0.0, 0, digits, false)
}

fn pad_with_zeros(value: i64, width: usize) -> String {
    format!("{value:0width$}")
}

fn check_name(name: &str) -> Result<(), String> {
    if !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_') {
        Ok(())
    } else {
        Err(format!("expected a variable name of letters, digits and underscores, got '{name}'"))
    }
}

/// The words of a formula, blanks between them.
fn joined(words: &[Token]) -> Mapped {
    let mut text = Mapped::default();
    for (k, word) in words.iter().enumerate() {
        if k > 0 {
            text.push_copied(" ", word.span.start);
        }
        text.append(&word.text);
    }
    text
}

fn at_most(words: &[Token], count: usize) -> Result<(), Complaint> {
    match words.get(count) {
        None => Ok(()),
        Some(word) => {
            let message = format!("expected the end of the line, got '{}'", word.text.text());
            Err(Complaint::new(count, message).with_help("put quotes around a value that has blanks"))
        }
    }
}

/// `N`, `N M`, each with `pad` behind it.
fn parse_loop(arguments: &[Token]) -> Result<Variable, Complaint> {
    let texts: Vec<&str> = arguments.iter().map(|w| w.text.text()).collect();
    let integer = |k: usize| {
        texts[k]
            .parse::<i64>()
            .map_err(|_| Complaint::new(k + 3, format!("expected a whole number, got '{}'", texts[k])))
    };
    let (numbers, pad) = match texts.split_last() {
        Some((&"pad", numbers)) => (numbers.len(), true),
        _ => (texts.len(), false),
    };
    let (first, last) = match numbers {
        1 => (1, integer(0)?),
        2 => (integer(0)?, integer(1)?),
        _ => {
            let at = if numbers == 0 { 3 } else { 5 };
            return Err(Complaint::new(at, "expected N, N pad, N M or N M pad for a loop variable"));
        }
    };
    if first > last {
        let message = format!("expected a loop that ends at {first} or above, got {last}");
        return Err(Complaint::new(2 + numbers, message));
    }
    let width = if pad { last.to_string().len() } else { 0 };
    Ok(Variable::Loop { now: first, last, width })
}
