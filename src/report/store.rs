//! What has been measured so far, in CSV files: a study that was cut off, or is asked for again, goes on from them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::Error;
use crate::output::{write_csv, write_whole};

/// What the rows of a file are about, and what they hold.
#[derive(Debug)]
pub struct Table {
    /// Of the file, without `.csv`.
    pub name: &'static str,
    /// Columns that tell rows apart; they come first.
    pub keys: &'static [&'static str],
    pub values: &'static [&'static str],
}

impl Table {
    fn heads(&self) -> Vec<&'static str> {
        self.keys.iter().chain(self.values).copied().collect()
    }
}

/// A row with the names of its columns.
#[derive(Clone, Copy, Debug)]
pub struct Record<'a> {
    table: &'static Table,
    cells: &'a [String],
}

impl<'a> Record<'a> {
    pub fn text(&self, column: &str) -> &'a str {
        let place = self.table.heads().iter().position(|head| *head == column);
        place.and_then(|k| self.cells.get(k)).map_or("", String::as_str)
    }

    /// `None` for an empty cell.
    pub fn number(&self, column: &str) -> Option<f64> {
        self.text(column).parse().ok()
    }
}

/// All tables of a study.
pub struct Store {
    folder: PathBuf,
    rows: BTreeMap<&'static str, Vec<Vec<String>>>,
}

/// The file that says what was measured and how.
const SETTINGS: &str = "settings.txt";

impl Store {
    /// A line for the user where rows lie in a folder that a study with these settings cannot take over.
    pub fn strange(folder: &Path, tables: &[&'static Table], settings: &str) -> Option<String> {
        let old = fs::read_to_string(folder.join(SETTINGS)).unwrap_or_default();
        let of = |table: &Table| fs::read_to_string(folder.join(table.name).with_extension("csv")).ok();
        let same = old == settings;
        let lost = tables.iter().filter_map(|table| {
            let text = of(table)?;
            let gone = !same || read_csv(&text, &table.heads()).is_none();
            gone.then(|| (table.name, split_csv(&text).len().saturating_sub(1)))
        });
        let lost: Vec<(&str, usize)> = lost.collect();
        let rows: usize = lost.iter().map(|(_, rows)| rows).sum();
        if rows == 0 {
            return None;
        }
        let why = match same {
            true => {
                format!("have other columns ({})", lost.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", "))
            }
            false => format!("were measured with another {}", differences(&old, settings).join(", ")),
        };
        Some(format!("{rows} rows in {} {why}: they are measured anew", folder.display()))
    }

