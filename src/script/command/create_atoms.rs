//! `create_atoms type style args keyword values ...` (LAMMPS doc page `create_atoms`).

use crate::script::{Args, Complaint, Name};
use crate::system::random::MAX_SEED;

/// Where the atoms go.
#[derive(Clone, Debug, PartialEq)]
pub enum CreateAtomsStyle {
    /// On every lattice point of the box.
    Box,
    /// On every lattice point of a region.
    Region(Name),
    /// One atom at a point.
    Single([f64; 3]),
    /// At random places of the box, or of the part of a region within it.
    Random { count: usize, seed: u32, region: Option<Name> },
}

/// A `create_atoms` command.
#[derive(Clone, Debug, PartialEq)]
pub struct CreateAtomsCommand {
    /// Atom type, from 1.
    pub kind: u32,
    pub style: CreateAtomsStyle,
    /// `basis M type`: M counts from 1; with the word of M.
    pub basis: Vec<BasisType>,
    /// `units lattice` (the default) against `units box`.
    pub lattice_units: bool,
}

/// The type of the atoms on one basis site of the lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BasisType {
    /// Basis atom, from 1.
    pub site: usize,
    pub kind: u32,
    /// Word of `site` in the statement; the type follows it.
    pub word: usize,
}

/// Words of the type and of the style.
pub const TYPE_WORD: usize = 1;
pub const STYLE_WORD: usize = 2;

const ABSENT: [&str; 13] = [
    "mol", "ratio", "subset", "remap", "var", "set", "radscale", "meshmode", "rotate", "overlap", "maxtry", "mesh",
    "temp",
];

impl CreateAtomsCommand {
    /// Reads the arguments.
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let kind = atom_type(args)?;
        let word = args.position();
        let style = match args.text("a style")? {
            "box" => CreateAtomsStyle::Box,
            "region" => CreateAtomsStyle::Region(args.name("a region ID")?),
            "single" => {
                let mut point = [0.0; 3];
                for c in &mut point {
                    *c = args.number("a coordinate")?;
                }
                CreateAtomsStyle::Single(point)
            }
            "random" => random(args)?,
            other => {
                return Err(Complaint::new(
                    word,
                    format!(
                        "create_atoms style '{other}' is not part of octant; available: box, region, single, random"
                    ),
                ));
            }
        };
        let mut command = Self { kind, style, basis: Vec::new(), lattice_units: true };
        while args.left() > 0 {
            let word = args.position();
            match args.text("a keyword")? {
                "units" => command.lattice_units = args.choice("units", &["lattice", "box"])? == 0,
                "basis" => {
                    let word = args.position();
                    let site = args.integer("the number of a basis atom", 1)?;
                    command.basis.push(BasisType { site: site as usize, kind: atom_type(args)?, word });
                }
                other if ABSENT.contains(&other) => {
                    return Err(Complaint::new(word, format!("create_atoms keyword '{other}' is not part of octant")));
                }
                other => return Err(Complaint::new(word, format!("expected units or basis, got '{other}'"))),
            }
        }
        Ok(command)
    }
}

fn random(args: &mut Args<'_>) -> Result<CreateAtomsStyle, Complaint> {
    let word = args.position();
    let count = args.integer("the number of atoms", 0)?;
    if count > i64::from(i32::MAX) {
        return Err(Complaint::new(word, format!("expected at most {} atoms, got {count}", i32::MAX)));
    }
    let seed = seed(args)?;
    let region = args.name("a region ID or NULL")?;
    let region = (region.text != "NULL").then_some(region);
    Ok(CreateAtomsStyle::Random { count: count as usize, seed, region })
}

/// An atom type: any whole number from 1; the scene knows how many there are.
fn atom_type(args: &mut Args<'_>) -> Result<u32, Complaint> {
    let word = args.position();
    let kind = args.integer("an atom type", 1)?;
    u32::try_from(kind).map_err(|_| Complaint::new(word, format!("expected an atom type, got '{kind}'")))
}

/// A seed of the random stream.
pub(crate) fn seed(args: &mut Args<'_>) -> Result<u32, Complaint> {
    let word = args.position();
    let seed = args.integer("a random seed", 1)?;
    match u32::try_from(seed) {
        Ok(s) if s <= MAX_SEED => Ok(s),
        _ => Err(Complaint::new(word, format!("expected a random seed, at most {MAX_SEED}, got '{seed}'"))),
    }
}
