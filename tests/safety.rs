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

/// A cold liquid of 500 atoms at a timestep of choice.
fn cold(timestep: &str) -> String {
    format!(
        "units lj\nlattice fcc 0.8442\nregion b block 0 5 0 5 0 5\ncreate_box 1 b\ncreate_atoms 1 box\nmass 1 1\n\
         velocity all create 1.44 87287 loop geom\npair_style lj/cut 2.5\npair_coeff 1 1 1 1\nfix 1 all nve\n\
         timestep {timestep}\nthermo 10\nrun 200\n"
    )
}

/// Goes on from the last good state at the proposed timestep: no warning, and the energy stays to (omega dt)^2 / 4 = 1/64 of the
/// kinetic energy that there is at most.
fn follows(folder: &Folder, scene: &str, timestep: &str, words: &str) {
    let script = format!("{scene}timestep {timestep}\nthermo 20\nthermo_style custom step ke etotal\nrun 400\n");
    folder.write("again.in", &script);
    folder.says(&format!("run again.in --log again.log --json again.json {words}"));
    let report: Value = serde_json::from_str(&folder.read("again.json")).unwrap();
    assert_eq!(report["warnings"].as_array().unwrap().len(), 0, "{report}");
    let rows = report["thermo"].as_array().unwrap();
    let column = |name: &str| rows.iter().map(|row| row[name].as_f64().unwrap()).collect::<Vec<_>>();
    let (kinetic, total) = (column("KinEng"), column("TotEng"));
    let most = kinetic.iter().copied().fold(0.0, f64::max);
    let off = total.iter().map(|e| (e - total[0]).abs()).fold(0.0, f64::max);
    assert!(off < most / 64.0, "{off} of {most}");
}

const FROM_GOOD: &str = "units lj\npair_style lj/cut 2.5\nread_data last-good.data\nfix 1 all nve\n";

/// However large the timestep: the warning and the stop name one that would do, and the state on disk is from before anything was
/// spoiled, so that it does.
#[test]
fn the_state_on_disk_is_from_before_the_jump_and_the_timestep_follows_it() {
    let folder = Folder::new("before");
    for (variant, words) in told() {
        for timestep in ["0.05", "1", "100", "1e300"] {
            folder.write("a.in", &cold(timestep));
            let said = folder.fails(1, &format!("run a.in --json report.json {words}"));
            let name = format!("{} {timestep}: {said}", variant.name);
            let log = folder.read("log.octant");
            let proposed = after(warnings(&log)[0], "a timestep of ").to_string();
            assert!(said.contains(&format!("\n  a timestep of {proposed} would do\n")), "{name}");
            assert!(folder.read("last-good.data").contains("timestep = 0,"), "{name}");
            let jumped = warnings(&log).iter().any(|line| line.contains(" since step 0 "));
            assert_eq!(
                said.contains("the state of step 0, before the warning, is in last-good.data"),
                jumped,
                "{name}"
            );
            // What the list was stands in the report all the same.
            let neighbors = &report(&folder)["neighbors"];
            assert!(neighbors["total"].as_u64().unwrap() > 10_000, "{neighbors}");
            assert!(neighbors["dangerous"].is_u64() && neighbors["per_atom"].as_f64().unwrap() > 20.0, "{neighbors}");
            follows(&folder, FROM_GOOD, &proposed, &words);
        }
    }
}

/// A later state that passes all checks is kept rather than the start of the run.
#[test]
fn a_stop_without_a_jump_keeps_a_late_state() {
    let folder = Folder::new("late");
    // An atom flies out of a box with fixed sides: nothing is wrong with the states before.
    let scene = "units lj\nboundary f f f\nregion b block 0 20 0 20 0 20 units box\ncreate_box 1 b\n\
                 create_atoms 1 single 2 3 4\ncreate_atoms 1 single 15 15 15\nmass 1 1\nvelocity all set 1 0 0\n\
                 pair_style lj/cut 2.5\npair_coeff 1 1 1 1\nfix 1 all nve\nrun 2000\n";
    folder.write("a.in", scene);
    for (variant, words) in told() {
        let said = folder.fails(1, &format!("run a.in {words}"));
        let step: i64 = after(&said, "the state of step ").parse().unwrap();
        // 5 sigma at a speed of 1 take 1000 steps; lists are built every 0.15 / 0.005 = 30 of them.
        assert!((900..1000).contains(&step), "{}: {said}", variant.name);
        assert!(!said.contains("would do"), "{said}");
    }
}