    /// Opens a folder, which is made if need be. Rows that lie there are taken over if they were measured with the same settings,
    /// which are any text; others are removed.
    pub fn open(folder: &Path, tables: &[&'static Table], settings: &str) -> Result<Self, Error> {
        fs::create_dir_all(folder).map_err(|e| Error::file(folder, "cannot create the folder", e))?;
        let path = folder.join(SETTINGS);
        let same = fs::read_to_string(&path).is_ok_and(|old| old == settings);
        let mut rows = BTreeMap::new();
        for table in tables {
            let file = folder.join(table.name).with_extension("csv");
            let old = if same { fs::read_to_string(&file).ok() } else { None };
            let taken = old.and_then(|text| read_csv(&text, &table.heads())).unwrap_or_default();
            if taken.is_empty() && file.exists() {
                fs::remove_file(&file).map_err(|e| Error::file(&file, "cannot remove", e))?;
            }
            rows.insert(table.name, taken);
        }
        if !same {
            write_whole(&path, |out| out.write_all(settings.as_bytes()))
                .map_err(|e| Error::file(&path, "cannot write", e))?;
        }
        Ok(Self { folder: folder.to_path_buf(), rows })
    }

    /// Rows that are there.
    pub fn len(&self) -> usize {
        self.rows.values().map(Vec::len).sum()
    }

    pub fn has(&self, table: &'static Table, key: &[String]) -> bool {
        self.rows[table.name].iter().any(|row| row.starts_with(key))
    }

    /// Adds a row and writes its file, whole.
    pub fn put(&mut self, table: &'static Table, mut key: Vec<String>, values: Vec<String>) -> Result<(), Error> {
        assert_eq!((key.len(), values.len()), (table.keys.len(), table.values.len()), "a row of {}", table.name);
        key.extend(values);
        let rows = self.rows.entry(table.name).or_default();
        rows.push(key);
        write_csv(&self.folder.join(table.name).with_extension("csv"), &table.heads(), rows)
    }

    /// In the order in which they were measured.
    pub fn rows(&self, table: &'static Table) -> impl Iterator<Item = Record<'_>> {
        self.rows[table.name].iter().map(move |cells| Record { table, cells })
    }
}

/// Names of the lines in which settings differ, and `text of the script`, which stands below the first empty line.
fn differences(old: &str, new: &str) -> Vec<String> {
    let parts = |text: &str| -> (Vec<String>, String) {
        let (lines, script) = text.split_once("\n\n").unwrap_or((text, ""));
        (lines.lines().map(str::to_string).collect(), script.into())
    };
    let ((old, old_script), (new, new_script)) = (parts(old), parts(new));
    let name = |line: &String| line.split(':').next().unwrap_or_default().to_string();
    let mut names: Vec<String> = Vec::new();
    let apart = old.iter().filter(|line| !new.contains(line)).chain(new.iter().filter(|line| !old.contains(line)));
    for name in apart.map(name) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    if old_script != new_script {
        names.push("text of the script".into());
    }
    names
}

/// Rows of a CSV text with these columns; `None` where it has others.
fn read_csv(text: &str, heads: &[&str]) -> Option<Vec<Vec<String>>> {
    let mut rows = split_csv(text).into_iter();
    let first = rows.next()?;
    let rows: Vec<Vec<String>> = rows.collect();
    (first == heads && rows.iter().all(|row| row.len() == heads.len())).then_some(rows)
}

/// Cells of a CSV text line by line; quoted cells may hold commas, quotes and line ends.
fn split_csv(text: &str) -> Vec<Vec<String>> {
    let (mut rows, mut row, mut cell, mut quoted) = (Vec::new(), Vec::new(), String::new(), false);
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if quoted && letters.peek() == Some(&'"') => {
                letters.next();
                cell.push('"');
            }
            '"' => quoted = !quoted,
            ',' if !quoted => row.push(std::mem::take(&mut cell)),
            '\n' if !quoted => {
                row.push(std::mem::take(&mut cell));
                rows.push(std::mem::take(&mut row));
            }
            other => cell.push(other),
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    static TABLE: Table = Table { name: "made", keys: &["a", "b"], values: &["c"] };

    #[test]
    fn settings_that_differ_are_named() {
        let old = "engine: cpu\ndts: None\nscript: a.in\n\nrun 1\n";
        assert_eq!(differences(old, "engine: cpu\ndts: 1\nscript: a.in\n\nrun 2\n"), ["dts", "text of the script"]);
        assert_eq!(
            differences(old, "engine: gpu\ndts: None\nlammps: 1\nscript: a.in\n\nrun 1\n"),
            ["engine", "lammps"]
        );
    }

    #[test]
    fn rows_come_back_under_the_same_settings_alone() {
        let folder = std::env::temp_dir().join(format!("octant-store-{}", std::process::id()));
        let key = |a: &str| vec![a.to_string(), "x, \"y\"\nz".to_string()];
        let mut store = Store::open(&folder, &[&TABLE], "one").unwrap();
        store.put(&TABLE, key("1"), vec!["2.5".into()]).unwrap();
        store.put(&TABLE, key("2"), vec![String::new()]).unwrap();
        let again = Store::open(&folder, &[&TABLE], "one").unwrap();
        assert!(again.has(&TABLE, &key("1")) && !again.has(&TABLE, &key("3")));
        let rows: Vec<_> = again.rows(&TABLE).collect();
        assert_eq!((again.len(), rows[0].number("c"), rows[1].number("c")), (2, Some(2.5), None));
        assert_eq!(rows[1].text("b"), "x, \"y\"\nz");
        // A file that someone has changed is no row of ours.
        let file = folder.join("made.csv");
        fs::write(&file, "a,b,c\n1,2\n").unwrap();
        assert!(Store::strange(&folder, &[&TABLE], "one").unwrap().contains("have other columns (made)"));
        assert_eq!(Store::open(&folder, &[&TABLE], "one").unwrap().len(), 0);
        fs::write(&file, "a,b,c\n1,2,3\n").unwrap();
        assert_eq!(Store::open(&folder, &[&TABLE], "one").unwrap().len(), 1);
        assert_eq!(Store::strange(&folder, &[&TABLE], "one"), None);
        let said = Store::strange(&folder, &[&TABLE], "two").unwrap();
        assert!(
            said.starts_with("1 rows in ") && said.ends_with("with another one, two: they are measured anew"),
            "{said}"
        );
        assert_eq!(Store::open(&folder, &[&TABLE], "two").unwrap().len(), 0);
        assert!(!file.exists());
        assert_eq!(Store::strange(&folder, &[&TABLE], "three"), None);
        fs::remove_dir_all(&folder).unwrap();
    }
}
