//! `octant report` of scenes that break, have sides of all kinds or a strong cutoff; interrupted, and with wrong words.

#[path = "common/cli.rs"]
mod common;
#[path = "common/study.rs"]
mod study;

use common::Folder;
use study::{REPORT, SCENE, check_order, find, number, page_rows, rows};

#[test]
fn a_cutoff_where_the_force_is_strong_takes_an_order() {
    let folder = Folder::new("report-order");
    // At 1.5 the force is half of the most that the potential pulls with: what a crossing pair is kicked too much or too little outweighs
    // the error of second order.
    folder.write("scene.in", &SCENE.replace("lj/cut 2.2", "lj/cut 1.5"));
    folder.says(&format!("{REPORT} --precision double --dt 0.00125,0.0025 --skin 0.3"));
    let (plain, times) = check_order(&folder.read("made/here/report.md"));
    assert!((0.9..1.7).contains(&plain) && times > 2.0, "{plain} {times}");
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
    let step = row["fault"].split(':').next().unwrap();
    assert!(page.contains("Settings that broke the scene") && page.contains(&format!("| {step}: ")), "{page}");
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
fn tail_corrections_a_thermostat_and_values_of_the_script() {
    let folder = Folder::new("report-tail");
    let scene = SCENE
        .replace("pair_coeff 1 1 1.0 1.0\n", "pair_coeff 1 1 1.0 1.0\npair_modify tail yes\n")
        .replace("fix move all nve", "variable reference_u equal -5.5\nvariable reference_p equal v_reference_u+6.5\nfix move all nvt temp 0.85 0.85 0.2")
        .replace("every 20 delay 0 check no", "every 1 delay 0 check yes");
    folder.write("scene.in", &scene);
    folder
        .says("report scene.in --quick --backend cpu --threads 2 --python none --precision mixed --dt 0.0025 --out .");
    for row in rows(&folder, "energies.csv")
        .iter()
        .filter(|row| row["dt"] == "0.0025" && row["potential"] == "own" && row["integrator"] == "own")
    {
        // Taken apart as without a tail: the bare energy jumps, the other one does not.
        let (plain, continuous) = (number(row, "fluctuation_plain"), number(row, "fluctuation"));
        assert!(continuous > 0.0 && plain > 3.0 * continuous, "{row:?}");
    }
    let shift = rows(&folder, "prices.csv").into_iter().find(|row| row["option"] == "pair_modify shift yes tail no");
    assert!(shift.is_some_and(|row| row["fault"].is_empty()));
    let off = rows(&folder, "prices.csv").into_iter().find(|row| row["option"].starts_with("all of these")).unwrap();
    assert_eq!(off["same_program"], "yes");

    // The values that the script names are held against the run with its thermostat alone.
    let held = &rows(&folder, "averages.csv")[0];
    assert!(
        (number(held, "temperature") - 0.85).abs() < 0.15 && number(held, "potential_energy_error") > 0.0,
        "{held:?}"
    );
    let page = folder.read("report.md");
    let shown = page_rows(&page, "Averages");
    assert_eq!(shown[0][9..], ["U from -5.5", "P from 1"]);
    for row in &shown[1..] {
        let expected = match (row[0], row[1]) {
            ("script's", "script's, with nvt") => "error bars",
            ("script's", _) => "not judged: no thermostat, another temperature",
            _ => "not judged: another Hamiltonian",
        };
        assert!(row[9..].iter().all(|cell| cell.ends_with(expected)), "{row:?}");
    }
    assert!(shown.iter().any(|row| row[1] == "script's, with nvt"));
}

#[test]
fn a_lattice_is_run_on_before_it_is_studied() {
    let folder = Folder::new("report-lattice");
    folder.write("scene.in", &SCENE.replace("run 150", "run 0"));
    let said = folder.says("report scene.in --quick --backend cpu --threads 2 --python none --precision mixed --out .");
    assert!(said.contains("The script leaves a lattice: net forces are zero by symmetry"), "{said}");
    assert!(folder.read("report.md").contains("The script leaves a lattice"));
    let forces = rows(&folder, "forces.csv");
    assert!(
        forces.iter().all(|row| number(row, "rms_force") > 1.0 && number(row, "force_error_rms") < 3e-6),
        "{forces:?}"
    );
    // As long as that of the liquid that it becomes: 0.2 tau.
    let times = rows(&folder, "trajectories.csv");
    assert!(times.iter().all(|row| (0.1..0.4).contains(&number(row, "time"))), "{times:?}");
    // Without velocities it stays what it is: lengths are those of its curvature, and no force error is made up.
    folder
        .write("cold.in", &SCENE.replace("run 150", "run 0").replace("velocity all create 2.4 87287 loop geom\n", ""));
    let said =
        folder.says("report cold.in --quick --backend cpu --threads 2 --python none --precision mixed --out cold");
    assert!(said.contains("Net forces are zero by symmetry") && said.contains("Nothing moves"), "{said}");
    assert!(rows(&folder, "cold/forces.csv").iter().all(|row| row["force_error_rms"].is_empty()));
    let times = rows(&folder, "cold/trajectories.csv");
    assert!(times.iter().all(|row| (0.2..0.8).contains(&number(row, "time"))), "{times:?}");
    assert!(!folder.read("cold/report.md").contains("NaN") && !folder.read("cold/report.md").contains(" inf"));
}

#[test]
fn none_missing_among_few_is_no_advice() {
    let folder = Folder::new("report-unsure");
    // Nothing crosses such a skin in two steps, but nobody looks, and a quick study sees few pairs.
    let scene =
        SCENE.replace("neighbor 0.3", "neighbor 0.8").replace("every 20 delay 0 check no", "every 2 delay 0 check no");
    folder.write("scene.in", &scene);
    let said = folder
        .says("report scene.in --quick --backend cpu --threads 2 --python none --precision mixed --dt 0.005 --out .");
    let own = [("rebuild", "every 2 delay 0 check no"), ("skin", "0.8"), ("dt", "0.005")];
    let missing = rows(&folder, "missing.csv");
    assert_eq!(find(&missing, &own)["missing"], "0");
    let advice = said.lines().rev().nth(1).unwrap();
    assert!(
        advice.starts_with("Take dt 0.005, mixed, skin ")
            && advice.contains("neigh_modify every 1 delay 0 check yes: 0 pairs missed for certain"),
        "{advice}"
    );
    assert!(
        advice.contains(" than the script's settings (")
            || advice.contains("within the noise as fast as the script's settings ("),
        "{advice}"
    );
    let page = folder.read("report.md");
    let front = page_rows(&page, "Work and precision");
    assert!(front.iter().all(|row| row.last() != Some(&"front") || row[5] == "every 1 delay 0 check yes"), "{front:?}");
}

#[cfg(unix)]
#[test]
fn rows_stay_whether_lammps_is_found_or_not() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new("report-peer");
    folder.write("scene.in", SCENE);
    // It says that it has LAMMPS, and fails when it is asked to run.
    folder.write("peer", "#!/bin/sh\ntest \"$3\" = ask || exit 3\necho 20250722\n");
    let path = folder.0.join("peer");
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    let command = "report scene.in --quick --backend cpu --threads 2 --precision mixed --dt 0.005 --out . --python";
    folder.says(&format!("{command} ./peer"));
    let peer = rows(&folder, "lammps.csv");
    assert_eq!((peer.len(), peer[0]["version"].as_str()), (1, "20250722"));
    assert!(!peer[0]["fault"].is_empty() && peer[0]["seconds_per_time"].is_empty(), "{peer:?}");
    let before = folder.read("speeds.csv");
    let said = folder.says(&format!("{command} none"));
    assert!(said.contains(" rows are in . already\n") && !said.contains("measured anew"), "{said}");
    assert_eq!((folder.read("speeds.csv"), rows(&folder, "lammps.csv")), (before.clone(), peer));
    assert!(
        folder.read("report.md").contains("20250722, as measured before; not asked again: none has no module lammps")
    );
    // Another version has a row of its own, and is the one that is shown.
    folder.write("peer", "#!/bin/sh\ntest \"$3\" = ask || exit 3\necho 20260101\n");
    folder.says(&format!("{command} ./peer"));
    let versions: Vec<String> = rows(&folder, "lammps.csv").iter().map(|row| row["version"].clone()).collect();
    assert_eq!((versions, folder.read("speeds.csv")), (vec!["20250722".into(), "20260101".into()], before));
    assert!(folder.read("report.md").contains("| LAMMPS | 20260101, "));
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
