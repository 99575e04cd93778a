//! What each option of the scene costs: the time of a step with it over that without.

use std::path::PathBuf;

use super::measure::{self, number};
use super::point::Point;
use super::store::Table;
use super::study::{Study, is_nve, pair_commands};
use crate::Error;
use crate::bench::{Halt, go};
use crate::engine::Precision;
use crate::pair::PairTable;
use crate::session::{Driven, Prepared, Settings};
use crate::system::{RanPark, Side};

/// Time of a step with an option.
pub static PRICES: Table = Table {
    name: "prices",
    keys: &["round", "option"],
    values: &["compared_with", "steps", "microseconds_per_step", "builds", "lost", "same_program", "fault"],
};

/// The scene without any option, in the table.
pub const PLAIN: &str = "the scene as it is";
/// The same after options were switched on and off again.
pub const OFF_AGAIN: &str = "all of these on, then off again";
const OPEN: &str = "open along z, with room beyond";
const LOSING: &str = "open along z, atoms that leave are lost";
/// Room beyond an open side, cutoffs: more than an atom flies in a leg.
const ROOM: f64 = 100.0;
const TWO_TYPES: &str = "two types";
const CUTOFFS: &str = "a cutoff for each pair of types";
/// Types are dealt out with this seed.
const SEED: u32 = 12345;
/// What the cutoffs of the first and the last type have less and more than the script's: a list then has about as many pairs.
const CUTOFF_STEP: f64 = 0.04;

/// Something that a scene may switch on.
pub struct Priced {
    pub name: String,
    /// The option whose time it is compared with.
    pub base: &'static str,
    change: fn(&mut Prepared),
    /// `{FOLDER}` stands for a folder that is removed afterwards.
    commands: String,
}

/// The options that this scene could switch on, the plain scene first.
pub fn options(study: &Study) -> Vec<Priced> {
    let nothing: fn(&mut Prepared) = |_| {};
    let plain = |name: &str, commands: String| Priced { name: name.into(), base: PLAIN, change: nothing, commands };
    let program = &study.program;
    let mut all = vec![plain(PLAIN, String::new()), plain("energy and virial at every step", "thermo 1\n".into())];
    let (own, other) = (study.truncation(program.pair.shift), study.truncation(!program.pair.shift));
    if study.jumps() {
        let name = if program.pair.tail { other.as_str() } else { other.trim_end_matches(" tail no") };
        all.push(plain(name, format!("{other}\n")));
    }
    all.push(plain("fix gravity", "fix price_gravity all gravity 1e-9 vector 0 0 -1\n".into()));
    let dump = "dump price_dump all custom 50 {FOLDER}/price.dump id type x y z\n";
    all.push(plain("trajectory, text, every 50 steps", dump.into()));
    if cfg!(feature = "chemfiles") {
        let xtc = "dump price_dump all xtc 50 {FOLDER}/price.xtc\n";
        all.push(plain("trajectory, xtc, every 50 steps", xtc.into()));
    }
    let pair = &program.pair;
    let has_cutoffs = !pair.pairs[0].coefficients.is_empty();
    if pair.types == 1 && has_cutoffs {
        let two = PairTable { types: 2, pairs: vec![pair.pairs[0].clone(); 4], ..pair.clone() };
        let change: fn(&mut Prepared) = deal_types;
        all.push(Priced { name: TWO_TYPES.into(), base: PLAIN, change, commands: coefficients(&two, 0.0) });
        let (name, commands) = (format!("{TWO_TYPES}, {CUTOFFS}"), coefficients(&two, CUTOFF_STEP));
        all.push(Priced { name, base: TWO_TYPES, change, commands });
    } else if has_cutoffs && pair.pairs.iter().all(|of| of.cutoff == pair.pairs[0].cutoff) {
        all.push(plain(CUTOFFS, coefficients(pair, CUTOFF_STEP)));
    }
    if study.is_moved_by_nve() && study.space.periodic(2) {
        let lost = "thermo_modify lost ignore\n";
        all.push(Priced { name: OPEN.into(), base: PLAIN, change: give_room_along_z, commands: lost.into() });
        all.push(Priced { name: LOSING.into(), base: OPEN, change: open_along_z, commands: lost.into() });
        let walls = format!("{lost}fix price_walls all wall/reflect zlo EDGE zhi EDGE\n");
        all.push(Priced {
            name: "walls along z in place of periods".into(),
            base: PLAIN,
            change: open_along_z,
            commands: walls,
        });
    }
    let (t, damp) = (study.temperature, 100.0 * program.timestep);
    let langevin = format!("fix price_heat all langevin {t} {t} {damp} 4711\n");
    let is_heated = study.is_moved_by_nve() && t > 0.0;
    if is_heated {
        all.push(plain("thermostat, fix langevin", langevin.clone()));
        let commands = format!("fix price_heat all nvt temp {t} {t} {damp}\n");
        let name = "thermostat, fix nvt in place of nve".to_string();
        all.push(Priced { name, base: PLAIN, change: take_nve_off, commands });
    }
    let (heat, no_heat) = if is_heated { (langevin.as_str(), "unfix price_heat\n") } else { ("", "") };
    let on_and_off = format!(
        "thermo 1\n{other}\nfix price_gravity all gravity 1e-9 vector 0 0 -1\n{heat}{dump}\
         run 0\nthermo 0\n{own}\nunfix price_gravity\n{no_heat}undump price_dump\n"
    );
    all.push(plain(OFF_AGAIN, on_and_off));
    all
}

