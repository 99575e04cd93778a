//! Reading data files.

use std::sync::Arc;

use super::header::{Header, read_header};
use super::lines::{Fields, Line, Lines};
use super::{CoefficientSection, DataFile};
use crate::script::{InputError, Source, Word};
use crate::system::{Side, SimulationBox, State, Vec3};

/// The sections that are read.
const SECTIONS: [&str; 5] = ["Masses", "Pair Coeffs", "PairIJ Coeffs", "Atoms", "Velocities"];

/// Sections of other atom styles and of molecular topology.
const ABSENT: [&str; 34] = [
    "Atom Type Labels",
    "Bond Type Labels",
    "Angle Type Labels",
    "Dihedral Type Labels",
    "Improper Type Labels",
    "Bonds",
    "Angles",
    "Dihedrals",
    "Impropers",
    "Bond Coeffs",
    "Angle Coeffs",
    "Dihedral Coeffs",
    "Improper Coeffs",
    "BondBond Coeffs",
    "BondAngle Coeffs",
    "MiddleBondTorsion Coeffs",
    "EndBondTorsion Coeffs",
    "AngleTorsion Coeffs",
    "AngleAngleTorsion Coeffs",
    "BondBond13 Coeffs",
    "AngleAngle Coeffs",
    "Ellipsoids",
    "Lines",
    "Triangles",
    "Bodies",
    "Tinker Types",
    "CMAP",
    "Special Bonds",
    "Bond IDs",
    "Angle IDs",
    "Dihedral IDs",
    "Improper IDs",
    "Charges",
    "Molecules",
];

/// Reads a data file of atom style `atomic` for a box with these sides. Sections may come in any order, `Velocities` after `Atoms`.
/// Errors carry line and column: broken numbers, wrong counts, ids or types that cannot be, atoms outside of a free side,
/// sections of things octant lacks.
pub fn read_data(source: &Arc<Source>, sides: [[Side; 2]; 3]) -> Result<DataFile, InputError> {
    let mut lines = Lines::new(source);
    let (header, mut next) = read_header(&mut lines)?;
    let mut file = DataFile {
        source: source.clone(),
        simulation_box: SimulationBox::new(header.lo, header.hi, sides),
        types: header.types,
        masses: vec![None; header.types],
        pair_coefficients: None,
        pair_ij_coefficients: None,
        state: State::default(),
    };
    let mut seen: Vec<&str> = Vec::new();
    let mut atoms_by_id = Vec::new();
    while let Some(title) = next {
        let section = section_name(&lines, title)?;
        if seen.contains(&section) {
            return Err(lines.error(title.text, format!("section {section} stands here a second time")));
        }
        seen.push(section);
        match section {
            "Masses" => read_masses(&mut lines, &header, &mut file.masses)?,
            "Pair Coeffs" => file.pair_coefficients = Some(read_coefficients(&mut lines, &header, title, section, 1)?),
            "PairIJ Coeffs" => {
                file.pair_ij_coefficients = Some(read_coefficients(&mut lines, &header, title, section, 2)?);
            }
            "Atoms" => atoms_by_id = read_atoms(&mut lines, &header, title, &file.simulation_box, &mut file.state)?,
            _ => {
                if !seen.contains(&"Atoms") {
                    return Err(lines.error(title.text, "section Velocities must come after section Atoms".into()));
                }
                read_velocities(&mut lines, &atoms_by_id, &mut file.state)?;
            }
        }
        next = lines.next();
    }
    if header.atoms > 0 && !seen.contains(&"Atoms") {
        let message = format!("the header promises {} atoms, but there is no section Atoms", header.atoms);
        return Err(lines.error_at_end(message));
    }
    file.simulation_box.shrink_wrap(&file.state.x);
    Ok(file)
}

/// The section a line opens.
fn section_name(lines: &Lines<'_>, title: Line<'_>) -> Result<&'static str, InputError> {
    let name = title.text.split_ascii_whitespace().collect::<Vec<_>>().join(" ");
    if let Some(section) = SECTIONS.iter().find(|s| **s == name) {
        return Ok(section);
    }
    let message = if ABSENT.contains(&name.as_str()) {
        format!("section {name} is not part of octant")
    } else {
        let shown: String = name.chars().take(40).collect();
        format!("expected a section, one of {}, got '{shown}'", SECTIONS.join(", "))
    };
    Err(lines.error(title.text, message))
}

/// The next line of a section that has `count` of them, of which `read` are read.
fn section_line<'a>(
    lines: &mut Lines<'a>,
    section: &'static str,
    read: usize,
    count: usize,
) -> Result<Line<'a>, InputError> {
    let wanted = || format!("{section}: expected {count} lines, got");
    let Some(line) = lines.next() else {
        return Err(lines.error_at_end(format!("{} the end of the file after {read}", wanted())));
    };
    // Numbers start every line, so that a letter means the next section.
    if line.text.starts_with(|c: char| c.is_ascii_uppercase()) && section_name(lines, line).is_ok() {
        return Err(lines.error(line.text, format!("{} section {} after {read}", wanted(), line.text)));
    }
    Ok(line)
}

fn read_masses(lines: &mut Lines<'_>, header: &Header, masses: &mut [Option<f64>]) -> Result<(), InputError> {
    let section = "Masses";
    for read in 0..header.types {
        let line = section_line(lines, section, read, header.types)?;
        let mut fields = lines.fields(section, line);
        let (kind, word) = fields.integer("an atom type", 1, header.types)?;
        let (mass, text) = fields.number("a mass")?;
        if mass <= 0.0 {
            return Err(fields.error(text, format!("expected a mass above 0, got '{text}'")));
        }
        fields.done()?;
        if masses[kind - 1].replace(mass).is_some() {
            return Err(fields.error(word, format!("the mass of atom type {kind} stands here a second time")));
        }
    }
    Ok(())
}

