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
        let section = section_name(&lines, title, seen.last().copied())?;
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

/// The section a line opens; `last` is the one before it.
fn section_name(lines: &Lines<'_>, title: Line<'_>, last: Option<&str>) -> Result<&'static str, InputError> {
    let name = title.text.split_ascii_whitespace().collect::<Vec<_>>().join(" ");
    if let Some(section) = SECTIONS.iter().find(|s| **s == name) {
        return Ok(section);
    }
    let message = if ABSENT.contains(&name.as_str()) {
        format!("section {name} is not part of octant")
    } else {
        let shown: String = name.chars().take(40).collect();
        if let Some(last) = last.filter(|_| shown.starts_with(|c: char| !c.is_ascii_alphabetic())) {
            let message = format!("{last}: expected the end of the section, got '{shown}'");
            return Err(lines.error(title.text, message).with_help("are the counts in the header right?"));
        }
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
    if line.text.starts_with(|c: char| c.is_ascii_uppercase()) && section_name(lines, line, None).is_ok() {
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
    let edges = simulation_box.lengths();
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
            if (x[axis] - simulation_box.lo[axis]).abs() > FARTHEST * edges[axis] {
                let message = format!("expected a coordinate near the box, got '{}'", texts[axis]);
                return Err(fields.error(texts[axis], message));
            }
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
/// Box edges an atom may lie away from the box before that is a mistake.
const FARTHEST: f64 = 1.0e6;

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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const FILE: &str = "title\n\n3 atoms\n2 atom types\n0 10 xlo xhi\n0 10 ylo yhi\n0 10 zlo zhi\n\nMasses\n\n1 1.5\n2 2e-7\n\n\
        Pair Coeffs # lj/cut\n\n1 1 1\n2 2 1.5\n\n\
        Atoms # atomic\n\n1 1 1 1 1 0 0 0\n3 2 12.5 2 -3 0 1 -2 # odd\n2 1 3 3 3 0 0 0\n\n\
        Velocities\n\n1 1 2 3\n3 1 1 1\n2 0.1 0.2 0.3\n";
    const PERIODIC: [[Side; 2]; 3] = [[Side::Periodic; 2]; 3];

    fn read(text: &str, sides: [[Side; 2]; 3]) -> Result<DataFile, String> {
        read_data(&Source::new("f", text), sides).map_err(|error| error.to_string())
    }

    #[test]
    fn atoms_are_wrapped_and_counted() {
        let file = read(FILE, PERIODIC).unwrap();
        assert_eq!(file.masses, [Some(1.5), Some(2e-7)]);
        assert_eq!(file.state.id, [1, 3, 2]);
        assert_eq!(file.state.x[1], Vec3::new(2.5, 2.0, 7.0));
        assert_eq!(file.state.image[1], [1, 1, -3]);
        assert_eq!(file.state.v[2], Vec3::new(0.1, 0.2, 0.3));
        let coefficients = file.pair_coefficients.unwrap();
        assert_eq!(coefficients.style.unwrap().text, "lj/cut");
        assert_eq!(coefficients.lines[1][2].text, "1.5");
    }

    #[test]
    fn free_sides_follow_the_atoms_or_refuse_them() {
        let shrink = [[Side::Shrink; 2], PERIODIC[0], PERIODIC[0]];
        let file = read(&FILE.replace("12.5", "10"), shrink).unwrap();
        // Bounds of LAMMPS 22Jul2025.
        assert_eq!((file.simulation_box.lo.x, file.simulation_box.hi.x), (0.999, 10.001));
        assert_eq!(file.state.image[1], [0, 1, -3]);
        let fixed = [[Side::Fixed; 2], PERIODIC[0], PERIODIC[0]];
        let message = read(&FILE.replace("12.5", "10"), fixed).unwrap_err();
        assert_eq!(
            message,
            "f:22:5: Atoms: expected x from 0 to below 10, as the box is not periodic along x, got '10'"
        );
    }

    #[test]
    fn mistakes_have_their_place() {
        let mistakes = [
            ("3 atoms\n", "", "f:8:1: header: expected a line 'N atoms' before the first section, found none"),
            (
                "3 atoms",
                "3.5 atoms",
                "f:3:1: header: expected the number of atoms, a whole number from 0 to 2147483647",
            ),
            ("0 10 ylo yhi\n", "", "f:8:1: header: expected a line 'ylo yhi'"),
            ("3 atoms", "3 atoms\n2 bonds", "f:4:1: header: bonds are not part of octant, got 2 of them"),
            ("0 10 zlo zhi", "0 10 zlo zhi\n0 0 0 xy xz yz", "f:8:1: header: triclinic boxes are not part of octant"),
            ("2 2e-7", "2 -1", "f:12:3: Masses: expected a mass above 0, got '-1'"),
            ("2 2e-7\n", "", "f:13:1: Masses: expected 2 lines, got section Pair Coeffs after 1"),
            ("# atomic", "# full", "f:19:9: Atoms: atom style 'full' is not part of octant"),
            ("3 2 12.5", "1 2 12.5", "f:22:1: Atoms: atom id 1 stands here a second time"),
            ("3 2 12.5", "0 2 12.5", "f:22:1: Atoms: expected an atom id"),
            ("3 2 12.5", "3 3 12.5", "f:22:3: Atoms: expected an atom type, a whole number from 1 to 2, got '3'"),
            ("12.5", "nan", "f:22:5: Atoms: expected a coordinate, a finite number, got 'nan'"),
            ("12.5", "1e300", "f:22:5: Atoms: expected a coordinate near the box, got '1e300'"),
            ("0 1 -2", "", "f:22:12: Atoms: expected an image flag after '-3', got the end of the line"),
            ("2 1 3 3 3 0 0 0", "", "f:25:1: Atoms: expected 3 lines, got section Velocities after 2"),
            ("Velocities", "Bonds", "f:25:1: section Bonds is not part of octant"),
            ("Velocities", "Speeds", "f:25:1: expected a section, one of"),
            ("2 0.1 0.2", "7 0.1 0.2", "f:29:1: Velocities: expected the id of an atom of this file, got 7"),
            ("2 0.1 0.2 0.3\n", "", "f:28:8: Velocities: expected 3 lines, got the end of the file after 2"),
            (
                "0.2 0.3",
                "0.2",
                "f:29:7: Velocities: expected a velocity component after '0.2', got the end of the line",
            ),
        ];
        for (from, to, message) in mistakes {
            let text = FILE.replacen(from, to, 1);
            let error = read(&text, PERIODIC).expect_err(message);
            assert!(error.starts_with(message), "{error}\nis not\n{message}");
        }
    }

    proptest! {
        #[test]
        fn no_text_panics(at in 0..FILE.len(), cut in 0usize..20, insert in "[0-9a-zA-Z#. \n-]{0,8}") {
            let mut text = FILE.to_string();
            text.replace_range(at..(at + cut).min(FILE.len()), &insert);
            let _ = read(&text, PERIODIC);
            let _ = read(&text[..at], PERIODIC);
        }
    }
}