/// `pair_coeff` of all pairs of types, with cutoffs that grow with their numbers from this part below their own to as much above.
fn coefficients(pair: &PairTable, step: f64) -> String {
    let mut pair = pair.clone();
    for (k, of) in pair.pairs.iter_mut().enumerate() {
        let (i, j) = (k / pair.types, k % pair.types);
        of.cutoff *= 1.0 + step * ((i + j) as f64 / (pair.types - 1) as f64 - 1.0);
    }
    let commands = pair_commands(pair.style, &pair);
    // The style stays what it is: its settings stand in the script.
    commands.lines().filter(|line| line.starts_with("pair_coeff")).map(|line| format!("{line}\n")).collect()
}

/// Takes off what moves all atoms.
fn take_nve_off(prepared: &mut Prepared) {
    prepared.scene_mut().fixes.retain(|fix| !is_nve(fix));
}

/// A second type, like the first, for half of the atoms at random.
fn deal_types(prepared: &mut Prepared) {
    let scene = prepared.scene_mut();
    let mass = scene.masses[0];
    scene.masses.push(mass);
    if let Some(pair) = &mut scene.pair {
        pair.set_types(2);
    }
    let mut random = RanPark::new(SEED);
    scene.state.kind.iter_mut().for_each(|kind| *kind = if random.uniform() < 0.5 { 1 } else { 2 });
}

/// Free sides along z in place of periodic ones.
fn open_along_z(prepared: &mut Prepared) {
    let scene = prepared.scene_mut();
    if let Some(space) = &mut scene.space {
        scene.state.settle(space);
        space.sides[2] = [Side::Fixed; 2];
    }
}

/// Free sides along z, so far out that nothing is lost.
fn give_room_along_z(prepared: &mut Prepared) {
    open_along_z(prepared);
    let scene = prepared.scene_mut();
    if let (Some(space), Some(pair)) = (&mut scene.space, &scene.pair) {
        let room = ROOM * pair.complete().map_or(1.0, |(table, ..)| table.largest_cutoff());
        (space.lo.z, space.hi.z) = (space.lo.z - room, space.hi.z + room);
    }
}

/// A folder of its own in the system's folder for such, removed when dropped.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Result<Self, Error> {
        let path = std::env::temp_dir().join(format!("octant-report-{}", std::process::id()));
        std::fs::create_dir_all(&path).map_err(|e| Error::file(&path, "cannot create the folder", e))?;
        Ok(Self(path))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Times the scene with an option.
pub fn price(study: &Study, precision: Precision, option: usize, seconds: f64) -> Result<Vec<String>, Halt> {
    let option = &options(study)[option];
    let point = Point { policy: study.safe(), ..study.own(precision) };
    let measured = || {
        let scratch = Scratch::new()?;
        // Faults leave the last good state beside the log.
        let log = Some(scratch.0.join("log"));
        let settings = Settings { no_files: false, log, ..study.settings(precision).clone() };
        let (mut prepared, set_up) = study.variant(&point);
        (option.change)(&mut prepared);
        let mut driven = Driven::new(prepared, &settings)?;
        go(&mut driven, &set_up)?;
        go(&mut driven, &option.commands.replace("{FOLDER}", &scratch.0.display().to_string()))?;
        let same = if option.name == OFF_AGAIN { is_plain(study, &point, &mut driven)? } else { "" };
        let leg = measure::leg(&mut driven, seconds)?;
        let step = number(1e6 * leg.seconds / leg.steps as f64);
        let (builds, lost) = (leg.builds.to_string(), driven.backend().lost().to_string());
        Ok(vec![option.base.into(), leg.steps.to_string(), step, builds, lost, same.into(), String::new()])
    };
    match measured() {
        Err(Halt::Error(Error::Fault(message))) => {
            let fault = message.lines().next().unwrap_or_default().to_string();
            let mut cells = vec![String::new(); PRICES.values.len()];
            (cells[0], cells[PRICES.values.len() - 1]) = (option.base.into(), fault);
            Ok(cells)
        }
        other => other,
    }
}

/// Whether what runs is the same as if no option had ever been switched on: the step as data, and what the engine says of its kernels.
fn is_plain<'a>(study: &'a Study, point: &Point, driven: &mut Driven<'a>) -> Result<&'static str, Halt> {
    let mut plain = study.begin(point)?;
    for engine in [&mut plain, &mut *driven] {
        go(engine, "run 0")?;
    }
    // Working memory is no kernel: it grows by what each thread happened to do.
    let kernels = |engine: &Driven<'_>| -> Vec<String> {
        engine.backend().explain().into_iter().filter(|line| !line.starts_with("An atom: ")).collect()
    };
    let same = plain.program()? == driven.program()? && kernels(&plain) == kernels(driven);
    Ok(if same { "yes" } else { "no" })
}
