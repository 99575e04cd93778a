//! `octant paper` through the binary: its tables against what is known beforehand, and its command line.

#[path = "common/cli.rs"]
mod common;

use std::collections::BTreeMap;

use common::Folder;
use octant::paper::{EXHAUSTIVE, ORDERED, SEARCHES, TABLE_1, expected_neighbors};

type Row = BTreeMap<String, String>;

/// Rows of a file, cells by column; no cell of these has a comma in it.
fn rows(folder: &Folder, name: &str) -> Vec<Row> {
    let text = folder.read(name);
    let mut lines = text.lines();
    let heads: Vec<&str> = lines.next().unwrap().split(',').collect();
    let row = |line: &str| -> Row {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), heads.len(), "{name}: {line}");
        heads.iter().zip(cells).map(|(head, cell)| (head.to_string(), cell.to_string())).collect()
    };
    lines.map(row).collect()
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: '{}'", row[column]))
}

/// To the six digits that the files have.
fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 2e-5 * b.abs()
}

/// What holds of every row with times.
fn check_times(row: &Row) {
    for stage in ["sort_us", "list_us", "build_us"] {
        let of = |suffix: &str| number(row, &format!("{stage}{suffix}"));
        assert!(0.0 < of("_least") && of("_least") <= of("") && of("") <= of("_most"), "{row:?}");
    }
    // The sort is in the build and not in the list; medians of sums are no sums of medians, but no build beats its parts.
    assert!(number(row, "build_us_least") >= number(row, "sort_us_least").max(number(row, "list_us_least")), "{row:?}");
    assert!(number(row, "build_us_most") <= 1.001 * (number(row, "sort_us_most") + number(row, "list_us_most")));
    let (particles, listed) = (number(row, "particles"), number(row, "listed"));
    assert!(same(number(row, "neighbors"), listed / particles), "{row:?}");
    assert!(same(number(row, "hit_ratio"), listed / (particles * number(row, "tests_per_particle"))), "{row:?}");
    assert!(same(number(row, "build_ns_per_neighbor"), number(row, "build_us") * 1e3 / listed), "{row:?}");
    assert!(same(number(row, "list_ns_per_neighbor"), number(row, "list_us") * 1e3 / listed), "{row:?}");
    assert!(number(row, "bytes_per_particle") > 100.0 && number(row, "builds") >= 1.0);
    assert_eq!((row["backend"].as_str(), row["device"].split(' ').next()), ("cpu", Some("2")));
}

fn check_table_1(rows: &[Row]) {
    assert_eq!(rows.len(), TABLE_1.len());
    for (row, of) in rows.iter().zip(TABLE_1) {
        assert_eq!(row["particles"], of.particles.to_string());
        assert_eq!((number(row, "edge"), row["paper"].as_str()), (of.edge, of.neighbors.to_string().as_str()));
        let expected = expected_neighbors(of.particles, of.edge);
        assert!(same(number(row, "expected"), expected));
        let scatter = (2.0 * expected / of.particles as f64).sqrt();
        for count in ["neighbors_least", "neighbors", "neighbors_most"] {
            assert!((number(row, count) - expected).abs() < 4.0 * scatter, "{row:?}");
        }
        assert!(number(row, "neighbors_least") < number(row, "neighbors_most"), "two seeds are two systems: {row:?}");
    }
}

/// Counts at step 0 are Table 1's; particles do not come back, and F = k / r drives most of them out.
fn check_later(rows: &[Row], table_1: &[Row]) {
    assert_eq!(rows.len(), 2 * 3 * 8);
    for rows in rows.chunks(8) {
        assert_eq!((rows[0]["step"].as_str(), rows[7]["step"].as_str()), ("0", "100"));
        let of = table_1.iter().find(|row| row["particles"] == rows[0]["particles"]).unwrap();
        assert!([&of["neighbors_least"], &of["neighbors_most"]].contains(&&rows[0]["neighbors"]), "{rows:?}");
        assert_eq!(rows[0]["left"], rows[0]["particles"]);
        assert!(rows.windows(2).all(|pair| number(&pair[1], "left") <= number(&pair[0], "left")));
        let (left, neighbors) = (number(&rows[7], "left_percent"), number(&rows[7], "neighbors_over_first"));
        match rows[0]["force"].as_str() {
            "inverse" => assert!(left < 50.0 && neighbors < 0.5, "{left} {neighbors}"),
            _ => assert!(left > 80.0 && neighbors > 0.5, "{left} {neighbors}"),
        }
    }
}

