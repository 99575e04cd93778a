//! `write_data file keyword value ...` (LAMMPS doc page `write_data`).

use crate::script::{Args, Complaint, Name};

/// Which pair coefficients a data file carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairSection {
    /// `pair ii` (the default): one line a type; mixing fills the rest.
    Diagonal,
    /// `pair ij`: one line a pair of types.
    Full,
    /// `nocoeff`: none.
    Absent,
}

/// A `write_data` command.
#[derive(Clone, Debug, PartialEq)]
pub struct WriteDataCommand {
    /// File name; a `*` in it stands for the step.
    pub path: Name,
    pub pair: PairSection,
}

impl WriteDataCommand {
    /// Reads the arguments.
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let path = args.name("a file name")?;
        let (mut full, mut absent) = (false, false);
        while args.left() > 0 {
            let word = args.position();
            match args.text("a keyword")? {
                "pair" => full = args.choice("the pair section", &["ii", "ij"])? == 1,
                "nocoeff" => absent = true,
                // Fix data and type labels do not exist here, so leaving them out changes nothing.
                "nofix" | "nolabelmap" => {}
                "types" => {
                    if args.choice("the form of types", &["numeric", "labels"])? == 1 {
                        return Err(Complaint::new(word + 1, "type labels are not part of octant"));
                    }
                }
                "triclinic/general" => {
                    return Err(Complaint::new(word, "general triclinic boxes are not part of octant"));
                }
                other => {
                    return Err(Complaint::new(
                        word,
                        format!("expected pair, nocoeff, nofix, nolabelmap or types, got '{other}'"),
                    ));
                }
            }
        }
        let pair = match (absent, full) {
            (true, _) => PairSection::Absent,
            (false, true) => PairSection::Full,
            (false, false) => PairSection::Diagonal,
        };
        Ok(Self { path, pair })
    }

    /// The file name at a step.
    pub fn path_at(&self, step: i64) -> String {
        self.path.text.replacen('*', &step.to_string(), 1)
    }
}
