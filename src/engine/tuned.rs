//! The table of choices by architecture, precision and number of atoms, made by a tuning run (`octant bench --tune`); nothing is
//! timed while a user's run goes on.

use std::fmt::Write as _;
use std::sync::LazyLock;

use super::Precision;

/// The table that this octant was built with.
static BUILT_IN: LazyLock<Table> =
    LazyLock::new(|| Table::read(include_str!("tuned.txt")).expect("the table that is built in can be read"));

/// What an architecture without any row of its kind gets, sigma: the skin of the benchmark's script.
const PLAIN_SKIN: f64 = 0.3;

/// Columns before the words that say where a row is from.
const NUMBERS: usize = 9;

/// What the kernels of a GPU are made with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choices {
    /// Threads that share a particle's row in the force stage.
    pub lanes: u32,
    /// Particles of an octant that a warp lists together.
    pub group: u32,
    /// Warps that share an octant.
    pub slices: u32,
    /// Blocks that are to fit on a multiprocessor at least: bounds the registers of a thread.
    pub blocks: u32,
    /// Chunks of a row that are on their way to the second-level cache before they are read.
    pub ahead: u32,
}

/// What a tuning run found best at a size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    pub skin: f64,
    /// `None` where there was nothing to choose.
    pub choices: Option<Choices>,
}

/// Where the table leaves a choice open.
const PLAIN: Choices = Choices { lanes: 2, group: 32, slices: 1, blocks: 3, ahead: 0 };

/// Choices from a number of atoms on.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// As the backend names it ("sm_90"), or "cpu".
    pub architecture: String,
    pub precision: Precision,
    /// The smallest number of atoms that the row is for.
    pub atoms: usize,
    /// Threads that share a particle's row in the force stage.
    pub lanes: Option<u32>,
    /// Particles of an octant that a warp lists together.
    pub group: Option<u32>,
    /// Warps that share an octant.
    pub slices: Option<u32>,
    /// Blocks that are to fit on a multiprocessor at least.
    pub blocks: Option<u32>,
    /// Chunks of a row that are on their way to the second-level cache before they are read.
    pub ahead: Option<u32>,
    /// Skin of the benchmark, sigma.
    pub skin: f64,
    /// Where the row is from.
    pub from: String,
}

/// All rows, those of an architecture and precision together and by number of atoms.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// What stands above the rows.
    head: String,
    pub rows: Vec<Row>,
}

impl Table {
    /// The table that this octant was built with.
    pub fn built_in() -> &'static Self {
        &BUILT_IN
    }

    /// Reads the text of a table; the error names the line that is wrong.
    pub fn read(text: &str) -> Result<Self, String> {
        let mut table = Self::default();
        for (k, line) in text.lines().enumerate() {
            if line.starts_with('#') || line.trim().is_empty() {
                if table.rows.is_empty() {
                    table.head += line;
                    table.head.push('\n');
                }
                continue;
            }
            table.rows.push(Row::read(line).ok_or_else(|| format!("line {}: expected a row, got '{line}'", k + 1))?);
        }
        Ok(table)
    }

    /// The row for so many atoms; `None` where no architecture of the kind is known.
    pub fn row(&self, architecture: &str, precision: Precision, atoms: usize) -> Option<&Row> {
        let known = self.nearest(architecture)?;
        self.of(known, precision).filter(|row| row.atoms <= atoms).last()
    }

    /// What the kernels for so many atoms are made with.
    pub fn choices(&self, architecture: &str, precision: Precision, atoms: usize) -> Choices {
        let row = self.row(architecture, precision, atoms);
        let choice = |of: fn(&Row) -> Option<u32>, plain: u32| row.and_then(of).unwrap_or(plain);
        Choices {
            lanes: choice(|row| row.lanes, PLAIN.lanes),
            group: choice(|row| row.group, PLAIN.group),
            slices: choice(|row| row.slices, PLAIN.slices),
            blocks: choice(|row| row.blocks, PLAIN.blocks),
            ahead: choice(|row| row.ahead, PLAIN.ahead),
        }
    }

    /// Skin of the benchmark for so many atoms, sigma.
    pub fn skin(&self, architecture: &str, precision: Precision, atoms: usize) -> f64 {
        self.row(architecture, precision, atoms).map_or(PLAIN_SKIN, |row| row.skin)
    }

    /// Takes over what was found best from numbers of atoms on, ascending; choices that were not tried stay what they were.
    pub fn set(&mut self, architecture: &str, precision: Precision, found: &[(usize, Found)], from: &str) {
        let known: Vec<Row> =
            self.nearest(architecture).map(|known| self.of(known, precision).cloned().collect()).unwrap_or_default();
        let mut starts: Vec<usize> = known.iter().map(|row| row.atoms).chain(found.iter().map(|f| f.0)).collect();
        starts.push(0);
        starts.sort_unstable();
        starts.dedup();
        let mut fresh: Vec<Row> = Vec::new();
        for atoms in starts {
            let best = found.iter().take_while(|f| f.0 <= atoms).last().or(found.first()).map(|f| f.1);
            let old = known.iter().rfind(|row| row.atoms <= atoms);
            let tried = best.and_then(|best| best.choices);
            let choice = |new: fn(Choices) -> u32, old_one: fn(&Row) -> Option<u32>| {
                tried.map(new).or_else(|| old.and_then(old_one))
            };
            let row = Row {
                architecture: architecture.to_string(),
                precision,
                atoms,
                lanes: choice(|new| new.lanes, |old| old.lanes),
                group: choice(|new| new.group, |old| old.group),
                slices: choice(|new| new.slices, |old| old.slices),
                blocks: choice(|new| new.blocks, |old| old.blocks),
                ahead: choice(|new| new.ahead, |old| old.ahead),
                skin: best.map_or(PLAIN_SKIN, |best| best.skin),
                from: from.to_string(),
            };
            if fresh.last().is_none_or(|last| Row { atoms, ..last.clone() } != row) {
                fresh.push(row);
            }
        }
        let own = |row: &Row| row.architecture == architecture && row.precision == precision;
        let place = self.rows.iter().position(own).unwrap_or(self.rows.len());
        self.rows.retain(|row| !own(row));
        self.rows.splice(place..place, fresh);
    }

    /// The table as text.
    pub fn text(&self) -> String {
        let mut text = self.head.clone();
        for row in &self.rows {
            let Row { architecture, precision, atoms, lanes, group, slices, blocks, ahead, skin, from } = row;
            let number = |n: &Option<u32>| n.map_or("-".into(), |n| n.to_string());
            let kernels = [lanes, group, slices, blocks, ahead].map(number).join(" ");
            let _ = writeln!(text, "{architecture:<5} {:<6} {atoms} {kernels} {skin} {from}", precision.name());
        }
        text
    }

    fn of(&self, architecture: &str, precision: Precision) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.architecture == architecture && row.precision == precision)
    }

    /// The architecture itself, or the last one of its kind.
    fn nearest(&self, architecture: &str) -> Option<&str> {
        let kind = |name: &str| name.split('_').next().unwrap_or_default().to_string();
        let same = self.rows.iter().find(|row| row.architecture == architecture);
        let alike = || self.rows.iter().rfind(|row| kind(&row.architecture) == kind(architecture));
        same.or_else(alike).map(|row| row.architecture.as_str())
    }
}

