//! `octant report` of scenes that break, have sides of all kinds or a strong cutoff; interrupted, and with wrong words.

#[path = "common/cli.rs"]
mod common;
#[path = "common/study.rs"]
mod study;

use common::Folder;
use study::{REPORT, SCENE, check_order, find, number, rows};

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