/// Lines of `arity` types and coefficients.
fn read_coefficients(
    lines: &mut Lines<'_>,
    header: &Header,
    title: Line<'_>,
    section: &'static str,
    arity: usize,
) -> Result<CoefficientSection, InputError> {
    let count = if arity == 1 { header.types } else { header.types * (header.types + 1) / 2 };
    let mut coefficients = Vec::new();
    for read in 0..count {
        let line = section_line(lines, section, read, count)?;
        let mut fields = lines.fields(section, line);
        let words: Vec<Word> = fields.rest().map(|word| lines.word(word)).collect();
        for _ in 0..arity {
            fields.integer("an atom type", 1, header.types)?;
        }
        coefficients.push(words);
    }
    let style = title.comment.filter(|c| !c.is_empty()).map(|c| lines.word(c));
    Ok(CoefficientSection { title: lines.word(title.text), style, lines: coefficients })
}

/// Reads the atoms; returns their ids with their indices, in order of id.
fn read_atoms(
    lines: &mut Lines<'_>,
    header: &Header,
    title: Line<'_>,
    simulation_box: &SimulationBox,
    state: &mut State,
) -> Result<Vec<(u32, u32)>, InputError> {
    let section = "Atoms";
    if let Some(style) = title.comment.filter(|c| !c.is_empty() && *c != "atomic") {
        return Err(
            lines.error(style, format!("{section}: atom style '{style}' is not part of octant; available: atomic"))
        );
    }
    let most = header.types as u32;
    let mut places = Vec::new();
    let mut with_images = None;
    for read in 0..header.atoms {
        let line = section_line(lines, section, read, header.atoms)?;
        let mut fields = lines.fields(section, line);
        let (id, id_text) = fields.integer("an atom id", 1, i32::MAX as u32)?;
        let (kind, _) = fields.integer("an atom type", 1, most).map_err(|error| without_labels(line, error))?;
        let (mut x, mut texts) = (Vec3::zeros(), [""; 3]);
        for axis in 0..3 {
            (x[axis], texts[axis]) = fields.number("a coordinate")?;
        }
        // Image flags are there for all atoms or for none; the first line tells.
        let images = *with_images.get_or_insert_with(|| fields.rest().next().is_some());
        let mut image = [0i32; 3];
        if images {
            for flag in &mut image {
                *flag = fields.integer("an image flag", -MAX_IMAGE, MAX_IMAGE)?.0;
            }
        }
        fields.done()?;
        simulation_box.wrap(&mut x, &mut image);
        for axis in 0..3 {
            if !simulation_box.periodic(axis) {
                image[axis] = 0;
            }
            check_inside(&fields, simulation_box, axis, x[axis], texts[axis])?;
        }
        state.push(id, kind, x);
        if let Some(last) = state.image.last_mut() {
            *last = image;
        }
        places.push(id_text);
    }
    index_by_id(lines, section, state, &places)
}

/// Image flags beyond this are a mistake; the bound keeps later counting from overflowing.
const MAX_IMAGE: i32 = 1 << 28;

fn without_labels(line: Line<'_>, error: InputError) -> InputError {
    match line.text.split_ascii_whitespace().nth(1) {
        Some(word) if word.starts_with(|c: char| c.is_ascii_alphabetic()) => {
            error.with_help("type labels are not part of octant; give the number of the type")
        }
        _ => error,
    }
}

/// Free sides lose what lies beyond them, so such atoms cannot be taken.
fn check_inside(
    fields: &Fields<'_, '_>,
    simulation_box: &SimulationBox,
    axis: usize,
    x: f64,
    text: &str,
) -> Result<(), InputError> {
    let (lo, hi) = (simulation_box.lo[axis], simulation_box.hi[axis]);
    if simulation_box.periodic(axis) || (lo..hi).contains(&x) {
        return Ok(());
    }
    let name = ["x", "y", "z"][axis];
    let message =
        format!("expected {name} from {lo} to below {hi}, as the box is not periodic along {name}, got '{text}'");
    Err(fields.error(text, message))
}

/// Ids with storage indices, sorted; an id that stands twice is an error at its second place.
fn index_by_id(
    lines: &Lines<'_>,
    section: &str,
    state: &State,
    places: &[&str],
) -> Result<Vec<(u32, u32)>, InputError> {
    let mut index: Vec<(u32, u32)> = state.id.iter().copied().zip(0..).collect();
    index.sort_unstable();
    let twice = index.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1).min();
    match twice {
        None => Ok(index),
        Some(k) => {
            let place = places[k as usize];
            Err(lines.error(place, format!("{section}: atom id {place} stands here a second time")))
        }
    }
}

fn read_velocities(lines: &mut Lines<'_>, index: &[(u32, u32)], state: &mut State) -> Result<(), InputError> {
    let section = "Velocities";
    let mut given = vec![false; state.len()];
    for read in 0..state.len() {
        let line = section_line(lines, section, read, state.len())?;
        let mut fields = lines.fields(section, line);
        let (id, text) = fields.integer("an atom id", 1, i32::MAX as u32)?;
        let Ok(place) = index.binary_search_by_key(&id, |entry| entry.0) else {
            return Err(fields.error(text, format!("expected the id of an atom of this file, got {id}")));
        };
        let k = index[place].1 as usize;
        if std::mem::replace(&mut given[k], true) {
            return Err(fields.error(text, format!("the velocity of atom {id} stands here a second time")));
        }
        for axis in 0..3 {
            state.v[k][axis] = fields.number("a velocity component")?.0;
        }
        fields.done()?;
    }
    Ok(())
}
