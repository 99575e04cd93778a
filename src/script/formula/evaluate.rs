//! Formula tree to number.

use super::functions::{Clock, Compute, Function};
use super::{Expression, Formula, FormulaError, Node, RangeError};
use crate::script::environment::{Environment, Quantity};
use crate::script::ranmar::{LARGEST_SEED, RanMar};
use crate::script::statement::parse_number;

/// Deepest recursion over all formulas that call each other.
const DEEPEST: usize = 1500;

/// Stands for a value that could not be computed because it depends on one that is not known yet.
const STAND_IN: Quantity = Quantity { value: 1.0, known: false };

/// A variable's text, as `${name}` would print it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Looked {
    pub text: String,
    pub known: bool,
}

/// Where formulas find the variables they name, and the one random stream all of them share.
pub trait Lookup {
    /// Text of variable `name` as `${name}` prints it; `Ok(None)` where there is none.
    /// `depth` is the recursion so far, to be handed to [`Evaluator::new`] for the formula of an equal-style variable.
    fn look_up(
        &mut self,
        name: &str,
        environment: &mut dyn Environment,
        depth: usize,
    ) -> Result<Option<Looked>, LookupError>;
    /// The stream of `random` and `normal`; the first seed that was ever given starts it.
    fn random(&mut self) -> &mut Option<RanMar>;
}

/// Why a variable has no value.
#[derive(Clone, Debug)]
pub enum LookupError {
    /// An error at its own place (in that variable's formula).
    Placed(FormulaError),
    /// An error at the place where the variable is named.
    Here(String),
}

/// Group functions of LAMMPS, to tell them from words that are none.
const LAMMPS_FUNCTIONS: [&str; 40] = [
    "count",
    "mass",
    "charge",
    "xcm",
    "vcm",
    "fcm",
    "bound",
    "gyration",
    "ke",
    "angmom",
    "torque",
    "inertia",
    "omega",
    "sum",
    "min",
    "max",
    "ave",
    "trap",
    "slope",
    "sort",
    "rsort",
    "gmask",
    "rmask",
    "grmask",
    "next",
    "is_file",
    "is_os",
    "extract_setting",
    "label2type",
    "typelabel2type",
    "is_typelabel",
    "is_timeout",
    "is_available",
    "is_active",
    "is_defined",
    "is_nan",
    "is_inf",
    "xor",
    "C",
    "F",
];

/// Evaluates formulas.
pub struct Evaluator<'a> {
    pub lookup: &'a mut dyn Lookup,
    pub environment: &'a mut dyn Environment,
    depth: usize,
}

impl<'a> Evaluator<'a> {
    pub fn new(lookup: &'a mut dyn Lookup, environment: &'a mut dyn Environment, depth: usize) -> Self {
        Self { lookup, environment, depth }
    }

    /// The formula's value, its operations in LAMMPS's order.
    pub fn evaluate(&mut self, formula: &Formula) -> Result<Quantity, FormulaError> {
        self.expression(&formula.root).map_err(|failure| match failure {
            Failure::Here(error) => error.place(&formula.text),
            Failure::Placed(error) => error,
        })
    }

    fn expression(&mut self, expression: &Expression) -> Result<Quantity, Failure> {
        if self.depth >= DEEPEST {
            return Err(fail(expression, format!("formulas are nested more than {DEEPEST} deep")));
        }
        self.depth += 1;
        let result = self.within_depth(expression);
        self.depth -= 1;
        result
    }

    fn within_depth(&mut self, expression: &Expression) -> Result<Quantity, Failure> {
        match &expression.node {
            Node::Number(value) => Ok(Quantity::known(*value)),
            Node::Negate(operand) => {
                let a = self.expression(operand)?;
                Ok(Quantity { value: -a.value, ..a })
            }
            Node::Not(operand) => {
                let a = self.expression(operand)?;
                Ok(Quantity { value: f64::from(u8::from(a.value == 0.0)), ..a })
            }
            Node::Binary(operator, left, right) => {
                let (a, b) = (self.expression(left)?, self.expression(right)?);
                let value = operator.apply(a.value, b.value);
                settle(expression, value, a.known && b.known)
            }
            Node::Variable(name) => self.variable(expression, name),
            Node::Keyword(keyword) => self.keyword(expression, keyword),
            Node::Group(function, args) => self.group(expression, function, args),
            Node::Call(function, args) => self.call(expression, function, args),
        }
    }

