//! `pair_style`, `pair_coeff`, `pair_modify`, `pair_write`: their words handed to the pair room.

use std::path::Path;

use super::ScriptState;
use crate::output::check_writable;
use crate::output::pair_table::{Section, check_units};
use crate::pair::PairCoefficients;
use crate::scene::builder::Messages;
use crate::scene::type_range::type_range;
use crate::script::command::{PairCoeffCommand, PairModifyCommand, PairWriteCommand};
use crate::script::{Args, Complaint, Name};

impl ScriptState {
    /// `pair_style`; `args` stands behind the style's name.
    pub fn pair_style(&mut self, name: &Name, args: &mut Args<'_>) -> Result<Messages, Complaint> {
        let known = PairCoefficients::new(&name.text, 0.0, self.scene.masses.len());
        let fresh = known.map_err(|m| Complaint::new(name.word, m))?;
        let mut settings = Vec::new();
        for setting in fresh.style().settings {
            settings.push(args.number(setting.name)?);
        }
        let cutoff = match fresh.style().global_cutoff {
            true => args.number_where("a cutoff", "above 0", |r| r > 0.0)?,
            false => 0.0,
        };
        args.done()?;
        match &mut self.scene.pair {
            Some(pair) if pair.style().name == name.text => pair.reset(settings, cutoff),
            other => other.insert(fresh).reset(settings, cutoff),
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
        pair.shift = command.shift.unwrap_or(pair.shift);
        pair.tail = command.tail.unwrap_or(pair.tail);
        pair.mixing = command.mixing.unwrap_or(pair.mixing);
        Ok(Messages::new())
    }

    /// `pair_write`; what it prints. Where nothing is `live`, no file is written.
    pub fn pair_write(&self, command: &PairWriteCommand, live: bool) -> Result<Messages, Complaint> {
        self.scene.space()?;
        let types = self.scene.masses.len();
        let pair = self.scene.pair.as_ref().ok_or_else(|| Complaint::new(0, "there is no pair_style yet"))?;
        let kind = |name: &Name| match type_range(name, types)? {
            range if range.start() == range.end() => Ok(*range.start() as usize - 1),
            _ => Err(Complaint::new(name.word, format!("expected one atom type, got '{}'", name.text))),
        };
        let types = [kind(&command.first)?, kind(&command.second)?];
        let table = pair.complete().map_err(|m| Complaint::new(0, m))?.0;
        let PairWriteCommand { spacing, count, inner, outer, file, keyword, .. } = command;
        let complain = |message: String| Complaint::new(file.word, message);
        let units = self.scene.units.name;
        if !live {
            check_writable(&file.text).map_err(complain)?;
            let old = std::fs::read(&file.text).unwrap_or_default();
            check_units(&String::from_utf8_lossy(&old), units).map_err(|m| complain(format!("'{}' {m}", file.text)))?;
            return Ok(Messages::new());
        }
        let (pair, keyword) = (&table, keyword.text.as_str());
        let section = Section { pair, types, keyword, spacing: *spacing, count: *count, inner: *inner, outer: *outer };
        Ok(vec![section.append(Path::new(&file.text), units).map_err(complain)?])
    }
}
