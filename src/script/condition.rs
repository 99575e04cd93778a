//! Conditions of the `if` command (doc page `if`): numbers and strings compared, no arithmetic.

use super::formula::{Operator, RangeError};

/// Deepest nesting of parentheses and `!`.
const DEEPEST: usize = 200;

/// A number, or a word that is none.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    Number(f64),
    Text(String),
}

/// Whether a condition holds.
pub fn holds(text: &str) -> Result<bool, RangeError> {
    let mut condition = Condition { text, at: 0, depth: 0 };
    let value = condition.binary(0)?;
    condition.skip_blanks();
    if condition.at < text.len() {
        return Err(condition.expected("a comparison or the end of the condition"));
    }
    match value {
        Value::Number(x) => Ok(x != 0.0),
        Value::Text(word) => {
            Err(RangeError::new(0..text.len(), format!("expected a number or a comparison as condition, got '{word}'")))
        }
    }
}

struct Condition<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
}

impl Condition<'_> {
    fn skip_blanks(&mut self) {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
    }

    fn expected(&self, what: &str) -> RangeError {
        match self.text[self.at..].chars().next() {
            Some(c) => RangeError::new(self.at..self.at + c.len_utf8(), format!("expected {what}, got '{c}'")),
            None => RangeError::new(self.at..self.at, format!("expected {what}, got the end of the condition")),
        }
    }

    fn binary(&mut self, least: u8) -> Result<Value, RangeError> {
        let start = self.at;
        let mut left = self.operand()?;
        loop {
            self.skip_blanks();
            let found = Operator::at(&self.text[self.at..]);
            let Some((operator, length)) =
                found.filter(|(o, _)| o.precedence() < Operator::Add.precedence() && o.precedence() >= least)
            else {
                return Ok(left);
            };
            self.at += length;
            let right = self.binary(operator.precedence() + 1)?;
            left = apply(operator, left, right).map_err(|message| RangeError::new(start..self.at, message))?;
        }
    }

    fn operand(&mut self) -> Result<Value, RangeError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(RangeError::new(self.at..self.at, format!("the condition is nested more than {DEEPEST} deep")));
        }
        let result = self.operand_within_depth();
        self.depth -= 1;
        result
    }

    fn operand_within_depth(&mut self) -> Result<Value, RangeError> {
        self.skip_blanks();
        let start = self.at;
        let rest = &self.text[start..];
        match rest.chars().next() {
            Some('!') => {
                self.at += 1;
                match self.operand()? {
                    Value::Number(x) => Ok(truth(x == 0.0)),
                    Value::Text(word) => {
                        Err(RangeError::new(start..self.at, format!("expected a number after !, got '{word}'")))
                    }
                }
            }
            Some('(') => {
                self.at += 1;
                let value = self.binary(0)?;
                self.skip_blanks();
                if !self.text[self.at..].starts_with(')') {
                    return Err(self.expected("a closing ')'"));
                }
                self.at += 1;
                Ok(value)
            }
            Some(c) if c.is_ascii_digit() || matches!(c, '.' | '-') => {
                let length = rest.find(|c: char| !(c.is_ascii_digit() || ".eE+-".contains(c))).unwrap_or(rest.len());
                self.at += length;
                rest[..length].parse().map(Value::Number).map_err(|_| {
                    RangeError::new(start..self.at, format!("expected a number, got '{}'", &rest[..length]))
                })
            }
            Some(c) if c.is_ascii_alphabetic() || matches!(c, '_' | '/') => {
                let in_word = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '/' | '.');
                let length = rest.find(|c| !in_word(c)).unwrap_or(rest.len());
                self.at += length;
                Ok(Value::Text(rest[..length].to_string()))
            }
            _ => Err(self.expected("a number or a word")),
        }
    }
}

fn truth(yes: bool) -> Value {
    Value::Number(f64::from(u8::from(yes)))
}

fn apply(operator: Operator, left: Value, right: Value) -> Result<Value, String> {
    match (operator, left, right) {
        (_, Value::Number(a), Value::Number(b)) => operator.apply(a, b).map(Value::Number).map_err(str::to_string),
        (Operator::Equal, Value::Text(a), Value::Text(b)) => Ok(truth(a == b)),
        (Operator::NotEqual, Value::Text(a), Value::Text(b)) => Ok(truth(a != b)),
        (Operator::Equal | Operator::NotEqual, Value::Text(word), _)
        | (Operator::Equal | Operator::NotEqual, _, Value::Text(word)) => {
            Err(format!("expected two numbers or two words to compare, got a number and '{word}'"))
        }
        (_, Value::Text(word), _) | (_, _, Value::Text(word)) => Err(format!("expected numbers, got '{word}'")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers of LAMMPS's `if`; `None` where it stops with an error.
    #[test]
    fn conditions_are_those_of_lammps() {
        let cases = [
            ("$", None),
            ("5 > 4", Some(true)),
            ("abc == abc", Some(true)),
            ("abc != abd", Some(true)),
            ("abc/d == abc/d", Some(true)),
            ("(1 < 2) || (3 < 2)", Some(true)),
            ("!(1==2) && !0 || abc==d", Some(true)),
            ("1 |^ 1", Some(false)),
            ("1||1|^1", Some(false)),
            ("-3 < -2", Some(true)),
            ("1e-5 == .00001", Some(true)),
            ("1==1==1", Some(true)),
            (" 3 ", Some(true)),
            ("1 - 1", None),
            ("abc", None),
            ("yes", None),
            ("abc < abd", None),
            ("2^3==8", None),
            ("", None),
            ("1.0 == abc", None),
            ("1 <", None),
            ("a&&b", None),
            ("+1 == 1", None),
            ("1==1 2", None),
            ("(1", None),
            ("1)", None),
            ("a==b==c", None),
            ("!abc", None),
            ("5 < inf", None),
            ("1a == 1a", None),
            ("a-b == a-b", None),
        ];
        for (text, expected) in cases {
            assert_eq!(holds(text).ok(), expected, "{text}");
        }
        assert!(holds(&"(".repeat(100_000)).is_err());
    }
}
