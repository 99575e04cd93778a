//! `read_data file keyword args ...` (LAMMPS doc page `read_data`).

use crate::script::{Args, Complaint, Name};

/// A `read_data` command.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadDataCommand {
    pub path: Name,
    /// `nocoeff`: pair coefficients in the file are passed over.
    pub no_coefficients: bool,
    /// `extra/atom/types`: types beyond those of the file.
    pub extra_types: usize,
    /// `group`: the group that the file's atoms join.
    pub group: Option<Name>,
}

const ABSENT: [&str; 10] = [
    "add",
    "offset",
    "shift",
    "fix",
    "extra/bond/types",
    "extra/angle/types",
    "extra/dihedral/types",
    "extra/improper/types",
    "extra/bond/per/atom",
    "extra/special/per/atom",
];

impl ReadDataCommand {
    /// Reads the arguments.
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let path = args.name("a file name")?;
        let mut command = Self { path, no_coefficients: false, extra_types: 0, group: None };
        while args.left() > 0 {
            let word = args.position();
            match args.text("a keyword")? {
                "nocoeff" => command.no_coefficients = true,
                "extra/atom/types" => {
                    let word = args.position();
                    let extra = args.integer("a number of atom types", 0)?;
                    if extra > super::create_box::MAX_TYPES {
                        return Err(Complaint::new(word, format!("expected a number of atom types, got {extra}")));
                    }
                    command.extra_types = extra as usize;
                }
                "group" => command.group = Some(args.name("a group ID")?),
                other if ABSENT.contains(&other) => {
                    return Err(Complaint::new(word, format!("read_data keyword '{other}' is not part of octant")));
                }
                other => {
                    return Err(Complaint::new(
                        word,
                        format!("expected nocoeff, extra/atom/types or group, got '{other}'"),
                    ));
                }
            }
        }
        Ok(command)
    }
}
