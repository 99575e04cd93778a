//! Commands that say what kind of simulation it is: `units`, `atom_style`, `atom_modify`, `dimension`, `boundary`, `newton`.

use crate::script::statement::{Args, Complaint};
use crate::system::units::UNITS;
use crate::system::{Side, Units};

/// `units STYLE` (doc page `units`).
#[derive(Clone, Debug, PartialEq)]
pub struct UnitsCommand {
    pub units: &'static Units,
}

/// Unit styles LAMMPS has and octant lacks.
const FOREIGN_UNITS: [&str; 4] = ["cgs", "electron", "micro", "nano"];

impl UnitsCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let word = args.position();
        let name = args.text("a unit style")?;
        let available = UNITS.map(|u| u.name).join(", ");
        let units = Units::named(name).ok_or_else(|| {
            Complaint::new(
                word,
                foreign_or_unknown("unit style", name, &FOREIGN_UNITS) + &format!("; available: {available}"),
            )
        })?;
        Ok(Self { units })
    }
}

/// `atom_style atomic` (doc page `atom_style`); octant has no other.
#[derive(Clone, Debug, PartialEq)]
pub struct AtomStyleCommand;

/// Atom styles LAMMPS has and octant lacks.
const FOREIGN_ATOM_STYLES: [&str; 34] = [
    "amoeba",
    "angle",
    "apip",
    "body",
    "bond",
    "bpm/sphere",
    "charge",
    "dielectric",
    "dipole",
    "dpd",
    "edpd",
    "electron",
    "ellipsoid",
    "full",
    "hybrid",
    "line",
    "mdpd",
    "mesont",
    "molecular",
    "oxdna",
    "peri",
    "rheo",
    "rheo/thermal",
    "smd",
    "sph",
    "sphere",
    "spin",
    "tdpd",
    "template",
    "tri",
    "wavepacket",
    "atomic/kk",
    "charge/kk",
    "full/kk",
];

impl AtomStyleCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let word = args.position();
        match args.text("an atom style")? {
            "atomic" => Ok(Self),
            name => {
                let message = foreign_or_unknown("atom style", name, &FOREIGN_ATOM_STYLES);
                Err(Complaint::new(word, message + "; available: atomic"))
            }
        }
    }
}

fn foreign_or_unknown(what: &str, name: &str, foreign: &[&str]) -> String {
    if foreign.contains(&name) {
        format!("{what} {name} is not part of octant")
    } else {
        format!("unknown {what} '{name}'")
    }
}

/// `atom_modify KEYWORD VALUE...` (doc page `atom_modify`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AtomModifyCommand {
    /// `sort N BINSIZE`: atoms are put in spatial order every N steps (0: never). Bins of size 0 are chosen by octant.
    pub sort: Option<(i64, f64)>,
}

impl AtomModifyCommand {
    /// `map` and `id yes` have no effect in octant: it always has ids, and finds atoms by them.
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let mut command = Self::default();
        loop {
            let word = args.position();
            match args.text("id, map or sort")? {
                "id" => {
                    if !args.yes_no("whether atoms have ids")? {
                        return Err(Complaint::new(word + 1, "atoms without ids are not part of octant"));
                    }
                }
                "map" => {
                    args.choice("a kind of map", &["yes", "array", "hash"])?;
                }
                "sort" => {
                    let every = args.integer("steps between sorts", 0)?;
                    let bin = args.number_where("a bin size", "of at least 0", |x| x >= 0.0)?;
                    command.sort = Some((every, bin));
                }
                "first" => return Err(Complaint::new(word, "atom_modify first is not part of octant")),
                other => return Err(Complaint::new(word, format!("expected id, map or sort, got '{other}'"))),
            }
            if args.left() == 0 {
                return Ok(command);
            }
        }
    }
}

/// `dimension 3` (doc page `dimension`); octant has no other.
#[derive(Clone, Debug, PartialEq)]
pub struct DimensionCommand;

