//! Operations of the time step: `fix`, `unfix`.

use super::rest;
use crate::script::statement::{Args, Complaint, Name};

/// `fix ID GROUP STYLE ARGS...` (doc page `fix`); the style judges its arguments.
#[derive(Clone, Debug, PartialEq)]
pub struct FixCommand {
    pub id: Name,
    pub group: Name,
    pub style: Name,
    pub args: Vec<Name>,
}

impl FixCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        Ok(Self {
            id: identifier(args)?,
            group: args.name("a group name")?,
            style: args.name("a fix style")?,
            args: rest(args, "an argument")?,
        })
    }
}

/// LAMMPS takes letters, digits and underscores in ids.
fn identifier(args: &mut Args<'_>) -> Result<Name, Complaint> {
    let id = args.name("a fix id")?;
    if id.text.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_') && !id.text.is_empty() {
        Ok(id)
    } else {
        let message = format!("expected a fix id of letters, digits and underscores, got '{}'", id.text);
        Err(Complaint::new(id.word, message))
    }
}

/// `unfix ID` (doc page `unfix`).
#[derive(Clone, Debug, PartialEq)]
pub struct UnfixCommand {
    pub id: Name,
}

impl UnfixCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        Ok(Self { id: args.name("a fix id")? })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Command, tests::parse};

    #[test]
    fn words_keep_their_index() {
        let Command::Fix(fix) = parse("fix 1 mobile nve/limit 0.1").unwrap() else { unreachable!() };
        assert_eq!((fix.group.text.as_str(), fix.group.word), ("mobile", 2));
        assert_eq!((fix.style.word, fix.args[0].text.as_str(), fix.args[0].word), (3, "0.1", 4));
        assert!(parse("fix 1 all").unwrap_err().contains("expected a fix style, got the end of the line"));
        assert!(parse("fix a-b all nve").unwrap_err().contains("letters, digits and underscores, got 'a-b'"));
    }
}
