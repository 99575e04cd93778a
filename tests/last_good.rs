//! What is on disk of a run that ended before its time (`--on-error`).

#[path = "common/cli.rs"]
mod cli;
mod common;

use cli::{Folder, melt};
use common::told;

const FILE: &str = "last-good.data";

fn step_of(folder: &Folder) -> i64 {
    let file = folder.read(FILE);
    let text = file.lines().next().unwrap().split("timestep = ").nth(1).unwrap();
    text.split(',').next().unwrap().parse().unwrap()
}

/// Runs on from the file, with coefficients of its own: those in it may be what ended the run.
fn goes_on(folder: &Folder, words: &str) {
    let script = format!(
        "units lj\npair_style lj/cut 2.5\nread_data {FILE}\npair_coeff 1 1 1.0 1.0\nfix 1 all nve\ntimestep 1e-9\nrun 20\n"
    );
    folder.write("again.in", &script);
    assert!(folder.says(&format!("run again.in --log again.log {words}")).contains("Loop time of"));
    std::fs::remove_file(folder.0.join(FILE)).unwrap();
}

const RUN: &str = "thermo 10\nrun 50\n";

/// Whatever ends a run, the state that was good last is there.
#[test]
fn every_stop_leaves_the_last_good_state() {
    let folder = Folder::new("stops");
    let broken =
        melt("velocity all set 1e200 0 0\ntimestep 1e-210\nrun 5").replace("velocity all create 3.0 87287\n", "");
    let cases = [
        // A timestep that throws atoms out: the state of the last list build.
        (melt("timestep 0.05\nrun 100"), "lost atom", None),
        // Energies that are no numbers.
        (broken, "is beyond the range of numbers", Some(0)),
        // A table that has no value: the particles are fine where it stops.
        (
            melt("variable v equal 1/(20-step)\nthermo_style custom step v_v\nthermo 10\nrun 50"),
            "division by zero",
            Some(20),
        ),
        // A second run that has no forces to begin with.
        (melt(&format!("{RUN}pair_coeff 1 1 1.0 1e30\nrun 10")), "step 50: non-finite force", Some(50)),
        // A command after a run, which only the run could judge.
        (melt(&format!("{RUN}variable s equal $(0*ke)\nvelocity all create -$(temp) 1\nrun 10")), "velocity", Some(50)),
    ];
    for (variant, words) in told() {
        for (script, what, step) in &cases {
            folder.write("a.in", script);
            let said = folder.fails(1, &format!("run a.in {words}"));
            // Speeds of 1e200 are no numbers of single precision, which a set-up may find: nothing has been good yet.
            if script.contains("1e200") && said.contains("non-finite position or velocity") {
                assert!(!folder.has(FILE), "{}: {said}", variant.name);
                continue;
            }
            assert!(said.contains(what), "{}: {said}", variant.name);
            let written = step_of(&folder);
            assert!(step.is_none_or(|step| step == written), "{}: {what}: {written}", variant.name);
            let log = folder.read("log.octant");
            let place = format!("he state of step {written} is in {FILE} (read_data takes it)");
            assert!(log.contains(&place), "{}: {log}", variant.name);
            if script.contains("1e200") {
                // Its speeds are what they were: the file is fine, the run would not be.
                folder.write("again.in", &format!("units lj\npair_style lj/cut 2.5\nread_data {FILE}\n"));
                assert!(folder.says("check again.in").contains("fine: ") && folder.read(FILE).contains("e+200"));
                continue;
            }
            goes_on(&folder, &words);
        }
    }
}

#[test]
fn a_script_that_fails_before_its_first_step_leaves_nothing() {
    let folder = Folder::new("nothing");
    folder.write("a.in", &melt("pair_coeff 1 1 1.0\nrun 10"));
    folder.fails(1, "run a.in --on-error checkpoint");
    assert!(!folder.has(FILE));
    folder.fails(2, "run a.in --on-error never");
    folder.fails(2, "run a.in --on-error checkpoint --checkpoint-every 0");
}

/// Output brings particles of every step to this side: those after a warning are not what is kept.
#[test]
fn dumps_do_not_bring_a_spoiled_state_to_disk() {
    let folder = Folder::new("dumped");
    folder.write("a.in", &melt("thermo 1\ndump 1 all atom 1 a.dump\ntimestep 0.025\nrun 5000"));
    for (variant, words) in told() {
        let said = folder.fails(1, &format!("run a.in {words}"));
        let (written, log) = (step_of(&folder), folder.read("log.octant"));
        let jump = log.lines().find(|line| line.contains("the total energy, which")).unwrap();
        let jump: i64 = jump["WARNING: step ".len()..].split(':').next().unwrap().parse().unwrap();
        assert_eq!(written, jump - 1, "{}: {said}", variant.name);
        assert!(said.contains(&format!("the state of step {written}, before the warning, is in {FILE}")), "{said}");
        goes_on(&folder, &words);
    }
}

/// A script that ends after a run whose energy has jumped leaves the state from before that, too.
#[test]
fn an_error_after_a_run_that_was_spoiled_keeps_what_was_there_before() {
    let folder = Folder::new("spoiled");
    let scene = melt(
        "pair_modify shift yes\ntimestep 0.02\nthermo 1\nrun 60\nvariable s equal $(0*ke)\nvelocity all create -$(temp) 1",
    );
    folder.write("a.in", &scene.replace("lj/cut 2.5", "lj/cut 1.2"));
    for (variant, words) in told() {
        folder.fails(1, &format!("run a.in {words}"));
        let log = folder.read("log.octant");
        let Some(jump) = log.lines().find(|line| line.contains("the total energy, which")) else {
            panic!("{}: no warning: {log}", variant.name);
        };
        let jump: i64 = jump["WARNING: step ".len()..].split(':').next().unwrap().parse().unwrap();
        assert!(step_of(&folder) < jump && log.contains(", before the warning, is in"), "{}: {log}", variant.name);
        goes_on(&folder, &words);
    }
}

