//! What goes to screen, log and files: `log`, `print`, `echo`.

use crate::script::statement::{Args, Complaint, Name};

/// `log FILE [append]`, `log none` (doc page `log`).
#[derive(Clone, Debug, PartialEq)]
pub struct LogCommand {
    /// `None` for no log.
    pub file: Option<Name>,
    pub append: bool,
}

impl LogCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let file = args.name("a file name")?;
        let append = args.left() > 0;
        if append {
            args.choice("a keyword", &["append"])?;
        }
        Ok(Self { file: (file.text != "none").then_some(file), append })
    }
}

/// `print TEXT [file FILE] [append FILE] [screen yes|no] [universe yes|no]` (doc page `print`). The text comes with its values filled in.
#[derive(Clone, Debug, PartialEq)]
pub struct PrintCommand {
    pub text: String,
    /// File that gets the text too, and whether it is appended to.
    pub file: Option<(Name, bool)>,
    pub screen: bool,
}

impl PrintCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let mut command = Self { text: args.text("a text")?.to_string(), file: None, screen: true };
        while args.left() > 0 {
            match args.choice("a keyword", &["file", "append", "screen", "universe"])? {
                0 => command.file = Some((args.name("a file name")?, false)),
                1 => command.file = Some((args.name("a file name")?, true)),
                2 => command.screen = args.yes_no("whether to print on the screen")?,
                _ => {
                    args.yes_no("whether to print in the universe")?; // there is one partition only
                }
            }
        }
        Ok(command)
    }
}

/// `echo none|screen|log|both` (doc page `echo`): where input lines are repeated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EchoCommand {
    pub screen: bool,
    pub log: bool,
}

impl EchoCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let choice = args.choice("where to echo", &["none", "screen", "log", "both"])?;
        Ok(Self { screen: choice == 1 || choice == 3, log: choice >= 2 })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Command, tests::parse};
    use super::*;

    #[test]
    fn texts_and_files() {
        let Command::Print(print) = parse("print 'a b' append x.txt screen no").unwrap() else { unreachable!() };
        assert_eq!((print.text.as_str(), print.screen), ("a b", false));
        assert_eq!(print.file, Some((Name { text: "x.txt".into(), word: 3 }, true)));
        assert_eq!(parse("log none"), Ok(Command::Log(LogCommand { file: None, append: false })));
        assert_eq!(parse("echo both"), Ok(Command::Echo(EchoCommand { screen: true, log: true })));
        assert_eq!(parse("echo screen"), Ok(Command::Echo(EchoCommand { screen: true, log: false })));
        assert!(parse("print a b").unwrap_err().contains("expected a keyword, one of file, append"));
    }
}