impl DimensionCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let word = args.position();
        match args.integer("the number of dimensions", 0)? {
            3 => Ok(Self),
            2 => Err(Complaint::new(word, "two dimensions are not part of octant; available: 3")),
            n => Err(Complaint::new(word, format!("expected 3 dimensions, got {n}"))),
        }
    }
}

/// `boundary X Y Z` (doc page `boundary`).
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryCommand {
    /// `sides[axis] = [low side, high side]`; both or neither are periodic.
    pub sides: [[Side; 2]; 3],
}

impl BoundaryCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let mut sides = [[Side::Periodic; 2]; 3];
        for (pair, what) in sides.iter_mut().zip(["the x boundary", "the y boundary", "the z boundary"]) {
            let word = args.position();
            let text = args.text(what)?;
            let mut letters = text.chars();
            let (low, high) = match (letters.next(), letters.next(), letters.next()) {
                (Some(both), None, _) => (both, both),
                (Some(low), Some(high), None) => (low, high),
                _ => {
                    return Err(Complaint::new(
                        word,
                        format!("expected {what} of one or two letters p, f, s, got '{text}'"),
                    ));
                }
            };
            *pair = [side(low, word)?, side(high, word)?];
            if (pair[0] == Side::Periodic) != (pair[1] == Side::Periodic) {
                return Err(Complaint::new(word, format!("expected both sides periodic or neither, got '{text}'")));
            }
        }
        Ok(Self { sides })
    }
}

fn side(letter: char, word: usize) -> Result<Side, Complaint> {
    match letter {
        'p' => Ok(Side::Periodic),
        'f' => Ok(Side::Fixed),
        's' => Ok(Side::Shrink),
        'm' => Err(Complaint::new(word, "boundary m is not part of octant; available: p, f, s")),
        other => Err(Complaint::new(word, format!("expected one of p, f, s, got '{other}'"))),
    }
}

/// `newton PAIR [BOND]` (doc page `newton`). Results do not depend on it.
#[derive(Clone, Debug, PartialEq)]
pub struct NewtonCommand {
    pub pair: bool,
}

impl NewtonCommand {
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let pair = args.yes_no("newton for pairs")?;
        if args.left() > 0 {
            args.yes_no("newton for bonds")?;
        }
        Ok(Self { pair })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Command, tests::parse};
    use super::*;

    #[test]
    fn sides_are_read_one_by_one() {
        use Side::{Fixed, Periodic, Shrink};
        let Command::Boundary(boundary) = parse("boundary p fs s").unwrap() else { unreachable!() };
        assert_eq!(boundary.sides, [[Periodic, Periodic], [Fixed, Shrink], [Shrink, Shrink]]);
        let error = |line| parse(line).unwrap_err();
        assert_eq!(error("boundary p pf p"), "in:1:12: boundary: expected both sides periodic or neither, got 'pf'");
        assert_eq!(error("boundary p p m"), "in:1:14: boundary: boundary m is not part of octant; available: p, f, s");
        assert!(error("boundary p p").contains("expected the z boundary, got the end of the line"));
        assert!(error("boundary p p fsf").contains("one or two letters"));
    }

    #[test]
    fn what_octant_lacks_is_named() {
        let error = |line| parse(line).unwrap_err();
        assert!(error("units nano").ends_with("unit style nano is not part of octant; available: lj, real, metal, si"));
        assert!(error("units foo").contains("unknown unit style 'foo'"));
        assert!(error("atom_style full").ends_with("atom style full is not part of octant; available: atomic"));
        assert!(error("dimension 2").ends_with("two dimensions are not part of octant; available: 3"));
        assert!(error("atom_modify first all").ends_with("atom_modify first is not part of octant"));
        let sorted = Command::AtomModify(AtomModifyCommand { sort: Some((100, 1.5)) });
        assert_eq!(parse("atom_modify map array sort 100 1.5").unwrap(), sorted);
    }
}
