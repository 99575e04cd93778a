//! A run that goes wrong, or is about to: warnings of a timestep that is too large, and what is on disk after a stop.

#[path = "common/cli.rs"]
mod cli;
mod common;

use cli::{Folder, melt, root};
use common::{advanced, free_or_periodic, program, started, told, variants};
use octant::engine::Stride;
use octant::neighbor::Search;
use octant::system::{State, Vec3};
use serde_json::Value;

fn report(folder: &Folder) -> Value {
    serde_json::from_str(&folder.read("report.json")).unwrap()
}

/// Warnings of a log, in order.
fn warnings(log: &str) -> Vec<&str> {
    log.lines().filter_map(|line| line.strip_prefix("WARNING: ")).collect()
}

/// The word after some text.
fn after<'a>(text: &'a str, lead: &str) -> &'a str {
    let rest = text.split(lead).nth(1).unwrap_or_else(|| panic!("no '{lead}' in '{text}'"));
    rest.split_whitespace().next().unwrap().trim_end_matches([',', ';', ':'])
}

/// The liquid of [`melt`] with a force that ends without a step, so that its energy is the integrator's alone.
fn liquid(timestep: &str, run: &str) -> String {
    melt(&format!("timestep {timestep}\n{run}")).replace("lj/cut 2.5", "lj/smooth/linear 2.5")
}

#[test]
fn a_timestep_ten_times_too_large_is_told_before_it_breaks_the_run() {
    let folder = Folder::new("ten-times");
    for (variant, words) in told() {
        let name = &variant.name;
        folder.write("a.in", &liquid("0.05", "thermo 10\nrun 2000"));
        let said = folder.fails(1, &format!("run a.in --json report.json {words}"));
        let log = folder.read("log.octant");
        let told = warnings(&log);
        assert!(told[0].starts_with("step 0: atom "), "{name}: {told:?}");
        assert!(
            told[0].contains(" in a timestep, farther than half the skin (0.15); nearest to it is atom "),
            "{told:?}"
        );
        // Neighbors of the crystal, whose lattice constant is (4 / 0.8442)^(1/3).
        assert_eq!(after(told[0], " at distance "), "1.188", "{name}");
        assert!(log.find("WARNING").unwrap() < log.find("ERROR").unwrap());
        // Energies come later; each sign once.
        let kinds = [" in a timestep, farther", " the total energy, ", " the temperature has "];
        assert!(kinds.iter().all(|kind| told.iter().filter(|line| line.contains(kind)).count() <= 1), "{told:?}");
        let report = report(&folder);
        let listed: Vec<&str> = report["warnings"].as_array().unwrap().iter().map(|w| w.as_str().unwrap()).collect();
        assert_eq!(listed, told, "{name}");
        assert_eq!(format!("ERROR: {}", report["error"].as_str().unwrap()), said.trim_end(), "{name}");

        // The timestep that is proposed, by the stop as well, keeps the energy: to (omega dt)^2 / 4 of the kinetic energy, which
        // is 1/64 for the hardest collision and less for all others.
        let proposed = after(told[0], "a timestep of ");
        assert!(said.contains(&format!("\n  a timestep of {proposed} would do\n")), "{name}: {said}");
        folder.write("b.in", &liquid(proposed, "thermo 100\nthermo_style custom step ke etotal\nrun 1000"));
        folder.says(&format!("run b.in --json report.json {words}"));
        let report = self::report(&folder);
        assert_eq!(report["warnings"].as_array().unwrap().len(), 0, "{name}: {report}");
        assert_eq!(report["error"], Value::Null);
        let rows = report["thermo"].as_array().unwrap();
        let number = |row: &Value, column: &str| row[column].as_f64().unwrap();
        let start = number(&rows[0], "TotEng");
        for row in rows {
            let off = (number(row, "TotEng") - start).abs() / number(&rows[0], "KinEng");
            assert!(off < 1.0 / 64.0, "{name}: {off} at step {}", row["Step"]);
        }
    }
}

/// The start tells nothing: what is slow first gets fast. Without a thermo table in between, the run looks by itself.
#[test]
fn builds_that_come_late_make_the_run_look_at_its_atoms() {
    let folder = Folder::new("late-builds");
    let scene = "units lj\nregion b block 0 10 0 10 0 10 units box\ncreate_box 1 b\ncreate_atoms 1 single 2 3 4\n\
                 create_atoms 1 single 5 6 7\nmass 1 1\npair_style lj/cut 2.5\npair_coeff 1 1 1 1\ngroup one id 1\n\
                 fix 1 all nve\nfix 2 one gravity 100 vector 0 0 -1\nrun 100\n";
    folder.write("a.in", scene);
    for (variant, words) in told() {
        folder.says(&format!("run a.in --json report.json {words}"));
        // v = g t is 32 at step 64; the atom has come from 4 to -1.12, whose image is at 8.88. A collision at that speed turns
        // it around where 4 (r^-12 - r^-6) is 256, at 0.6998: there U'' = 4 (156 r^-14 - 42 r^-8), of a mass of 1/2, is
        // 423^2, and a quarter of its inverse root 0.00059.
        let expected = "step 64: atom 1 goes 0.16 in a timestep, farther than half the skin (0.15); nearest to it is atom 2 at \
                        distance 4.64";
        let report = report(&folder);
        let told = report["warnings"].as_array().unwrap();
        assert_eq!(told.len(), 1, "{}: {told:?}", variant.name);
        let told = told[0].as_str().unwrap();
        assert!(told.starts_with(expected), "{}: {told}", variant.name);
        assert_eq!(after(told, "a timestep of "), "0.00059", "{}", variant.name);
        assert!(report["neighbors"]["dangerous"].as_u64().unwrap() > 0);
    }
}