/// The timestep is proposed of the state before two atoms that overlap part, not of what they fly apart as.
#[test]
fn a_timestep_is_proposed_of_the_state_before_the_jump() {
    let folder = Folder::new("proposed");
    let scene = "units lj\nregion b block 0 12 0 12 0 12\nlattice sc 1\ncreate_box 1 b\ncreate_atoms 1 single 6 6 6\n\
                 create_atoms 1 single 6.1 6 6\ncreate_atoms 1 single 2 2 2\nmass 1 1\npair_style lj/cut 2.5\n\
                 pair_coeff 1 1 1 1\nfix 1 all nve\ntimestep 2e-8\nthermo 20\nrun 100\n";
    folder.write("a.in", scene);
    for (variant, words) in told() {
        let said = folder.fails(1, &format!("run a.in {words}"));
        let log = folder.read("log.octant");
        // U'' = 4 (156 1e14 - 42 1e8) of a mass of 1/2 is 3.5e8^2, and a quarter of its inverse root 7.07e-10.
        assert_eq!(after(warnings(&log)[0], "a timestep of "), "7e-10", "{}", variant.name);
        assert!(said.contains("the stiffest pair is atoms 1 and 2 at distance 0.1 (omega dt = 7.065, stable below 2)"));
        follows(&folder, FROM_GOOD, "7e-10", &words);
    }
}

/// A pair that is stiff and slow among many that are fast and free: nothing that is summed up shows it before it breaks.
#[test]
fn a_stiff_pair_among_fast_atoms_is_named_by_the_stop() {
    let folder = Folder::new("stiff-pair");
    let scene = "units lj\nregion b block 0 20 0 20 0 20 units box\ncreate_box 2 b\nlattice sc 0.1\ncreate_atoms 1 box\n\
                 create_atoms 2 single 10.2 10.2 10.2 units box\ncreate_atoms 2 single 11.3 10.2 10.2 units box\n\
                 group g1 type 1\nmass * 1\nvelocity g1 create 3.0 4711\npair_style morse 2.0\npair_coeff 1 1 0.0 5 1.1\n\
                 pair_coeff 1 2 0.0 5 1.1\npair_coeff 2 2 100 20 1.12\nneighbor 0.6 bin\nfix 1 all nve\n";
    folder.write("a.in", &format!("{scene}timestep 0.01\nthermo 10000\nrun 3000\n"));
    for (variant, words) in told() {
        let said = folder.fails(1, &format!("run a.in {words}"));
        let stiff =
            "at step 0 the stiffest pair is atoms 1001 and 1002 at distance 1.1 (omega dt = 6.881, stable below 2)";
        assert!(said.contains(stiff), "{}: {said}", variant.name);
        let proposed = after(&said, "a timestep of ").to_string();
        assert!(said.contains("the state of step 0 is in last-good.data"), "{}: {said}", variant.name);
        let good = scene.split("region").next().unwrap().to_string()
            + "pair_style morse 2.0\nread_data last-good.data\nneighbor 0.6 bin\nfix 1 all nve\n";
        follows(&folder, &good, &proposed, &words);
    }
}

/// Nobody is told to use a fix that is used already.
#[test]
fn a_limit_that_is_there_is_not_offered() {
    let folder = Folder::new("limited");
    // 1e-3 sigma apart: a force beyond f32. In double the limit lets atoms go farther in a step than the box is long.
    let scene = |fix: &str, apart: &str| {
        format!(
            "units lj\nregion b block 0 12 0 12 0 12 units box\ncreate_box 1 b\ncreate_atoms 1 single 6 6 6\n\
             create_atoms 1 single 6 6 {apart}\nmass 1 1\npair_style lj/cut 2.5\npair_coeff 1 1 1 1\n{fix}\nrun 100\n"
        )
    };
    for (variant, words) in told() {
        for (fix, offered) in [("fix 1 all nve/limit 500", false), ("fix 1 all nve", true)] {
            folder.write("a.in", &scene(fix, "6.001"));
            let said = folder.fails(1, &format!("run a.in {words}"));
            assert_eq!(said.contains("takes overlapping atoms apart"), offered, "{}: {said}", variant.name);
        }
    }
}