impl Row {
    fn read(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |k: usize| match words.get(k) {
            Some(&"-") => Some(None),
            Some(word) => word.parse().ok().map(Some),
            None => None,
        };
        Some(Self {
            architecture: words.first()?.to_string(),
            precision: Precision::ALL.into_iter().find(|p| Some(&p.name()) == words.get(1))?,
            atoms: words.get(2)?.parse().ok()?,
            lanes: number(3)?,
            group: number(4)?,
            slices: number(5)?,
            blocks: number(6)?,
            ahead: number(7)?,
            skin: words.get(8)?.parse().ok().filter(|skin: &f64| *skin > 0.0 && skin.is_finite())?,
            from: words[NUMBERS..].join(" "),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# head\nsm_80 mixed 0 16 2 16 3 0 0.4 a card\nsm_80 mixed 12000 4 16 2 3 1 0.4 a card\n\
                        sm_90 mixed 0 8 2 16 3 0 0.5 another\ncpu mixed 0 - - - - - 0.3 by hand\n";

    #[test]
    fn the_built_in_table_has_rows_from_no_atoms_on() {
        let table = Table::built_in();
        for first in &table.rows {
            let mut same = table.of(&first.architecture, first.precision);
            assert_eq!(same.next().unwrap().atoms, 0);
            assert!(table.of(&first.architecture, first.precision).is_sorted_by_key(|row| row.atoms));
        }
        for precision in Precision::ALL {
            assert!(table.row("cpu", precision, 1).is_some() && table.row("sm_90", precision, 1).is_some());
        }
    }

    #[test]
    fn rows_are_found_by_number_of_atoms_and_kind() {
        let table = Table::read(TEXT).unwrap();
        let lanes = |architecture, atoms| table.row(architecture, Precision::Mixed, atoms).and_then(|row| row.lanes);
        assert_eq!((lanes("sm_80", 11_999), lanes("sm_80", 12_000)), (Some(16), Some(4)));
        assert_eq!(lanes("sm_120", 1), Some(8));
        assert_eq!(lanes("cpu", 1), None);
        assert_eq!(table.row("sm_80", Precision::Double, 1), None);
        assert_eq!(table.skin("sm_80", Precision::Double, 1), PLAIN_SKIN);
        assert_eq!(table.text(), TEXT.replace("cpu mixed", "cpu   mixed").replace("mixed ", "mixed  "));
    }

    #[test]
    fn new_skins_leave_the_other_choices() {
        let skin = |skin| Found { skin, choices: None };
        let mut table = Table::read(TEXT).unwrap();
        table.set("sm_80", Precision::Mixed, &[(0, skin(0.7)), (100_000, skin(0.3))], "new");
        let rows: Vec<_> = table.of("sm_80", Precision::Mixed).map(|row| (row.atoms, row.lanes, row.skin)).collect();
        assert_eq!(rows, [(0, Some(16), 0.7), (12_000, Some(4), 0.7), (100_000, Some(4), 0.3)]);
        table.set("sm_89", Precision::Mixed, &[(0, skin(0.2))], "new");
        assert_eq!(table.row("sm_89", Precision::Mixed, 5).map(|row| (row.lanes, row.skin)), Some((Some(8), 0.2)));
        table.set("sm_80", Precision::Double, &[(0, skin(0.6)), (50, skin(0.6))], "new");
        assert_eq!(table.of("sm_80", Precision::Double).count(), 1);
        let choices = Choices { lanes: 32, group: 8, slices: 4, blocks: 1, ahead: 2 };
        table.set("sm_80", Precision::Mixed, &[(0, Found { skin: 0.5, choices: Some(choices) })], "new");
        assert_eq!(table.choices("sm_80", Precision::Mixed, 20_000), choices);
        assert_eq!(Table::read(&table.text()), Ok(table));
    }

    #[test]
    fn a_row_that_is_none_is_named() {
        for row in ["sm_90 half 0 - - - - - 0.3", "sm_90 mixed 0 - - - - -", "cpu mixed 0 - - - - - -1 x"] {
            let said = Table::read(&format!("# head\n{row}\n")).unwrap_err();
            assert!(said.starts_with("line 2: expected a row"), "{said}");
        }
    }
}
