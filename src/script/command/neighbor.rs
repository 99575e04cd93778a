//! Neighbor lists: `neighbor`, `neigh_modify`.

use crate::script::statement::{Args, Complaint};

/// `neighbor SKIN STYLE` (doc page `neighbor`). The style names LAMMPS's way of binning and does not change the list.
#[derive(Clone, Debug, PartialEq)]
pub struct NeighborCommand {
    /// Length units.
    pub skin: f64,
}

impl NeighborCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let skin = args.number_where("a skin", "of at least 0", |x| x >= 0.0)?;
        args.choice("a binning style", &["bin", "nsq", "multi", "multi/old"])?;
        Ok(Self { skin })
    }
}

/// `neigh_modify KEYWORD VALUE...` (doc page `neigh_modify`): what is not named stays as it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NeighModifyCommand {
    /// Steps after a build before the next may come.
    pub delay: Option<i64>,
    /// A build may come at multiples of this many steps after the last.
    pub every: Option<i64>,
    /// Build only if an atom moved more than half the skin.
    pub check: Option<bool>,
    /// Build at the start of a run only.
    pub once: Option<bool>,
}

impl NeighModifyCommand {
    /// `page`, `one` and `binsize` are sizes of LAMMPS's buffers and bins; octant chooses its own, and results do not depend on them.
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let mut command = Self::default();
        loop {
            let word = args.position();
            match args.text("a keyword")? {
                "delay" => command.delay = Some(args.integer("steps of delay", 0)?),
                "every" => command.every = Some(args.integer("steps between builds", 1)?),
                "check" => command.check = Some(args.yes_no("whether to check distances")?),
                "once" => command.once = Some(args.yes_no("whether to build once only")?),
                "page" | "one" => {
                    args.integer("a number of neighbors", 1)?;
                }
                "binsize" => {
                    args.number("a bin size")?;
                }
                name @ ("include" | "exclude" | "cluster" | "collection/interval" | "collection/type") => {
                    return Err(Complaint::new(word, format!("neigh_modify {name} is not part of octant")));
                }
                other => {
                    let message = format!("expected delay, every, check, once, page, one or binsize, got '{other}'");
                    return Err(Complaint::new(word, message));
                }
            }
            if args.left() == 0 {
                return Ok(command);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Command, tests::parse};
    use super::*;

    #[test]
    fn keywords_come_in_any_order() {
        let expected = NeighModifyCommand { delay: Some(10), every: Some(2), check: Some(false), once: None };
        assert_eq!(parse("neigh_modify check no page 5 every 2 delay 10"), Ok(Command::NeighModify(expected)));
        assert_eq!(parse("neighbor 0.3 bin"), Ok(Command::Neighbor(NeighborCommand { skin: 0.3 })));
        let error = |line| parse(line).unwrap_err();
        assert!(error("neigh_modify exclude group a b").contains("neigh_modify exclude is not part of octant"));
        assert!(error("neighbor -0.3 bin").contains("expected a skin of at least 0, got '-0.3'"));
        assert!(error("neighbor nan bin").contains("expected a skin, a finite number, got 'nan'"));
        assert!(error("neigh_modify every 0").contains("expected steps between builds, at least 1, got '0'"));
    }
}
