//! Tables of a pair potential, as LAMMPS's `pair_write` writes and its `pair_style table` reads them (LAMMPS doc pages
//! `pair_write`, `pair_table`).

use std::fmt::Write as _;
use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::path::Path;

use super::calendar::today;
use super::printf::format_g;
use crate::pair::PairTable;

/// How the distances of a table lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// Evenly in r.
    Distance,
    /// Evenly in r^2.
    Square,
}

impl Spacing {
    /// Names in the `pair_write` command, in the order of [`Spacing::ALL`].
    pub const NAMES: [&'static str; 2] = ["r", "rsq"];
    pub const ALL: [Spacing; 2] = [Spacing::Distance, Spacing::Square];

    /// Name in the file.
    fn title(self) -> &'static str {
        ["R", "RSQ"][self as usize]
    }

    /// Distance `k` of `count` from `inner` to `outer`, length units.
    fn distance(self, k: usize, count: usize, inner: f64, outer: f64) -> f64 {
        let part = k as f64 / (count - 1) as f64;
        match self {
            Spacing::Distance => inner + (outer - inner) * part,
            Spacing::Square => (inner * inner + (outer * outer - inner * inner) * part).sqrt(),
        }
    }
}

/// One table of a file.
#[derive(Clone, Copy, Debug)]
pub struct Section<'a> {
    pub pair: &'a PairTable,
    /// Types from 0.
    pub types: [usize; 2],
    /// Name that the file knows it by.
    pub keyword: &'a str,
    pub spacing: Spacing,
    /// Rows, at least 2.
    pub count: usize,
    /// First and last distance, length units.
    pub inner: f64,
    pub outer: f64,
}

impl Section<'_> {
    /// Energy and force at each distance; both are 0 from the cutoff on.
    fn text(&self) -> String {
        let Self { pair, types: [i, j], keyword, spacing, count, inner, outer } = *self;
        let number = |x: f64| format_g(x, 0, 15, false);
        let mut text = format!(
            "# Pair potential {} for atom types {} {}: i,r,energy,force\n\n{keyword}\nN {count} {} {} {}\n\n",
            pair.style,
            i + 1,
            j + 1,
            spacing.title(),
            number(inner),
            number(outer),
        );
        for k in 0..count {
            let r = spacing.distance(k, count, inner, outer);
            let (energy, force) =
                pair.evaluate(i, j, r).map_or((0.0, 0.0), |value| (value.energy, value.force_over_r * r));
            let column = |x: f64| format_g(x, 22, 15, true);
            let _ = writeln!(text, "{:>8}  {} {} {}", k + 1, column(r), column(energy), column(force));
        }
        text
    }

    /// Adds the table to the end of a file, which may be new, and says which it was. Refuses a file whose first line names other
    /// units.
    pub fn append(&self, path: &Path, units: &str) -> Result<String, String> {
        let shown = path.display();
        let cannot = |e: std::io::Error| format!("cannot write '{shown}': {e}");
        let old = match fs::read(path) {
            Ok(bytes) => Some(String::from_utf8_lossy(&bytes).into_owned()),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => None,
            Err(e) => return Err(cannot(e)),
        };
        check_units(old.as_deref().unwrap_or_default(), units).map_err(|message| format!("'{shown}' {message}"))?;
        let (said, head) = match old {
            Some(_) => ("Appending to", String::new()),
            None => ("Creating", format!("# DATE: {} UNITS: {units} Created by pair_write\n", today())),
        };
        let file = OpenOptions::new().create(true).append(true).open(path);
        file.and_then(|mut file| file.write_all((head + &self.text()).as_bytes())).map_err(cannot)?;
        Ok(format!("{said} table file {shown}"))
    }
}

/// Whether tables in these units may be added to a file with this text.
pub fn check_units(text: &str, units: &str) -> Result<(), String> {
    let mut words =
        text.lines().next().unwrap_or_default().split_whitespace().skip_while(|word| *word != "UNITS:").skip(1);
    match words.next() {
        Some(other) if other != units => Err(format!("holds tables in {other} units, not in {units}")),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair::PairCoefficients;

    /// Rows that LAMMPS 22Jul2025 writes for `pair_style lj/cut 2.0`, `pair_coeff * * 1.0 1.0`.
    #[test]
    fn tables_are_those_of_lammps() {
        let mut pair = PairCoefficients::new("lj/cut", 2.0, 2).unwrap();
        pair.set((1, 2), (1, 2), &["1.0", "1.0"]).unwrap();
        let pair = pair.complete().unwrap().0;
        let section = Section {
            pair: &pair,
            types: [0, 0],
            keyword: "A",
            spacing: Spacing::Distance,
            count: 4,
            inner: 1.0,
            outer: 2.5,
        };
        assert_eq!(
            section.text(),
            "# Pair potential lj/cut for atom types 1 1: i,r,energy,force\n\nA\nN 4 R 1 2.5\n\n       \
             1  1                      0                      24                    \n       \
             2  1.5                    -0.320336594278575     -1.15802883104616     \n       \
             3  2                      0                      0                     \n       \
             4  2.5                    0                      0                     \n"
        );
        let squares =
            Section { types: [0, 1], keyword: "B", spacing: Spacing::Square, count: 3, outer: 2.0, ..section };
        let text = squares.text();
        assert!(text.starts_with("# Pair potential lj/cut for atom types 1 2: i,r,energy,force\n\nB\nN 3 RSQ 1 2\n\n"));
        assert!(
            text.contains("\n       2  1.58113883008419       -0.239616              -0.847105879961649    \n"),
            "{text}"
        );
    }

    #[test]
    fn units_must_be_those_of_the_file() {
        let head = "# DATE: 2026-11-26 UNITS: real Created by pair_write\n\nUNITS: lj\n";
        assert!(
            check_units(head, "real").is_ok() && check_units("", "lj").is_ok() && check_units("old\n", "lj").is_ok()
        );
        assert_eq!(check_units(head, "lj"), Err("holds tables in real units, not in lj".into()));
    }
}