#[test]
fn an_energy_that_does_not_stay_is_told() {
    let folder = Folder::new("energy");
    folder.write("a.in", &liquid("0.025", "thermo 10\nrun 5000"));
    for (variant, words) in told() {
        folder.fails(1, &format!("run a.in {words}"));
        let log = folder.read("log.octant");
        let energy: Vec<_> = warnings(&log).into_iter().filter(|w| w.contains("the total energy, which")).collect();
        assert_eq!(energy.len(), 1, "{}: {log}", variant.name);
        assert!(
            energy[0].contains(": since step 0 the total energy, which should stay, has risen by "),
            "{}",
            energy[0]
        );
        assert!(energy[0].contains("; the fastest is atom ") && energy[0].contains("; nearest to it is atom "));
        assert!(energy[0].contains("; a timestep of "), "{}", energy[0]);
    }
}

fn overlapping(fixes: &str, run: &str) -> String {
    format!(
        "units lj\nregion b block 0 10 0 10 0 10 units box\ncreate_box 1 b\ncreate_atoms 1 single 2 3 4\n\
         create_atoms 1 single 5 6 7\ncreate_atoms 1 single 5 6 7.5\nmass 1 1\npair_style lj/cut 2.5\npair_coeff 1 1 1 1\n\
         {fixes}\nthermo 1000\n{run}\n"
    )
}

/// Half a sigma apart: energy 16128, from which nothing flies well at the usual timestep.
#[test]
fn atoms_that_overlap_at_the_start_are_named_with_a_timestep_that_parts_them() {
    let folder = Folder::new("overlap");
    for (variant, words) in told() {
        let name = &variant.name;
        folder.write("a.in", &overlapping("fix 1 all nve", "run 100"));
        folder.fails(1, &format!("run a.in {words}"));
        let log = folder.read("log.octant");
        let told = warnings(&log);
        assert_eq!(told.len(), 3, "{name}: {told:?}");
        assert!(told.iter().all(|line| line.starts_with("step 1: ")), "{name}: {told:?}");
        let pair = ["atom 2", "atom 3"];
        assert!(told.iter().all(|line| pair.iter().all(|atom| line.contains(atom))), "{name}: {told:?}");
        // U'' = (156 16384 - 42 256) / 0.25 of a mass of 1/2 is omega^2, and 0.25 / omega 5.5e-5.
        assert_eq!(after(told[0], "a timestep of "), "5.5e-05", "{name}");
        folder.write("b.in", &overlapping("fix 1 all nve", "timestep 5.5e-5\nrun 5000"));
        folder.says(&format!("run b.in --json report.json {words}"));
        let report = report(&folder);
        assert_eq!(report["warnings"].as_array().unwrap().len(), 0, "{name}: {report}");
        let rows = report["thermo"].as_array().unwrap();
        let energy = |row: &Value| row["TotEng"].as_f64().unwrap();
        let off = energy(&rows[rows.len() - 1]) / energy(&rows[0]) - 1.0;
        assert!(off.abs() < 1.0 / 64.0, "{name}: {off}");
    }
}

/// A bath of temperature 1 explains a temperature of 1, and no other.
#[test]
fn a_temperature_that_comes_from_nowhere_is_told_of_scenes_with_a_bath() {
    let folder = Folder::new("temperature");
    let bath = "fix 1 all nve\nfix 2 all langevin 1.0 1.0 0.1 4711";
    for (variant, words) in told() {
        folder.write("a.in", &overlapping(bath, "run 100"));
        folder.fails(1, &format!("run a.in {words}"));
        let log = folder.read("log.octant");
        let told = warnings(&log);
        let jump = told.iter().find(|line| line.contains(": since step 0 the temperature has jumped from 0 to "));
        assert!(jump.is_some_and(|line| line.starts_with("step 1: ")), "{}: {told:?}", variant.name);
        assert!(!told.iter().any(|line| line.contains("the total energy")), "{}: {told:?}", variant.name);
        // Brought from rest to the bath's temperature, which takes energy: as it should be.
        let cold =
            melt("fix 2 all langevin 1.0 1.0 0.1 4711\nthermo 20\nrun 400").replace("create 3.0", "create 0.001");
        folder.write("b.in", &cold);
        folder.says(&format!("run b.in {words}"));
        let log = folder.read("log.octant");
        assert!(warnings(&log).is_empty(), "{}: {log}", variant.name);
    }
}