/// With checkpoints the latest from before a warning of the energy stays, as what came after it is spoiled.
#[test]
fn checkpoints_do_not_follow_a_run_beyond_a_jump_of_its_energy() {
    let folder = Folder::new("jump");
    folder.write("a.in", &melt("thermo 1\ntimestep 0.025\nrun 5000"));
    for (variant, words) in told() {
        let said = folder.fails(1, &format!("run a.in --on-error checkpoint --checkpoint-every 0.000001 {words}"));
        let (written, log) = (step_of(&folder), folder.read("log.octant"));
        let place = format!("the state of step {written}, before the warning, is in {FILE} (read_data takes it)");
        assert!(said.contains(&place), "{}: {said}", variant.name);
        let jump = log.lines().find(|line| line.contains("the total energy, which")).unwrap();
        let jump: i64 = jump["WARNING: step ".len()..].split(':').next().unwrap().parse().unwrap();
        assert!(written < jump, "{}: {written} {jump}", variant.name);
        goes_on(&folder, &words);
    }
}

#[test]
fn checkpoints_change_no_bit_and_end_with_the_last_step() {
    let folder = Folder::new("same");
    folder.write("a.in", &melt("thermo 7\nthermo_modify format float %.17g\nrun 100"));
    let table = |log: String| -> Vec<String> {
        let rows = log.lines().skip_while(|line| !line.trim_start().starts_with("Step")).skip(1);
        rows.take_while(|line| !line.starts_with("Loop time")).map(String::from).collect()
    };
    for (variant, words) in told() {
        folder.says(&format!("run a.in {words}"));
        assert!(!folder.has(FILE), "{}: a run that ends well leaves none", variant.name);
        let plain = table(folder.read("log.octant"));
        folder.says(&format!("run a.in --on-error checkpoint --checkpoint-every 0.000001 {words}"));
        assert_eq!(table(folder.read("log.octant")), plain, "{}", variant.name);
        assert_eq!((plain.len(), step_of(&folder)), (16, 100), "{}", variant.name);
        goes_on(&folder, &words);
    }
}

#[cfg(unix)]
mod killed {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    use super::*;

    /// Starts a run without an end, waits for a checkpoint beyond its first step, and sends a signal.
    fn stopped_by(folder: &Folder, words: &str, signal: &str) -> Option<i32> {
        let mut child = Command::new(assert_cmd::cargo::cargo_bin("octant"))
            .current_dir(&folder.0)
            .args("run a.in --on-error checkpoint --checkpoint-every 0.01".split(' ').chain(words.split(' ')))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let begun = Instant::now();
        while !(folder.has(FILE) && step_of(folder) > 0) {
            assert!(begun.elapsed() < Duration::from_secs(100), "no checkpoint");
            std::thread::sleep(Duration::from_millis(5));
        }
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        child.wait().unwrap().code()
    }

    #[test]
    fn an_interrupt_leaves_the_last_step_without_checkpoints_too() {
        let folder = Folder::new("interrupt");
        folder.write("a.in", &melt("thermo 50\nthermo_modify flush yes\nrun 100000000"));
        for (_, words) in told() {
            for signal in ["-INT", "-TERM"] {
                let _ = std::fs::remove_file(folder.0.join("log.octant"));
                let mut child = Command::new(assert_cmd::cargo::cargo_bin("octant"))
                    .current_dir(&folder.0)
                    .args("run a.in".split(' ').chain(words.split(' ')))
                    .stdout(Stdio::null())
                    .spawn()
                    .unwrap();
                let begun = Instant::now();
                let row = |line: &str| line.trim_start().starts_with("50 ");
                while !(folder.has("log.octant") && folder.read("log.octant").lines().any(row)) {
                    assert!(begun.elapsed() < Duration::from_secs(100), "no steps");
                    std::thread::sleep(Duration::from_millis(5));
                }
                assert!(!folder.has(FILE), "nothing is written on the way");
                assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
                assert_eq!(child.wait().unwrap().code(), Some(130));
                let (step, log) = (step_of(&folder), folder.read("log.octant"));
                assert!(log.contains(&format!("for {step} steps with")), "{log}");
                assert!(log.contains(&format!("The state of step {step} is in {FILE} (read_data takes it)")), "{log}");
                goes_on(&folder, &words);
            }
        }
    }

    #[test]
    fn a_kill_leaves_a_checkpoint_and_an_interrupt_the_last_step() {
        let folder = Folder::new("kill");
        folder.write("a.in", &melt("thermo 1000000\nrun 100000000"));
        for (variant, words) in told() {
            assert_eq!(stopped_by(&folder, &words, "-KILL"), None);
            goes_on(&folder, &words);
            assert_eq!(stopped_by(&folder, &words, "-INT"), Some(130), "{}", variant.name);
            let end = format!("for {} steps with", step_of(&folder));
            assert!(folder.read("log.octant").contains(&end), "{}", variant.name);
            goes_on(&folder, &words);
        }
    }
}
