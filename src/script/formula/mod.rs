//! Formulas of equal-style variables and of `$(...)` (doc page `variable`): text to tree, tree to number.

pub mod evaluate;
pub mod functions;
pub mod parser;
#[cfg(test)]
mod tests;

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use super::mapped::Mapped;
use super::source::Span;

pub use evaluate::{Evaluator, Looked, Lookup};
use functions::Function;

/// What is wrong with a formula, and where in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FormulaError {
    pub span: Span,
    pub message: String,
    /// The variable whose formula it is; `None` for the formula at hand.
    pub variable: Option<String>,
}

impl fmt::Display for FormulaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.variable {
            Some(name) => write!(f, "variable {name}: {}", self.message),
            None => write!(f, "formula: {}", self.message),
        }
    }
}

/// A parsed formula and the text it came from.
#[derive(Clone, Debug)]
pub struct Formula {
    text: Arc<Mapped>,
    root: Arc<Expression>,
}

impl Formula {
    /// Parses a whole formula.
    pub fn parse(text: &Mapped) -> Result<Self, FormulaError> {
        let root = Arc::new(parser::parse(text.text()).map_err(|e| e.place(text))?);
        Ok(Self { text: Arc::new(text.clone()), root })
    }
}

/// What is wrong in a range of a formula's text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RangeError {
    pub range: Range<usize>,
    pub message: String,
}

impl RangeError {
    pub fn new(range: Range<usize>, message: impl Into<String>) -> Self {
        Self { range, message: message.into() }
    }

    /// The same with its place in the file.
    pub fn place(self, text: &Mapped) -> FormulaError {
        FormulaError { span: text.span(self.range), message: self.message, variable: None }
    }
}

/// A part of a formula and its place in the text.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    pub node: Node,
    pub range: Range<usize>,
    /// Height of the tree below, bounded so that recursion is.
    height: usize,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    Number(f64),
    /// `v_name`.
    Variable(String),
    /// A bare word that is no constant: a thermo keyword.
    Keyword(String),
    Negate(Box<Expression>),
    Not(Box<Expression>),
    Binary(Operator, Box<Expression>, Box<Expression>),
    /// A mathematical function.
    Call(&'static Function, Vec<Expression>),
    /// A function of the simulation with its arguments as text, such as `mass(all)`.
    Group(String, Vec<String>),
}

/// Operators of two operands. Comparisons and logic give 1 or 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    /// Remainder with the sign of the dividend.
    Modulo,
    Power,
    Equal,
    NotEqual,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    And,
    Or,
    ExclusiveOr,
}

impl Operator {
    /// Spelling and operator; where one spelling starts another, the longer comes first.
    pub const ALL: [(&'static str, Self); 15] = [
        ("==", Self::Equal),
        ("!=", Self::NotEqual),
        ("<=", Self::LessOrEqual),
        (">=", Self::GreaterOrEqual),
        ("&&", Self::And),
        ("||", Self::Or),
        ("|^", Self::ExclusiveOr),
        ("<", Self::Less),
        (">", Self::Greater),
        ("+", Self::Add),
        ("-", Self::Subtract),
        ("*", Self::Multiply),
        ("/", Self::Divide),
        ("%", Self::Modulo),
        ("^", Self::Power),
    ];

    /// The operator that `text` starts with, and the length of its spelling.
    pub fn at(text: &str) -> Option<(Self, usize)> {
        Self::ALL.iter().find(|(spelling, _)| text.starts_with(spelling)).map(|(s, operator)| (*operator, s.len()))
    }

    /// Higher binds tighter; all are left-associative. Unary minus and `!` bind tighter than any of them, so `-2^2` is 4.
    pub fn precedence(self) -> u8 {
        match self {
            Self::Or | Self::ExclusiveOr => 1,
            Self::And => 2,
            Self::Equal | Self::NotEqual => 3,
            Self::Less | Self::LessOrEqual | Self::Greater | Self::GreaterOrEqual => 4,
            Self::Add | Self::Subtract => 5,
            Self::Multiply | Self::Divide | Self::Modulo => 6,
            Self::Power => 7,
        }
    }

    /// Applies it; the error names the operation that has no value.
    pub fn apply(self, a: f64, b: f64) -> Result<f64, &'static str> {
        let truth = |yes: bool| Ok(f64::from(u8::from(yes)));
        match self {
            Self::Add => Ok(a + b),
            Self::Subtract => Ok(a - b),
            Self::Multiply => Ok(a * b),
            Self::Divide if b == 0.0 => Err("division by zero"),
            Self::Divide => Ok(a / b),
            Self::Modulo if b == 0.0 => Err("remainder of a division by zero"),
            Self::Modulo => Ok(a % b),
            Self::Power if a == 0.0 && b < 0.0 => Err("zero to a negative power"),
            Self::Power => Ok(a.powf(b)),
            Self::Equal => truth(a == b),
            Self::NotEqual => truth(a != b),
            Self::Less => truth(a < b),
            Self::LessOrEqual => truth(a <= b),
            Self::Greater => truth(a > b),
            Self::GreaterOrEqual => truth(a >= b),
            Self::And => truth(a != 0.0 && b != 0.0),
            Self::Or => truth(a != 0.0 || b != 0.0),
            Self::ExclusiveOr => truth((a != 0.0) != (b != 0.0)),
        }
    }
}