fn check_stability(rows: &[Row]) {
    let (pairs, gases): (Vec<&Row>, Vec<&Row>) = rows.iter().partition(|row| row["system"] == "pair");
    assert_eq!((pairs.len(), gases.len()), (2 * 4, 2 * 2 * 3 * 2));
    for row in pairs {
        // sqrt(k / m) dt of the paper's numbers.
        let omega_dt = (3600.0 / 3e-4f64).sqrt() * 2e-4 * number(row, "part");
        assert!(same(number(row, "omega_dt"), omega_dt));
        let expected = if row["integrator"] == "nve" { 0.0 } else { (0.5 * omega_dt * omega_dt).ln_1p() };
        assert!(same(number(row, "expected"), expected) || expected == 0.0);
        // Beside the swing of the energy, six digits of the file and rounding of an energy that is 1e-7 of the whole.
        let room = number(row, "uncertainty") + 1e-6 * (1.0 + expected);
        assert!((number(row, "rate") - expected).abs() < room && room < 0.1, "{row:?}");
    }
    for rows in gases.chunks(6) {
        // The same time in shorter and shorter steps, each with both integrators.
        for pair in rows.chunks(2) {
            assert_eq!([&pair[0], &pair[1]].map(|row| row["integrator"].as_str()), ["nve/euler2", "nve"]);
            assert!(pair.iter().all(|row| row["part"] == pair[0]["part"] && row["precision"] == "double"));
        }
        let last = |k: usize| number(rows[4 + k], "ratio");
        if rows[0]["force"] == "spring" {
            // Second-order Euler heats a spring at any step, velocity Verlet hardly, and walls do by themselves.
            assert!(last(0) > 5.0 && last(0) > 5.0 * last(1), "{rows:?}");
            assert!((last(1) - 1.0).abs() < if rows[0]["box"] == "periodic" { 0.05 } else { 0.5 }, "{rows:?}");
        }
    }
    let verlet = |within: &str| {
        let of = |row: &&&Row| row["box"] == within && row["force"] == "spring" && row["integrator"] == "nve";
        number(gases.iter().rfind(of).unwrap(), "ratio")
    };
    assert!(verlet("walls") > verlet("periodic"));
}

fn check_figure_4(rows: &[Row]) {
    let directions: Vec<&str> = rows.iter().map(|row| row["direction"].as_str()).collect();
    assert_eq!(directions, ["own", "X", "X", "Y", "Y", "Z", "Z", "XY", "XY", "XYZ", "XYZ"]);
    for row in rows {
        check_times(row);
        assert_eq!((&row["particles"], &row["load"]), (&rows[0]["particles"], &rows[0]["load"]));
        let cells: usize = row["block"].split('x').map(|n| n.parse::<usize>().unwrap()).product();
        assert_eq!(number(row, "adjacent_cells"), (cells - 1) as f64);
        // Every cell has the same load, and all of it is tested.
        assert_eq!(number(row, "tests_per_particle"), cells as f64 * number(row, "load"), "{row:?}");
    }
    assert_eq!(number(&rows[10], "adjacent_cells"), 26.0);
}

/// The same particles by several searches: all find as many neighbors.
fn check_listed(rows: &[Row], searches: &[&str]) {
    assert_eq!(rows.len(), searches.len());
    for (row, search) in rows.iter().zip(searches) {
        check_times(row);
        let words: Vec<&str> = search.split(['+', ':']).collect();
        assert_eq!((row["search"].as_str(), row["method"].as_str()), (*search, words[0]));
        let named =
            |word: &str, usual: &'static str, other: &'static str| if words.contains(&word) { other } else { usual };
        assert_eq!(row["order"], named("zorder", "rows", "zorder"));
        assert_eq!(row["sort"], named("radix", "counting", "radix"));
        let [column, listed] = ["particles", "listed"].map(|column| &row[column]);
        assert_eq!((column, listed), (&rows[0]["particles"], &rows[0]["listed"]), "{search}");
    }
}

fn check_searches(rows: &[Row]) {
    check_listed(rows, &SEARCHES);
    let find = |search: &str| rows.iter().find(|row| row["search"] == search).unwrap();
    let tests = |search: &str| number(find(search), "tests_per_particle");
    // The octant search looks into a part of the standard search's cells, the others into a part of its.
    for edge in ["2", "2.52", "4"] {
        let with = |search: &str, usual: &str| {
            tests(&if edge == usual { search.to_string() } else { format!("{search}:{edge}") })
        };
        let octant = with("octant", "2");
        assert!(octant < with("standard", "1") && with("trimmed", "2") < octant, "{edge}");
        assert!(with("midplane", "2.52") <= octant && (edge == "2" || with("midplane", "2.52") < octant), "{edge}");
    }
}

