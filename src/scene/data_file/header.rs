//! The header of a data file: counts and the box.

use super::lines::{Line, Lines};
use crate::scene::create_box::check_bounds;
use crate::script::InputError;
use crate::script::command::create_box::MAX_TYPES;
use crate::system::Vec3;

/// Counts and bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    pub atoms: usize,
    pub types: usize,
    pub lo: Vec3,
    pub hi: Vec3,
}

/// Counts of things there are none of here; 0 of them is fine.
const ABSENT: [&str; 17] = [
    "bonds",
    "angles",
    "dihedrals",
    "impropers",
    "bond types",
    "angle types",
    "dihedral types",
    "improper types",
    "extra bond per atom",
    "extra angle per atom",
    "extra dihedral per atom",
    "extra improper per atom",
    "extra special per atom",
    "ellipsoids",
    "lines",
    "triangles",
    "bodies",
];
const AXES: [&str; 3] = ["xlo xhi", "ylo yhi", "zlo zhi"];
const TILTED: [&str; 5] = ["xy xz yz", "avec", "bvec", "cvec", "abc origin"];
const SECTION: &str = "header";

/// Reads title and header; returns the header with the first line after it, which names a section.
pub fn read_header<'a>(lines: &mut Lines<'a>) -> Result<(Header, Option<Line<'a>>), InputError> {
    let title = lines.title();
    let (mut atoms, mut types) = (None, None);
    let mut bounds: [Option<(f64, f64)>; 3] = [None; 3];
    let mut last_bounds = None;
    let after = loop {
        let Some(line) = lines.next() else { break None };
        let Some(keyword) = keyword(line.text) else { break Some(line) };
        let mut fields = lines.fields(SECTION, line);
        if let Some(axis) = AXES.iter().position(|a| *a == keyword) {
            let (low, high) =
                (fields.number("the low side of the box")?.0, fields.number("the high side of the box")?.0);
            if low >= high {
                let name = &AXES[axis][..1];
                let message =
                    format!("{SECTION}: the box has no extent along {name}: it goes from {low:?} to {high:?}");
                return Err(lines.error(line.text, message));
            }
            bounds[axis] = Some((low, high));
            last_bounds = Some(line);
        } else if keyword == "atoms" {
            atoms = Some(fields.integer("the number of atoms", 0, i32::MAX as usize)?.0);
        } else if keyword == "atom types" {
            types = Some(fields.integer("the number of atom types", 1, MAX_TYPES as usize)?.0);
        } else if TILTED.contains(&keyword.as_str()) {
            return Err(fields.error(line.text, "triclinic boxes are not part of octant".into()));
        } else {
            let (count, text) = fields.integer("a count", 0, i64::MAX)?;
            if count > 0 {
                return Err(fields.error(text, format!("{keyword} are not part of octant, got {count} of them")));
            }
        }
    };
    let missing = |what: &str| {
        if let Some(line) = after.filter(|line| line.text.starts_with(|c: char| !c.is_ascii_alphabetic())) {
            let message = format!("{SECTION}: expected a line such as '{what}' or a section, got '{}'", line.text);
            return lines.error(line.text, message);
        }
        let message = format!("{SECTION}: expected a line '{what}' before the first section, found none");
        let error = match after {
            Some(line) => lines.error(line.text, message),
            None => lines.error_at_end(message),
        };
        // A forgotten title swallows the first line of the header.
        match title.and_then(|t| keyword(t.text)) {
            Some(_) => error.with_help("the first line of a data file is a title and is not read"),
            None => error,
        }
    };
    let atoms = atoms.ok_or_else(|| missing("N atoms"))?;
    let types = types.ok_or_else(|| missing("N atom types"))?;
    let (mut lo, mut hi) = (Vec3::zeros(), Vec3::zeros());
    for axis in 0..3 {
        (lo[axis], hi[axis]) = bounds[axis].ok_or_else(|| missing(AXES[axis]))?;
    }
    check_bounds(&lo, &hi).map_err(|message| match last_bounds {
        Some(line) => lines.error(line.text, format!("{SECTION}: {message}")),
        None => lines.error_at_end(format!("{SECTION}: {message}")),
    })?;
    Ok((Header { atoms, types, lo, hi }, after))
}

/// The keyword a header line ends with; `None` when the line is no header line.
fn keyword(line: &str) -> Option<String> {
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let start = words.iter().position(|w| w.starts_with(|c: char| c.is_ascii_alphabetic()))?;
    let keyword = words[start..].join(" ");
    let known = ["atoms", "atom types"].iter().chain(&ABSENT).chain(&AXES).chain(&TILTED);
    (start > 0 && known.into_iter().any(|k| *k == keyword)).then_some(keyword)
}
