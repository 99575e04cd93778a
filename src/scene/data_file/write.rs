//! Writing data files.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

use crate::output::write_whole;
use crate::system::{SimulationBox, State};

/// The pair coefficients of a data file, as the pair style prints them.
#[derive(Clone, Debug, PartialEq)]
pub struct CoefficientLines {
    /// Name of the pair style, such as `lj/cut`.
    pub style: String,
    /// `pair ij`: lines start with two types; else (`pair ii`) with one.
    pub full: bool,
    /// Types and coefficients of each line, without the end of the line.
    pub lines: Vec<String>,
}

/// What a data file holds.
#[derive(Clone, Copy, Debug)]
pub struct WriteData<'a> {
    pub step: i64,
    /// Name of the unit system.
    pub units: &'a str,
    pub state: &'a State,
    pub simulation_box: &'a SimulationBox,
    /// Indexed by type - 1, one entry a type; the section is left out unless all are set.
    pub masses: &'a [Option<f64>],
    /// `None` leaves the section out.
    pub pair: Option<&'a CoefficientLines>,
}

/// Writes a data file in LAMMPS's layout: atoms in storage order, wrapped into the box, shrink-wrapped sides at the atoms;
/// numbers have the digits that read back to the same bits. The file appears whole or not at all.
pub fn write_data(path: &Path, data: &WriteData<'_>) -> io::Result<()> {
    write_whole(path, |out| write_to(out, data))
}

fn write_to(out: &mut dyn Write, data: &WriteData<'_>) -> io::Result<()> {
    let state = data.state;
    let (mut x, mut image) = (state.x.clone(), state.image.clone());
    for (x, image) in x.iter_mut().zip(&mut image) {
        data.simulation_box.wrap(x, image);
    }
    let mut simulation_box = data.simulation_box.clone();
    simulation_box.shrink_wrap(&x);

    writeln!(
        out,
        "LAMMPS data file via write_data, version octant {}, timestep = {}, units = {}\n",
        env!("CARGO_PKG_VERSION"),
        data.step,
        data.units
    )?;
    writeln!(out, "{} atoms\n{} atom types\n", state.len(), data.masses.len())?;
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let (lo, hi) = (simulation_box.lo[axis], simulation_box.hi[axis]);
        writeln!(out, "{} {} {name}lo {name}hi", Shortest(lo), Shortest(hi))?;
    }
    if let Some(masses) = data.masses.iter().copied().collect::<Option<Vec<f64>>>() {
        writeln!(out, "\nMasses\n")?;
        for (k, mass) in masses.iter().enumerate() {
            writeln!(out, "{} {}", k + 1, Shortest(*mass))?;
        }
    }
    if let Some(pair) = data.pair {
        let title = if pair.full { "PairIJ Coeffs" } else { "Pair Coeffs" };
        writeln!(out, "\n{title} # {}\n", pair.style)?;
        for line in &pair.lines {
            writeln!(out, "{line}")?;
        }
    }
    if !state.is_empty() {
        writeln!(out, "\nAtoms # atomic\n")?;
        let mut line = String::new();
        for k in 0..state.len() {
            line.clear();
            let _ = write!(line, "{} {}", state.id[k], state.kind[k]);
            x[k].iter().for_each(|c| push_number(&mut line, *c));
            let [a, b, c] = image[k];
            writeln!(out, "{line} {a} {b} {c}")?;
        }
        writeln!(out, "\nVelocities\n")?;
        for k in 0..state.len() {
            line.clear();
            let _ = write!(line, "{}", state.id[k]);
            state.v[k].iter().for_each(|c| push_number(&mut line, *c));
            writeln!(out, "{line}")?;
        }
    }
    out.flush()
}

fn push_number(line: &mut String, x: f64) {
    // Writing to a string cannot fail.
    let _ = write!(line, " {}", Shortest(x));
}

/// A number in as few digits as read back to the same bits, with an exponent below 1e-4 and from 1e16 on.
struct Shortest(f64);

