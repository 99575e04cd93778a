//! `octant bench` through the binary: its columns, that errors stand beside speeds, and its command line.

#[path = "common/cli.rs"]
mod common;

use std::collections::BTreeMap;

use common::Folder;

/// Rows of a file, cells by column; no cell of these has a comma in it.
fn rows(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = text.lines();
    let heads: Vec<&str> = lines.next().unwrap().split(',').collect();
    let cells = |line: &str| -> Vec<String> { line.split(',').map(str::to_string).collect() };
    let row = |line: &str| heads.iter().map(|h| h.to_string()).zip(cells(line)).collect();
    lines.inspect(|line| assert_eq!(cells(line).len(), heads.len(), "{line}")).map(row).collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: '{}'", row[column]))
}

#[test]
fn every_row_has_speed_and_error() {
    let folder = Folder::new("bench-rows");
    let said = folder.says(
        "bench --backend cpu --threads 2 --sizes 500,1000 --steps 40 --rounds 2 --precision single,mixed,double --csv b.csv",
    );
    assert!(said.contains("1000 atoms: the nearest box has 6x6x7 cells, 1008 atoms\n"), "{said}");
    let rows = rows(&folder.read("b.csv"));
    let names = |column: &str| rows.iter().map(|row| row[column].clone()).collect::<Vec<_>>();
    assert_eq!(names("precision"), ["single", "mixed", "double", "single", "mixed", "double"]);
    assert_eq!(names("atoms"), ["500", "500", "500", "1008", "1008", "1008"]);
    for row in &rows {
        assert_eq!((row["scene"].as_str(), row["backend"].as_str()), ("lj", "cpu"));
        assert_eq!((row["melted"].as_str(), row["steps"].as_str(), row["rounds"].as_str()), ("2000", "40", "2"));
        assert!(row["device"].starts_with("2 threads"), "{}", row["device"]);
        let (least, median, most) =
            (number(row, "steps_per_s_least"), number(row, "steps_per_s"), number(row, "steps_per_s_most"));
        assert!(0.0 < least && least <= median && median <= most);
        let rate = median * number(row, "atoms") / 1e6;
        assert!((number(row, "matom_steps_per_s") / rate - 1.0).abs() < 1e-4);
        // The stages are those of the timed legs: together they are the time of a step.
        let stages = ["pair_us", "list_us", "sort_us", "check_us", "modify_us", "output_us", "other_us"];
        let step = stages.iter().map(|stage| number(row, stage)).sum::<f64>();
        assert!((1e6 / most * 0.99..=1e6 / least * 1.01).contains(&step), "{step} us, {least} to {most} steps/s");
        let interval = number(row, "steps_per_build");
        assert!((4.0..30.0).contains(&interval), "{interval} steps a build");
        let build = number(row, "build_us") / interval;
        assert!((build / (number(row, "list_us") + number(row, "sort_us")) - 1.0).abs() < 1e-4);
        assert!(number(row, "bytes_per_atom") > 100.0 && number(row, "start_up_s") > 0.0);
        assert!((60.0..90.0).contains(&number(row, "list_entries_per_atom")));
        let error = number(row, "force_error_rms");
        let expected = if row["precision"] == "double" { 1e-16..1e-13 } else { 1e-8..3e-6 };
        assert!(expected.contains(&error), "{}: {error}", row["precision"]);
        assert!(number(row, "force_error_worst") > error);
        assert_eq!((row["pairs_missing"].as_str(), row["pairs_extra"].as_str()), ("0", "0"));
        assert_eq!((row["sampled_atoms"].as_str(), row["dangerous_builds"].as_str()), (row["atoms"].as_str(), "0"));
        assert!(number(row, "drift").abs() < 2e-4 + 3.0 * number(row, "drift_error"));
        assert!(said.lines().any(|l| l.contains(&row["atoms"]) && l.contains(&row["precision"])), "{said}");
    }
    assert_eq!(folder.files().keys().collect::<Vec<_>>(), ["b.csv"], "no log is written");
}

#[test]
fn variants_run() {
    let folder = Folder::new("bench-scenes");
    let speed = |scene: &str, column: &str| {
        let command = "bench --backend cpu --sizes 500 --steps 20 --rounds 1 --precision mixed --skin 0.5";
        folder.says(&format!("{command} --scene {scene} --csv {scene}.csv"));
        let rows = rows(&folder.read(&format!("{scene}.csv")));
        assert_eq!((rows.len(), rows[0]["scene"].as_str(), rows[0]["skin"].as_str()), (1, scene, "0.5"));
        number(&rows[0], column)
    };
    for scene in ["lj", "morse", "two-types"] {
        assert!(speed(scene, "force_error_rms") < 1e-5);
    }
    // Rows are asked for at every step: what they take has a stage of its own.
    assert!(speed("sums", "output_us") > 0.0);
}

#[test]
fn a_tuning_run_writes_the_table() {
    let folder = Folder::new("bench-tune");
    let said = folder.says("bench --backend cpu --sizes 500 --steps 20 --rounds 1 --precision mixed --tune t.txt");
    assert_eq!(said.matches(", the fastest").count(), 1, "{said}");
    assert_eq!(said.matches("500 atoms, mixed").count(), 13, "{said}");
    let best = said.lines().find(|l| l.contains("the fastest")).unwrap();
    let skin: f64 = best.split("skin ").nth(1).unwrap().split(':').next().unwrap().parse().unwrap();
    let table = octant::engine::tuned::Table::read(&folder.read("t.txt")).unwrap();
    assert_eq!(table.skin("cpu", octant::engine::Precision::Mixed, 1_000_000), skin);
    assert!(table.row("sm_90", octant::engine::Precision::Double, 1).is_some(), "other rows stay");
    assert_eq!(folder.files().len(), 1);
}

#[test]
fn wrong_words_are_refused() {
    let folder = Folder::new("bench-wrong");
    for (args, said) in [
        ("--sizes 499", "expected 500 to"),
        ("--sizes many", "expected 500 to"),
        ("--skin 0", "expected a number above 0, or auto"),
        ("--steps 0", "expected 1 to 1 000 000 000 steps, or auto"),
        ("--rounds 0", "--rounds"),
        ("--scene gas", "[possible values: lj, morse, two-types, sums]"),
        ("--precision mixed,half", "half"),
        ("--tune t.txt --csv a.csv", "cannot be used with"),
        ("a.in", "unexpected argument"),
    ] {
        let stderr = folder.fails(2, &format!("bench {args}"));
        assert!(stderr.contains(said), "{args}: {stderr}");
    }
    let narrow = folder.fails(1, "bench --backend cpu --sizes 500 --skin 2");
    assert_eq!(narrow, "ERROR: --skin 2: a box of 5x5x5 cells is narrower than twice cutoff and skin\n");
    let nowhere = folder.fails(1, "bench --backend cpu --sizes 500 --csv absent/b.csv");
    assert!(nowhere.starts_with("ERROR: --csv absent/b.csv: cannot write"), "{nowhere}");
    let gpu = folder.fails(1, "bench --backend cpu --device 0");
    assert!(gpu.starts_with("ERROR: --device 0"), "{gpu}");
    assert!(folder.files().is_empty());
}
