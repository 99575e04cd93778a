//! Formula text to tree.

use std::ops::Range;

use super::functions::Function;
use super::{Expression, Node, Operator, RangeError};

/// Deepest nesting of parentheses, functions and signs.
const DEEPEST: usize = 200;
/// Highest tree: longest chain of operators of one formula.
const HIGHEST: usize = 1000;

/// LAMMPS's release date as a number, the value of the constant `version`: the release whose behavior octant follows.
const LAMMPS_VERSION: f64 = 20250722.0;

/// Constants by name.
pub const CONSTANTS: [(&str, f64); 8] = [
    ("PI", std::f64::consts::PI),
    ("version", LAMMPS_VERSION),
    ("yes", 1.0),
    ("no", 0.0),
    ("true", 1.0),
    ("false", 0.0),
    ("on", 1.0),
    ("off", 0.0),
];

/// What LAMMPS has under a prefix and octant lacks.
const FOREIGN_PREFIXES: [(&str, &str); 5] = [
    ("c_", "computes"),
    ("C_", "computes"),
    ("f_", "values of fixes"),
    ("F_", "values of fixes"),
    ("i_", "custom atom properties"),
];

/// Parses a whole formula.
pub fn parse(text: &str) -> Result<Expression, RangeError> {
    let mut parser = Parser { text, at: 0, depth: 0 };
    let root = parser.binary(0)?;
    match parser.peek() {
        None => Ok(root),
        Some(_) => Err(parser.expected("an operator")),
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
}

impl<'a> Parser<'a> {
    /// Skips blanks and looks at the next character.
    fn peek(&mut self) -> Option<char> {
        let rest = self.rest();
        self.at += rest.len() - rest.trim_start().len();
        self.rest().chars().next()
    }

    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn expected(&mut self, what: &str) -> RangeError {
        match self.peek() {
            Some(c) => {
                RangeError::new(self.at..self.at + c.len_utf8(), format!("expected {what} in the formula, got '{c}'"))
            }
            None => RangeError::new(
                self.text.len()..self.text.len(),
                format!("expected {what}, got the end of the formula '{}'", self.text),
            ),
        }
    }

    fn node(&self, node: Node, range: Range<usize>, below: usize) -> Result<Expression, RangeError> {
        if below >= HIGHEST {
            return Err(RangeError::new(range, format!("the formula has more than {HIGHEST} operations in a row")));
        }
        Ok(Expression { node, range, height: below + 1 })
    }

    /// Operators of at least this precedence (precedence climbing).
    fn binary(&mut self, least: u8) -> Result<Expression, RangeError> {
        let mut left = self.unary()?;
        loop {
            self.peek();
            let Some((operator, length)) = Operator::at(self.rest()).filter(|(o, _)| o.precedence() >= least) else {
                return Ok(left);
            };
            self.at += length;
            let right = self.binary(operator.precedence() + 1)?;
            let (range, below) = (left.range.start..right.range.end, left.height.max(right.height));
            left = self.node(Node::Binary(operator, Box::new(left), Box::new(right)), range, below)?;
        }
    }

    fn unary(&mut self) -> Result<Expression, RangeError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(RangeError::new(self.at..self.at, format!("the formula is nested more than {DEEPEST} deep")));
        }
        let result = self.unary_within_depth();
        self.depth -= 1;
        result
    }

    fn unary_within_depth(&mut self) -> Result<Expression, RangeError> {
        let next = self.peek();
        let start = self.at;
        match next {
            Some(sign @ ('-' | '!')) => {
                self.at += 1;
                let operand = self.unary()?;
                let (range, below) = (start..operand.range.end, operand.height);
                let operand = Box::new(operand);
                self.node(if sign == '-' { Node::Negate(operand) } else { Node::Not(operand) }, range, below)
            }
            Some('(') => {
                self.at += 1;
                let mut inner = self.binary(0)?;
                self.close(start)?;
                inner.range = start..self.at;
                Ok(inner)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() || c == '_' => self.word(),
            _ => Err(self.expected("a number, a function or a variable")),
        }
    }

    fn close(&mut self, open: usize) -> Result<(), RangeError> {
        match self.peek() {
            Some(')') => {
                self.at += 1;
                Ok(())
            }
            None => Err(RangeError::new(open..open + 1, "expected a closing ')', got the end of the formula")),
            Some(_) => Err(self.expected("an operator or ')'")),
        }
    }

    fn number(&mut self) -> Result<Expression, RangeError> {
        let bytes = self.text.as_bytes();
        let digits = |mut at: usize, point: bool| {
            while bytes.get(at).is_some_and(|b| b.is_ascii_digit() || (point && *b == b'.')) {
                at += 1;
            }
            at
        };
        let start = self.at;
        let mut end = digits(start, true);
        if bytes.get(end).is_some_and(|b| matches!(b, b'e' | b'E')) {
            let sign = usize::from(bytes.get(end + 1).is_some_and(|b| matches!(b, b'+' | b'-')));
            end = digits(end + 1 + sign, false);
        }
        self.at = end;
        let written = &self.text[start..end];
        match written.parse::<f64>() {
            Ok(value) if value.is_finite() => self.node(Node::Number(value), start..end, 0),
            Ok(_) => Err(RangeError::new(start..end, format!("the number {written} is too large"))),
            Err(_) => Err(RangeError::new(start..end, format!("expected a number in the formula, got '{written}'"))),
        }
    }

    fn word(&mut self) -> Result<Expression, RangeError> {
        let start = self.at;
        let rest = self.rest();
        let word = &rest[..rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(rest.len())];
        self.at += word.len();
        let range = start..self.at;
        if let Some((_, what)) = FOREIGN_PREFIXES.iter().find(|(prefix, _)| word.starts_with(prefix)) {
            return Err(RangeError::new(range, format!("{what} ({word}) are not part of octant's formulas")));
        }
        if self.rest().starts_with('[') {
            return Err(RangeError::new(
                range,
                format!("values in brackets ({word}[...]) are not part of octant's formulas"),
            ));
        }
        if let Some(name) = word.strip_prefix("v_") {
            if name.is_empty() {
                return Err(RangeError::new(range, "expected a variable name after v_"));
            }
            return self.node(Node::Variable(name.to_string()), range, 0);
        }
        if self.rest().starts_with('(') {
            return match Function::named(word) {
                Some(function) => self.call(function, start),
                None => self.group(word, start),
            };
        }
        match CONSTANTS.iter().find(|(name, _)| *name == word) {
            Some((_, value)) => self.node(Node::Number(*value), range, 0),
            None => self.node(Node::Keyword(word.to_string()), range, 0),
        }
    }

    fn call(&mut self, function: &'static Function, start: usize) -> Result<Expression, RangeError> {
        let open = self.at;
        self.at += 1;
        let mut args = Vec::new();
        loop {
            args.push(self.binary(0)?);
            if self.peek() != Some(',') {
                break;
            }
            self.at += 1;
        }
        self.close(open)?;
        let range = start..self.at;
        if args.len() != function.arguments {
            let message = format!("{} takes {} arguments, got {}", function.name, function.arguments, args.len());
            return Err(RangeError::new(range, message.replace(" 1 arguments", " 1 argument")));
        }
        let below = args.iter().map(|a| a.height).max().unwrap_or(0);
        self.node(Node::Call(function, args), range, below)
    }

    /// A function whose arguments are names, kept as text.
    fn group(&mut self, name: &str, start: usize) -> Result<Expression, RangeError> {
        let open = self.at;
        let rest = self.rest();
        let Some(close) = rest.find(')') else {
            return Err(RangeError::new(open..open + 1, "expected a closing ')', got the end of the formula"));
        };
        let args = rest[1..close].split(',').map(|arg| arg.trim().to_string()).collect();
        self.at += close + 1;
        self.node(Node::Group(name.to_string(), args), start..self.at, 0)
    }
}
