//! What tests of `octant report` share: a scene, its study, and readers of tables and pages.
#![allow(dead_code)]

use std::collections::BTreeMap;

use crate::common::Folder;

pub type Row = BTreeMap<String, String>;

/// A liquid of 256 atoms, with files that a study must not write.
pub const SCENE: &str = "\
units lj
lattice fcc 0.8442
region b block 0 4 0 4 0 4
create_box 1 b
create_atoms 1 box
mass 1 1.0
velocity all create 2.4 87287 loop geom
pair_style lj/cut 2.2
pair_coeff 1 1 1.0 1.0
neighbor 0.3 bin
neigh_modify every 20 delay 0 check no
fix move all nve
timestep 0.005
dump frames all custom 10 frames.dump id x y z
log other.log
run 150
write_data end.data
print done file done.txt
";

/// Rows of a file, cells by column; quoted cells have no quotes in them.
pub fn rows(folder: &Folder, name: &str) -> Vec<Row> {
    let text = folder.read(name);
    let mut lines = text.lines();
    let heads: Vec<&str> = lines.next().unwrap().split(',').collect();
    let row = |line: &str| -> Row {
        // What stands between quotes has every other place.
        let parts = line.split('"').enumerate();
        let marked: String =
            parts.map(|(k, part)| if k % 2 == 0 { part.replace(',', "\n") } else { part.into() }).collect();
        let cells: Vec<&str> = marked.split('\n').collect();
        assert_eq!(cells.len(), heads.len(), "{name}: {line}");
        heads.iter().zip(cells).map(|(head, cell)| (head.to_string(), cell.to_string())).collect()
    };
    lines.map(row).collect()
}

pub fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: '{}' in {row:?}", row[column]))
}

/// The row of a table with these cells.
pub fn find<'a>(rows: &'a [Row], cells: &[(&str, &str)]) -> &'a Row {
    let is = |row: &&Row| cells.iter().all(|(column, cell)| row[*column] == *cell);
    rows.iter().find(is).unwrap_or_else(|| panic!("no row with {cells:?}"))
}

pub const REPORT: &str =
    "report scene.in --quick --backend cpu --threads 2 --python none --reference U=-5,P=1 --out made/here";

/// Tables of the page after a heading, cells without blanks around them.
pub fn page_rows<'a>(page: &'a str, heading: &str) -> Vec<Vec<&'a str>> {
    let part = page.split(&format!("\n## {heading}\n")).nth(1).unwrap_or_else(|| panic!("no {heading}: {page}"));
    let part = part.split("\n## ").next().unwrap();
    let rows = part.lines().filter(|line| line.starts_with("| ")).map(|line| line.trim_matches('|').split(" | "));
    rows.map(|cells| cells.map(str::trim).collect()).collect()
}

/// The first number of a text.
pub fn leading(text: &str) -> f64 {
    text.split([' ', ',', ';']).next().unwrap().parse().unwrap_or_else(|_| panic!("no number: {text}"))
}

/// Fitted orders on the page: that of the script's plainly truncated potential, and how many times the error of the force-shifted one it
/// has at the smallest step.
pub fn check_order(page: &str) -> (f64, f64) {
    let rows = page_rows(page, "Order of the integrator");
    let order = |name: &str| leading(rows.iter().find(|row| row[0].starts_with(name)).expect(name)[1]);
    // The reference's own error makes it larger: by log2((4 - 1/64) / (1 - 1/64)) - 2 = 0.017 where there are two steps.
    assert!((order("force-shifted") - 2.0).abs() < 0.05, "{rows:?}");
    assert!((order("script's potential, nve/euler2") - 1.0).abs() < 0.3, "{rows:?}");
    let said = page.split("Measured: between the two smallest steps, dt ").nth(1).expect("what truncation does");
    let after = |words: &str| leading(said.split(words).nth(1).unwrap());
    assert!((after("cuts off and ") - 2.0).abs() < 0.05, "{said}");
    let plain = order("script's potential and fixes");
    // Between the smallest steps errors of first order weigh most.
    assert!(after("order is ") < plain + 0.01, "{plain}: {said}");
    (plain, after("error is "))
}