    /// `v_name`: the variable's text read back as a number (equal-style variables lose what `%.15g` cuts off, as in LAMMPS).
    fn variable(&mut self, expression: &Expression, name: &str) -> Result<Quantity, Failure> {
        let looked = self.lookup.look_up(name, self.environment, self.depth).map_err(|error| match error {
            LookupError::Placed(error) => Failure::Placed(error),
            LookupError::Here(message) => fail(expression, message),
        })?;
        let Some(Looked { text, known }) = looked else {
            return Err(fail(expression, format!("undefined variable '{name}'")));
        };
        match parse_number(&text).filter(|x| x.is_finite()) {
            Some(value) => Ok(Quantity { value, known }),
            None if !known => Ok(STAND_IN),
            None => Err(fail(expression, format!("expected a finite number in variable {name}, got '{text}'"))),
        }
    }

    fn keyword(&mut self, expression: &Expression, keyword: &str) -> Result<Quantity, Failure> {
        match self.environment.thermo(keyword) {
            Ok(Some(quantity)) => Ok(quantity),
            Ok(None) => Err(fail(
                expression,
                format!("expected a number, a variable (v_name), a constant or a thermo keyword, got '{keyword}'"),
            )),
            Err(message) => Err(fail(expression, message)),
        }
    }

    fn group(&mut self, expression: &Expression, function: &str, args: &[String]) -> Result<Quantity, Failure> {
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        match self.environment.group(function, &args) {
            Ok(Some(quantity)) => Ok(quantity),
            Ok(None) if LAMMPS_FUNCTIONS.contains(&function) => {
                Err(fail(expression, format!("{function}() is a LAMMPS function that octant does not have here")))
            }
            Ok(None) => Err(fail(expression, format!("expected the name of a function, got '{function}'"))),
            Err(message) => Err(fail(expression, message)),
        }
    }

    fn call(&mut self, expression: &Expression, function: &Function, args: &[Expression]) -> Result<Quantity, Failure> {
        if let (Compute::Ternary, [condition, yes, no]) = (function.compute, args) {
            let condition = self.expression(condition)?;
            let chosen = self.expression(if condition.value != 0.0 { yes } else { no })?;
            return Ok(Quantity { known: chosen.known && condition.known, ..chosen });
        }
        let mut values = Vec::with_capacity(args.len());
        let mut known = true;
        for arg in args {
            let quantity = self.expression(arg)?;
            known &= quantity.known;
            values.push(quantity.value);
        }
        let value = match function.compute {
            Compute::Pure(compute) => compute(&values),
            Compute::Time(compute) => {
                let (clock, clock_known) = self.clock().map_err(|message| fail(expression, message))?;
                known &= clock_known;
                compute(&values, &clock)
            }
            Compute::Random => self.random(&values, |stream, lo, hi| Ok(stream.uniform() * (hi - lo) + lo)),
            Compute::Normal => self.random(&values, |stream, mean, sigma| {
                if sigma >= 0.0 { Ok(mean + sigma * stream.gaussian()) } else { Err("expected a width of at least 0") }
            }),
            Compute::Ternary => Err("expected 3 arguments"),
        };
        let value = value.map_err(|message| format!("{}: {message}", function.name));
        settle(expression, value, known)
    }

    fn random(
        &mut self,
        values: &[f64],
        draw: impl Fn(&mut RanMar, f64, f64) -> Result<f64, &'static str>,
    ) -> Result<f64, &'static str> {
        let [a, b, seed] = values else { return Err("expected 3 arguments") };
        if *seed < 1.0 || *seed >= LARGEST_SEED as f64 + 1.0 || seed.is_nan() {
            return Err("expected a seed of 1 to 900000000");
        }
        let stream = self.lookup.random();
        if stream.is_none() {
            *stream = RanMar::new(*seed as i64);
        }
        match stream {
            Some(stream) => draw(stream, *a, *b),
            None => Err("expected a seed of 1 to 900000000"),
        }
    }

    /// Where the simulation stands; step 0 where there is none.
    fn clock(&mut self) -> Result<(Clock, bool), String> {
        let zero = Quantity::known(0.0);
        let step = self.environment.thermo("step")?.unwrap_or(zero);
        let timestep = self.environment.thermo("dt")?.unwrap_or(zero);
        let (first, last) = self.environment.run_range();
        Ok((Clock { step: step.value as i64, timestep: timestep.value, first, last }, step.known && timestep.known))
    }
}

/// An error at a range of the formula at hand, or one that already has its place.
enum Failure {
    Here(RangeError),
    Placed(FormulaError),
}

fn fail(expression: &Expression, message: impl Into<String>) -> Failure {
    Failure::Here(RangeError::new(expression.range.clone(), message))
}

/// An operation without a value is an error only if all that went into it is known.
fn settle<E: Into<String>>(expression: &Expression, value: Result<f64, E>, known: bool) -> Result<Quantity, Failure> {
    match value {
        Ok(value) => Ok(Quantity { value, known }),
        Err(_) if !known => Ok(STAND_IN),
        Err(message) => Err(fail(expression, message)),
    }
}