#[test]
fn a_large_timestep_that_holds_is_no_reason_for_a_warning() {
    let folder = Folder::new("holds");
    for (variant, words) in told() {
        // A step of plain truncation in the force, and none; with and without rows on the way.
        for (scene, thermo) in [(melt("timestep 0.012\n{}"), "0"), (liquid("0.012", "{}"), "20")] {
            folder.write("a.in", &scene.replace("{}", &format!("thermo {thermo}\nrun 2000")));
            folder.says(&format!("run a.in --json report.json {words}"));
            assert_eq!(report(&folder)["warnings"].as_array().unwrap().len(), 0, "{}", variant.name);
        }
    }
}

#[test]
fn scenes_that_come_along_have_no_warnings() {
    let folder = Folder::new("inputs");
    let inputs = root().join("inputs");
    for entry in std::fs::read_dir(&inputs).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.extension().is_none_or(|kind| kind != "in") {
            continue;
        }
        // As they are but for their trajectories; those that have a size are made smaller.
        let script = std::fs::read_to_string(&entry).unwrap();
        let lines: Vec<&str> = script.lines().filter(|line| !line.starts_with("dump ")).collect();
        folder.write("a.in", &(lines.join("\n") + "\n"));
        let data = inputs.join("mixture.data");
        let variables = format!("-v size=6 -v steps=200 -v data={}", data.display());
        folder.says(&format!("run a.in --json report.json {variables}"));
        let report = report(&folder);
        assert_eq!(report["warnings"].as_array().unwrap().len(), 0, "{}: {report}", entry.display());
    }
}

/// A timestep that is proposed follows a collision; one eight times as long is at the limit of stability, and does not.
#[test]
fn a_proposed_timestep_follows_a_head_on_collision() {
    let space = free_or_periodic([0.0; 3], [30.0; 3], [true; 3]);
    for variant in variants() {
        for speed in [4.0, 40.0] {
            let mut state = State::default();
            state.push(1, 1, Vec3::new(10.0, 15.0, 15.0));
            state.push(2, 1, Vec3::new(12.4, 15.0, 15.0));
            state.v[0].x = speed;
            let mut program = program(&[2.5], 0.3, Search::Trimmed);
            program.timestep = 0.1;
            let stride = Stride::fastest(&program, &state).unwrap();
            let nearest = stride.nearest(&state, &space);
            assert_eq!((stride.id, nearest.map(|(id, _)| id)), (1, Some(2)));
            let proposed = stride.timestep(&program, &state, nearest).unwrap();
            // The largest change of the energy on the way, in the kinetic energy.
            let worst = |timestep: f64| {
                program.timestep = timestep;
                let mut backend = started(&variant, 1, &program, &state, &space);
                let energy = |sums: &octant::engine::Sums| sums.potential + 0.5 * sums.kinetic[..3].iter().sum::<f64>();
                let start = energy(&backend.sums().unwrap());
                let mut worst: f64 = 0.0;
                for _ in 0..(3.0 / speed / timestep) as usize {
                    advanced(&variant, &mut *backend, 1);
                    worst = worst.max((energy(&backend.sums().unwrap()) - start).abs());
                }
                worst / (0.5 * speed * speed)
            };
            // (omega dt)^2 / 4 of the energy of the relative motion, half of all.
            let [fine, coarse] = [proposed, 8.0 * proposed].map(worst);
            assert!(fine < 0.5 / 64.0 && coarse > 0.1, "{}: {fine} {coarse} at speed {speed}", variant.name);
        }
    }
}

/// Lists that are checked have a number of dangerous builds, as LAMMPS counts them, those that are not have none.
#[test]
fn dangerous_builds_are_counted_where_they_are_checked_for() {
    let folder = Folder::new("dangerous");
    let cases = [
        ("every 1 delay 0 check yes", Some(false), "Dangerous builds = 0"),
        // From one chance to the next, the fastest of these go farther than half the skin.
        ("every 20 delay 0 check yes", Some(true), "Dangerous builds = 5"),
        ("every 20 delay 0 check no", None, "Dangerous builds not checked"),
        ("once yes", Some(false), "Dangerous builds = 0"),
    ];
    for (variant, words) in told() {
        for (policy, some, line) in cases {
            folder.write("a.in", &melt(&format!("neigh_modify {policy}\nrun 100")));
            folder.says(&format!("run a.in --json report.json {words}"));
            let dangerous = &report(&folder)["neighbors"]["dangerous"];
            assert_eq!(dangerous.as_u64().map(|n| n > 0), some, "{}: {policy}", variant.name);
            assert_eq!(dangerous.is_null(), some.is_none());
            assert!(folder.read("log.octant").lines().any(|l| l == line), "{}: {policy}", variant.name);
        }
    }
}
