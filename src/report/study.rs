//! The scene that is studied: what the script leaves at its end, and ways to run on from there.

use std::cell::OnceCell;
use std::path::Path;

use super::point::{Integrator, Point, Potential, safe};
use crate::Error;
use crate::bench::exact::{self, Atom};
use crate::bench::{Halt, Machine, go};
use crate::dynamics::Fix;
use crate::engine::{Precision, Program};
use crate::neighbor::Policy;
use crate::pair::PairTable;
use crate::session::{Driven, Prepared, Settings};
use crate::system::temperature::{degrees_of_freedom, sum_mass_velocity_squared, temperature};
use crate::system::{GROUP_ALL, LostAtoms, SimulationBox, Vec3};

/// Fixes that hold a temperature, and whether they move the atoms themselves: energies are measured without them, moved by `nve`.
const THERMOSTATS: [(&str, bool); 2] = [("nvt", true), ("langevin", false)];

/// Trajectories are compared over this many of the scene's fastest times: 0.4 tau of the Lennard-Jones liquid.
const FASTEST_TIMES: f64 = 7.0;

/// A scene with what is exact about it.
pub struct Study {
    melted: Prepared,
    /// By precision.
    settings: Vec<Settings>,
    pub machine: Machine,
    pub note: Option<String>,
    /// Of the scene as it is studied.
    pub program: Program,
    pub space: SimulationBox,
    /// Styles of thermostats that were taken off.
    pub thermostats: Vec<&'static str>,
    /// Temperature of the melted scene, temperature units.
    pub temperature: f64,
    /// Atoms whose forces are worked out by definition.
    ids: Vec<u32>,
    exact: [OnceCell<Vec<Atom>>; 2],
}

/// A potential's forces by definition, at the melted positions.
pub struct Exact<'a> {
    pub ids: &'a [u32],
    pub atoms: &'a [Atom],
}

impl Study {
    /// Carries the script out. `None` where the user interrupted it. Forces are compared on at most `sample` atoms.
    pub fn new(script: &Path, settings: &Settings, sample: usize) -> Result<Option<Self>, Error> {
        let quiet = Settings { log: None, json: None, quiet: true, no_files: true, ..settings.clone() };
        let (machine, note) = Machine::new(&quiet)?;
        let Some(mut melted) = Prepared::at_end(script, &quiet)? else { return Ok(None) };
        let thermostats = take_thermostats_off(&mut melted);
        let program = melted.program(&quiet)?;
        let state = melted.state();
        let sum = sum_mass_velocity_squared(state, &program.masses, GROUP_ALL);
        let temperature = temperature(sum, degrees_of_freedom(state.len()), &program.units);
        let all = exact::sample(state);
        let ids = if all.len() <= sample { all } else { exact::sample_of(state, sample) };
        let with = |precision| Settings { precision, variables: Vec::new(), ..quiet.clone() };
        Ok(Some(Self {
            settings: Precision::ALL.map(with).to_vec(),
            machine,
            note,
            space: melted.simulation_box().expect("a script that runs has a box").clone(),
            program,
            thermostats,
            temperature,
            ids,
            exact: [OnceCell::new(), OnceCell::new()],
            melted,
        }))
    }

    pub fn melted(&self) -> &Prepared {
        &self.melted
    }

    /// Host threads that a comparison may use.
    pub fn threads(&self) -> usize {
        match self.settings[0].threads {
            0 => std::thread::available_parallelism().map_or(1, |n| n.get()),
            n => n,
        }
    }

    pub fn atoms(&self) -> usize {
        self.melted.state().len()
    }

    pub fn settings(&self, precision: Precision) -> &Settings {
        &self.settings[precision as usize]
    }

    /// The scene's own way: its time step and list, in a precision.
    pub fn own(&self, precision: Precision) -> Point {
        let (potential, integrator) = (Potential::Own, Integrator::Own);
        Point { potential, integrator, precision, dt: self.program.timestep, policy: self.program.policy }
    }

    /// With the policy that never lacks a pair, and the script's skin.
    pub fn safe(&self) -> Policy {
        safe(&self.program.policy)
    }

    /// Whether `fix nve` on all atoms is all there is.
    pub fn is_plain(&self) -> bool {
        matches!(&self.program.fixes[..], [fix] if is_nve(fix))
    }

    /// Whether `fix nve` moves all atoms, whatever else there is.
    pub fn is_moved_by_nve(&self) -> bool {
        self.program.fixes.iter().any(is_nve)
    }

    /// Whether there is a force-shifted form of the potential.
    pub fn has_force_shifted(&self) -> bool {
        self.program.pair.style == "lj/cut"
    }

    /// Whether energies jump at the cutoff.
    pub fn jumps(&self) -> bool {
        self.program.pair.pairs.iter().any(|pair| pair.energy_at_cutoff != 0.0)
    }

    /// The scene with a point's potential and integrator, and the commands that set the rest.
    pub fn variant(&self, point: &Point) -> (Prepared, String) {
        let mut prepared = self.melted.clone();
        if point.integrator == Integrator::Euler2 {
            for fix in &mut prepared.scene_mut().fixes {
                if fix.style == "nve" {
                    fix.style = "nve/euler2";
                }
            }
        }
        let mut commands = match point.potential {
            Potential::Own => String::new(),
            Potential::ForceShifted => pair_commands("lj/smooth/linear", &self.program.pair),
        };
        let lost = match self.program.lost {
            LostAtoms::Error => "error",
            LostAtoms::Warn => "warn",
            LostAtoms::Ignore => "ignore",
        };
        let Policy { skin, every, delay, check, once } = point.policy;
        let yes = |b: bool| if b { "yes" } else { "no" };
        commands += &format!(
            "neighbor {skin} bin\nneigh_modify every {every} delay {delay} check {} once {}\ntimestep {}\n\
             thermo_style custom step etotal pe temp press\nthermo_modify norm yes lost {lost}\nthermo 0\n",
            yes(check),
            yes(once),
            point.dt,
        );
        (prepared, commands)
    }

