//! Formats of the columns of a table or dump: what the `format` keyword sets, on top of defaults.

use super::printf::{Conversion, Printf};
use super::quantities::Number;
use crate::script::Complaint;
use crate::script::command::number_format::{FormatChange, FormatTarget};

/// User-set formats. A column's own wins over those for all integers or floats, these over the line's.
#[derive(Clone, Debug, Default)]
pub struct Formats {
    line: Vec<Printf>,
    integer: Option<Printf>,
    float: Option<Printf>,
    columns: Vec<Option<Printf>>,
}

impl Formats {
    /// Defaults for so many columns.
    pub fn new(columns: usize) -> Self {
        Self { columns: vec![None; columns], ..Self::default() }
    }

    /// Takes over one `format` setting; `find` gives the index of a column that the user named.
    pub fn change(
        &mut self,
        change: &FormatChange,
        find: impl Fn(&str) -> Result<usize, String>,
    ) -> Result<(), Complaint> {
        match &change.target {
            FormatTarget::None => *self = Self::new(self.columns.len()),
            FormatTarget::Line(formats) => self.line.clone_from(formats),
            FormatTarget::Integer(format) => {
                if format.conversion() != Conversion::Integer {
                    return Err(Complaint::new(change.word + 1, "expected a format with %d for integers"));
                }
                self.integer = Some(format.clone());
            }
            FormatTarget::Float(format) => self.float = Some(format.clone()),
            FormatTarget::Column(name, format) => {
                let k = find(name).map_err(|why| Complaint::new(change.word, why))?;
                if let Some(column) = self.columns.get_mut(k) {
                    *column = Some(format.clone());
                }
            }
        }
        Ok(())
    }

    /// Says what is wrong with the formats of these columns (true: integers). A line of formats must have one a column,
    /// up to `spare` more.
    pub fn check(&self, integers: &[bool], spare: usize) -> Result<(), String> {
        let kinds: Vec<_> = integers.iter().map(|i| if *i { Kind::Integer } else { Kind::Float }).collect();
        self.check_kinds(&kinds, spare)
    }

    /// As [`Formats::check`], with text columns.
    pub fn check_kinds(&self, kinds: &[Kind], spare: usize) -> Result<(), String> {
        let (given, columns) = (self.line.len(), kinds.len());
        if given > 0 && (given < columns || given > columns + spare) {
            return Err(format!("expected {columns} formats, one a column, got {given}"));
        }
        for (k, kind) in kinds.iter().enumerate() {
            let Some(format) = self.chosen(k, *kind) else { continue };
            let fits = match kind {
                Kind::Integer => format.conversion() != Conversion::Text,
                // C would print garbage for an integer format here; say so instead.
                Kind::Float => {
                    matches!(format.conversion(), Conversion::Fixed | Conversion::Exponent | Conversion::General)
                }
                Kind::Text => format.conversion() == Conversion::Text,
            };
            if !fits {
                let wants = match kind {
                    Kind::Integer => "an integer: expected %d",
                    Kind::Float => "a floating-point number: expected %g, %f or %e",
                    Kind::Text => "text: expected %s",
                };
                return Err(format!("column {} is {wants}", k + 1));
            }
        }
        Ok(())
    }

    /// The user's format of column `k`, if there is one.
    pub fn chosen(&self, k: usize, kind: Kind) -> Option<&Printf> {
        let by_kind = match kind {
            Kind::Integer => self.integer.as_ref(),
            Kind::Float => self.float.as_ref(),
            Kind::Text => None,
        };
        self.columns.get(k).and_then(Option::as_ref).or(by_kind).or_else(|| self.line.get(k))
    }

    /// Formats a value of column `k`, with the defaults for integers and floats.
    pub fn number(&self, k: usize, value: Number, integer: &Printf, float: &Printf) -> String {
        match value {
            Number::Integer(n) => self.chosen(k, Kind::Integer).unwrap_or(integer).integer(n),
            Number::Float(x) => self.chosen(k, Kind::Float).unwrap_or(float).float(x),
        }
    }
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Integer,
    Float,
    Text,
}

/// Index of a column that is called by number (from 1, or from the end if negative) or by name.
pub fn column_index(text: &str, columns: usize, name: impl Fn(usize) -> String) -> Result<usize, String> {
    let none = || format!("expected a column from 1 to {columns} or its name, got '{text}'");
    match text.parse::<i64>() {
        Ok(number) => {
            let from_start = if number < 0 { number.saturating_add(columns as i64) } else { number.saturating_sub(1) };
            usize::try_from(from_start).ok().filter(|k| number != 0 && *k < columns).ok_or_else(none)
        }
        Err(_) => (0..columns).find(|k| name(*k) == text).ok_or_else(none),
    }
}
