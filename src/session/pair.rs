//! `pair_style`, `pair_coeff`, `pair_modify`: their words handed to the pair room.

use super::ScriptState;
use crate::pair::{Mixing, PairCoefficients};
use crate::scene::builder::Messages;
use crate::scene::type_range::type_range;
use crate::script::command::{PairCoeffCommand, PairModifyCommand, PairStyleCommand};
use crate::script::{Complaint, Name, parse_number};

impl ScriptState {
    pub fn pair_style(&mut self, command: &PairStyleCommand) -> Result<Messages, Complaint> {
        let name = &command.style;
        let known = PairCoefficients::new(&name.text, 0.0, self.scene.masses.len());
        let fresh = known.map_err(|m| Complaint::new(name.word, m))?;
        let cutoff = match command.args.as_slice() {
            [one] => number(one, "a cutoff")?,
            [] => return Err(Complaint::new(name.word, "expected a cutoff, got the end of the line")),
            [_, more, ..] => {
                return Err(Complaint::new(more.word, format!("expected the end of the line, got '{}'", more.text)));
            }
        };
        if cutoff <= 0.0 {
            let word = &command.args[0];
            return Err(Complaint::new(word.word, format!("expected a cutoff above 0, got '{}'", word.text)));
        }
        match &mut self.scene.pair {
            Some(pair) if pair.style().name == name.text => pair.reset_cutoff(cutoff),
            other => other.insert(fresh).reset_cutoff(cutoff),
        }
        Ok(Messages::new())
    }

    pub fn pair_coeff(&mut self, command: &PairCoeffCommand) -> Result<Messages, Complaint> {
        self.scene.space()?;
        let types = self.scene.masses.len();
        let pair = self.scene.pair.as_mut().ok_or_else(|| Complaint::new(0, "there is no pair_style yet"))?;
        let range = |name: &Name| type_range(name, types).map(|r| (*r.start() as usize, *r.end() as usize));
        let (rows, columns) = (range(&command.first)?, range(&command.second)?);
        let words: Vec<&str> = command.args.iter().map(|n| n.text.as_str()).collect();
        pair.set(rows, columns, &words).map_err(|(at, message)| {
            Complaint::new(command.args.get(at).map_or(command.second.word, |n| n.word), message)
        })?;
        Ok(Messages::new())
    }

    pub fn pair_modify(&mut self, command: &PairModifyCommand) -> Result<Messages, Complaint> {
        let pair = self.scene.pair.as_mut().ok_or_else(|| Complaint::new(0, "there is no pair_style yet"))?;
        let mut words = command.args.iter();
        while let Some(keyword) = words.next() {
            let value = words.next().ok_or_else(|| {
                Complaint::new(
                    keyword.word,
                    format!("expected a value for '{}', got the end of the line", keyword.text),
                )
            })?;
            match keyword.text.as_str() {
                "shift" => pair.shift = yes_no(value)?,
                "mix" => {
                    let rule = Mixing::NAMES.iter().position(|n| *n == value.text);
                    let message = || format!("expected {}, got '{}'", Mixing::NAMES.join(", "), value.text);
                    pair.mixing = Mixing::ALL[rule.ok_or_else(|| Complaint::new(value.word, message()))?];
                }
                "tail" | "table" | "table/disp" | "tabinner" | "tabinner/disp" | "compute" | "nofdotr" | "special"
                | "pair" => {
                    if keyword.text == "tail" && !yes_no(value)? {
                        continue;
                    }
                    let message = format!("pair_modify {} is not part of octant; available: shift, mix", keyword.text);
                    return Err(Complaint::new(keyword.word, message));
                }
                other => {
                    return Err(Complaint::new(keyword.word, format!("expected shift or mix, got '{other}'")));
                }
            }
        }
        Ok(Messages::new())
    }
}

fn number(name: &Name, what: &str) -> Result<f64, Complaint> {
    parse_number(&name.text)
        .filter(|x| x.is_finite())
        .ok_or_else(|| Complaint::new(name.word, format!("expected {what}, a finite number, got '{}'", name.text)))
}

fn yes_no(name: &Name) -> Result<bool, Complaint> {
    match name.text.as_str() {
        "yes" | "on" | "true" => Ok(true),
        "no" | "off" | "false" => Ok(false),
        other => Err(Complaint::new(name.word, format!("expected yes or no, got '{other}'"))),
    }
}