    /// An engine with the melted scene, set for a point; nothing has been run.
    pub fn begin(&self, point: &Point) -> Result<Driven<'_>, Halt> {
        let (prepared, commands) = self.variant(point);
        let mut driven = Driven::new(prepared, self.settings(point.precision))?;
        go(&mut driven, &commands)?;
        Ok(driven)
    }

    /// The pair potential of the scene, or its force-shifted form.
    pub fn pair(&self, potential: Potential) -> Result<PairTable, Halt> {
        if potential == Potential::Own {
            return Ok(self.program.pair.clone());
        }
        let point = Point { potential, ..self.own(Precision::Double) };
        Ok(self.begin(&point)?.program()?.pair)
    }

    /// Forces by definition, worked out once.
    pub fn exact(&self, potential: Potential) -> Result<Exact<'_>, Halt> {
        let cell = &self.exact[potential as usize];
        if cell.get().is_none() {
            let pair = self.pair(potential)?;
            let atoms = exact::look_up(&pair, 0.0, self.melted.state(), &self.space, &self.ids, 0.0);
            let _ = cell.set(atoms);
        }
        Ok(Exact { ids: &self.ids, atoms: cell.get().expect("it was just set") })
    }

    /// Root mean square of the forces by definition, force units.
    pub fn rms_force(&self) -> Result<f64, Halt> {
        let exact = self.exact(Potential::Own)?;
        let sum: f64 = exact.atoms.iter().map(|atom| atom.force.norm_squared()).sum();
        Ok((sum / exact.atoms.len().max(1) as f64).sqrt())
    }

    /// Time units over which trajectories are compared, and the fastest time of the scene: 1 / w with w^2 = <F^2 / m> / (3 k T), the
    /// mean curvature that the atoms feel over their mass (the Einstein frequency). 80 of the script's steps, and `None`, where nothing
    /// moves or pushes.
    pub fn span(&self) -> Result<(f64, Option<f64>), Halt> {
        let exact = self.exact(Potential::Own)?;
        let (state, units) = (self.melted.state(), &self.program.units);
        let order = state.order_by_id();
        let mass = |id: &u32| {
            let place = order.binary_search_by_key(id, |k| state.id[*k]).expect("the sample is of this state");
            self.program.masses[state.kind[order[place]] as usize - 1]
        };
        let each = exact.ids.iter().zip(exact.atoms).map(|(id, atom)| atom.force.norm_squared() / mass(id));
        let mean = each.sum::<f64>() / exact.atoms.len().max(1) as f64;
        let squared = mean * units.ftm2v / (3.0 * units.boltzmann * self.temperature);
        let fastest = Some(1.0 / squared.sqrt()).filter(|t| t.is_finite() && *t > 0.0);
        Ok((fastest.map_or(80.0 * self.program.timestep, |t| FASTEST_TIMES * t), fastest))
    }

    /// The shortest vector between two positions.
    pub fn nearest(&self, d: Vec3) -> Vec3 {
        let edges = self.space.lengths();
        Vec3::from_fn(|a, _| if self.space.periodic(a) { d[a] - edges[a] * (d[a] / edges[a]).round() } else { d[a] })
    }

    /// Bits of the melted positions and velocities as one number (FNV-1a): the same study has the same.
    pub fn digest(&self) -> u64 {
        let state = self.melted.state();
        let numbers = state.x.iter().chain(&state.v).flat_map(|v| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>());
        numbers.fold(0xcbf2_9ce4_8422_2325, |hash, bits| (hash ^ bits).wrapping_mul(0x0000_0100_0000_01b3))
    }
}

/// Whether a fix is `nve` on all atoms.
pub fn is_nve(fix: &Fix) -> bool {
    fix.style == "nve" && fix.group == GROUP_ALL
}

/// `pair_style` and `pair_coeff` of all pairs, for a style with a cutoff in `pair_style`.
pub fn pair_commands(style: &str, pair: &PairTable) -> String {
    let mut commands = format!("pair_style {style} {}\n", pair.largest_cutoff());
    for i in 0..pair.types {
        for j in i..pair.types {
            let of = &pair.pairs[i * pair.types + j];
            let words: Vec<String> = of.coefficients.iter().chain([&of.cutoff]).map(f64::to_string).collect();
            commands += &format!("pair_coeff {} {} {}\n", i + 1, j + 1, words.join(" "));
        }
    }
    commands
}

/// Replaces thermostats by `nve`, or takes them off where something else moves the atoms; what they were.
fn take_thermostats_off(melted: &mut Prepared) -> Vec<&'static str> {
    let mut taken = Vec::new();
    let mut fixes = Vec::new();
    for mut fix in melted.scene().fixes.clone() {
        match THERMOSTATS.iter().find(|(style, _)| *style == fix.style) {
            Some((style, moves)) => {
                taken.push(*style);
                if *moves {
                    (fix.style, fix.choice, fix.parameters) = ("nve", 0, Vec::new());
                    fixes.push(fix);
                }
            }
            None => fixes.push(fix),
        }
    }
    if !taken.is_empty() {
        melted.scene_mut().fixes = fixes;
    }
    taken
}