#[test]
fn tables_hold_what_is_known_of_them() {
    let folder = Folder::new("paper-quick");
    let said = folder.says("paper --quick --backend cpu --threads 2 --out made/here");
    let [table_1, later, stability, figure_4, orders, distributions, figure_5] =
        ["table1", "later", "stability", "figure4", "orders", "distributions", "figure5"]
            .map(|name| rows(&folder, &format!("made/here/{name}.csv")));
    check_table_1(&table_1);
    check_figure_4(&figure_4);
    check_later(&later, &table_1);
    check_stability(&stability);
    // Rows have no name of their own where they are usual.
    let named: Vec<&str> = ORDERED.into_iter().filter(|search| !search.contains("+rows")).collect();
    let ordered: Vec<&[Row]> = orders.chunks(named.len()).collect();
    assert_eq!(ordered.len(), 2);
    for rows in &ordered {
        check_listed(rows, &named);
        for pair in rows.chunks(4) {
            // The way to sort moves no particle; another order of cells does.
            let apart = |k: usize| (number(&pair[k], "apart"), number(&pair[k], "far_percent"));
            assert!(apart(0) == apart(2) && apart(1) == apart(3), "{pair:?}");
            assert!(apart(0) != apart(1) || pair[0]["search"] != "standard", "{pair:?}");
            assert!(apart(0).0 > 1.0 && apart(0).0 < number(&pair[0], "particles"));
        }
    }
    // All pairs come last, and with sizes that are so small always.
    let sizes: Vec<&[Row]> = figure_5.chunks(SEARCHES.len() + 1).collect();
    assert_eq!(sizes.iter().map(|rows| rows[0]["particles"].as_str()).collect::<Vec<_>>(), ["1000", "5000"]);
    for rows in &sizes {
        let (all, [rest @ .., _]) = (rows, *rows) else { panic!("no rows") };
        check_searches(rest);
        check_listed(&[rest[0].clone(), all[rest.len()].clone()], &[SEARCHES[0], EXHAUSTIVE]);
        assert_eq!(number(&all[rest.len()], "tests_per_particle"), number(&all[0], "particles"));
    }
    // The same points as those of the first seed in Table 1.
    let counted = |rows: &[Row]| ["neighbors_least", "neighbors_most"].map(|head| rows[0][head].clone());
    assert!(counted(&table_1).contains(&sizes[0][0]["neighbors"]));

    let scenes: Vec<&[Row]> = distributions.chunks(SEARCHES.len()).collect();
    let names: Vec<&str> = scenes.iter().map(|rows| rows[0]["distribution"].as_str()).collect();
    assert_eq!(names, ["uniform", "liquid", "clustered", "dense"]);
    scenes.iter().filter(|rows| rows[0]["distribution"] != "liquid").for_each(|rows| check_searches(rows));
    // In a small periodic box the cells of several edges are the same, and fewer tests are none.
    assert!(scenes[1].iter().all(|row| row["listed"] == scenes[1][0]["listed"]));
    let neighbors = |k: usize| number(&scenes[k][0], "neighbors");
    // Of a liquid: the density times the volume of the sphere.
    assert!((neighbors(1) / (0.8442 * 4.18879 * 2.8f64.powi(3)) - 1.0).abs() < 0.05, "{}", neighbors(1));
    assert!(neighbors(2) > 4.0 * neighbors(0) && neighbors(3) > 6.0 * neighbors(0));
    for title in [
        "Table 1: ",
        "Table 1 later: ",
        "The paper's step: ",
        "Order of cells",
        "Figure 4: ",
        "Figure 5: ",
        "List builds by search and distribution",
    ] {
        assert_eq!(said.matches(title).count(), 1, "{said}");
    }
    let lines = said.lines().filter(|line| line.contains(" midplane:4 ")).count();
    assert_eq!(lines, 6, "{said}");
    assert_eq!(std::fs::read_dir(&folder.0).unwrap().count(), 1, "no log is written");
}

#[test]
fn sizes_rounds_and_precision_are_heeded() {
    let folder = Folder::new("paper-options");
    // A size that is named twice is measured once.
    folder.says("paper --quick --backend cpu --threads 2 --sizes 500,500 --rounds 3 --precision double --out .");
    let figure_5 = rows(&folder, "figure5.csv");
    assert_eq!(figure_5.len(), SEARCHES.len() + 1);
    for row in &figure_5 {
        let of = ["particles", "rounds", "precision"].map(|column| row[column].as_str());
        assert_eq!(of, ["500", "3", "double"]);
    }
    assert!(rows(&folder, "table1.csv").iter().all(|row| row["seeds"] == "3"));
    assert_eq!(folder.files().len(), 7);
}

#[test]
fn wrong_words_are_refused() {
    let folder = Folder::new("paper-wrong");
    for (args, said) in [
        ("--sizes 499", "expected 500 to"),
        ("--rounds 0", "--rounds"),
        ("--precision half", "half"),
        ("--backend gpu", "gpu"),
        ("a.in", "unexpected argument"),
    ] {
        let stderr = folder.fails(2, &format!("paper {args}"));
        assert!(stderr.contains(said), "{args}: {stderr}");
    }
    assert!(folder.files().is_empty());
    folder.write("file", "");
    let file = folder.fails(1, "paper --quick --backend cpu --out file");
    assert!(file.starts_with("ERROR: file: cannot create the folder: "), "{file}");
    // What cannot be kept is not measured.
    #[cfg(target_os = "linux")]
    {
        std::fs::create_dir(folder.0.join("full")).unwrap();
        std::os::unix::fs::symlink("/dev/full", folder.0.join("full/table1.csv")).unwrap();
        let full = folder.fails(1, "paper --quick --backend cpu --sizes 500 --out full");
        assert!(full.contains("table1.csv") && !folder.has("full/later.csv"), "{full}");
    }
    let gpu = folder.fails(1, "paper --backend cpu --device 0 --out here");
    assert!(gpu.starts_with("ERROR: --device 0") && !folder.has("here"), "{gpu}");
}