impl std::fmt::Display for Shortest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let x = self.0;
        if x == 0.0 || (x.abs() >= 1.0e-4 && x.abs() < 1.0e16) || !x.is_finite() {
            return write!(f, "{x}");
        }
        let text = format!("{x:e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let (sign, digits) = exponent.strip_prefix('-').map_or(('+', exponent), |digits| ('-', digits));
        write!(f, "{mantissa}e{sign}{digits:0>2}")
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::scene::data_file::read_data;
    use crate::script::Source;
    use crate::system::{Side, Vec3};

    #[test]
    fn numbers_look_as_in_the_files_of_lammps() {
        let text = |x: f64| Shortest(x).to_string();
        assert_eq!(text(0.0), "0");
        assert_eq!(text(-0.0), "-0");
        assert_eq!(text(1.0), "1");
        assert_eq!(text(0.1 + 0.2), "0.30000000000000004");
        assert_eq!(text(0.0001), "0.0001");
        assert_eq!(text(0.00001234), "1.234e-05");
        assert_eq!(text(-1.5e-300), "-1.5e-300");
        assert_eq!(text(1.0e15), "1000000000000000");
        assert_eq!(text(1.0e16), "1e+16");
    }

    #[test]
    fn files_read_back_to_the_same_bits() {
        let mut state = State::default();
        state.push(2, 1, Vec3::new(0.1 + 0.2, 1.0 / 3.0, 9.999999999999998));
        state.push(1, 2, Vec3::new(-1.25, 12.0, 1.0e-7));
        state.v[0] = Vec3::new(1.0e-5, -0.0, 2.0f64.sqrt());
        state.image[1] = [2, 0, 0];
        let sides = [[Side::Periodic; 2], [Side::Shrink; 2], [Side::Fixed; 2]];
        let mut simulation_box = SimulationBox::new(Vec3::repeat(-0.5), Vec3::repeat(10.5), sides);
        let pair =
            CoefficientLines { style: "lj/cut".into(), full: false, lines: vec!["1 1 1".into(), "2 0.5 1.1".into()] };
        let masses = [Some(1.0), Some(39.948)];
        let data = WriteData {
            step: 7,
            units: "metal",
            state: &state,
            simulation_box: &simulation_box,
            masses: &masses,
            pair: Some(&pair),
        };
        let mut out = Vec::new();
        write_to(&mut out, &data).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(text.contains("timestep = 7, units = metal\n\n2 atoms\n2 atom types\n\n-0.5 10.5 xlo xhi\n"));
        assert!(
            text.contains(
                "\nMasses\n\n1 1\n2 39.948\n\nPair Coeffs # lj/cut\n\n1 1 1\n2 0.5 1.1\n\nAtoms # atomic\n\n"
            )
        );
        assert!(text.ends_with("1 2 9.75 12 1e-07 1 0 0\n\nVelocities\n\n2 1e-05 -0 1.4142135623730951\n1 0 0 0\n"));
        let read = read_data(&Source::new("f", text), sides).unwrap();
        assert_eq!(read.state.x[0], state.x[0]);
        assert_eq!(read.state.v, state.v);
        assert_eq!(read.masses, masses);
        simulation_box.shrink_wrap(&state.x);
        assert!((read.simulation_box.hi.y - simulation_box.hi.y).abs() < 1e-3);
    }

    #[test]
    fn a_file_that_cannot_be_written_leaves_nothing_behind() {
        let state = State::default();
        let simulation_box = SimulationBox::new(Vec3::zeros(), Vec3::repeat(1.0), [[Side::Periodic; 2]; 3]);
        let data = WriteData {
            step: 0,
            units: "lj",
            state: &state,
            simulation_box: &simulation_box,
            masses: &[None],
            pair: None,
        };
        let folder = std::env::temp_dir().join(format!("octant-write-data-{}", std::process::id()));
        assert!(write_data(&folder.join("a.data"), &data).is_err());
        fs::create_dir_all(&folder).unwrap();
        write_data(&folder.join("a.data"), &data).unwrap();
        let names: Vec<_> = fs::read_dir(&folder).unwrap().map(|e| e.unwrap().file_name()).collect();
        fs::remove_dir_all(&folder).unwrap();
        assert_eq!(names, ["a.data"]);
    }
}
