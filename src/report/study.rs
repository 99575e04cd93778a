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

/// Names of the variables of a script that hold what averages are compared with: U, energy units per atom, and P, pressure units.
const REFERENCES: [(&str, &str); 2] = [("U", "reference_u"), ("P", "reference_p")];

/// A scene with what is exact about it.
pub struct Study {
    pub(super) melted: Prepared,
    /// By precision.
    settings: Vec<Settings>,
    pub machine: Machine,
    /// What the user should know of the engine and of the scene.
    pub notes: Vec<String>,
    /// What had to be done to the scene before it could be studied.
    pub prepared: Option<String>,
    /// Net forces vanish by symmetry: there is nothing to compare errors with.
    pub still: bool,
    /// The scene with its thermostats, where it has some.
    pub(super) heated: Option<Prepared>,
    /// What averages are compared with, as the script's variables have it.
    pub reference: Vec<(&'static str, f64)>,
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
        let reference =
            REFERENCES.iter().filter_map(|(name, variable)| Some((*name, melted.variable(variable)?))).collect();
        let with_thermostats = melted.clone();
        let thermostats = take_thermostats_off(&mut melted);
        let heated = (!thermostats.is_empty()).then_some(with_thermostats);
        let program = melted.program(&quiet)?;
        let with = |precision| Settings { precision, variables: Vec::new(), ..quiet.clone() };
        let mut study = Self {
            settings: Precision::ALL.map(with).to_vec(),
            machine,
            notes: note.into_iter().collect(),
            prepared: None,
            still: false,
            heated,
            reference,
            space: melted.simulation_box().expect("a script that runs has a box").clone(),
            program,
            thermostats,
            temperature: 0.0,
            ids: Vec::new(),
            exact: Default::default(),
            melted,
        };
        study.look(sample);
        match study.leave_lattice(sample) {
            Ok(()) => Ok(Some(study)),
            Err(Halt::Interrupted) => Ok(None),
            Err(Halt::Error(error)) => Err(error),
        }
    }

    /// Looks at the particles: temperature, and which are compared.
    pub(super) fn look(&mut self, sample: usize) {
        let state = self.melted.state();
        let sum = sum_mass_velocity_squared(state, &self.program.masses, GROUP_ALL);
        self.temperature = temperature(sum, degrees_of_freedom(state.len()), &self.program.units);
        let all = exact::sample(state);
        self.ids = if all.len() <= sample { all } else { exact::sample_of(state, sample) };
        self.exact = Default::default();
    }

    /// The scene with its thermostats, and the commands that set the rest as [`Study::variant`] does; `None` where it has none.
    pub fn with_thermostats(&self, point: &Point) -> Option<(Prepared, String)> {
        let (_, commands) = self.variant(point);
        Some((self.heated.clone()?, commands))
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

    /// Commands for an energy that is continuous at the cutoff, or for the bare one. A shifted potential has no tail corrections; without
    /// them an energy differs by a constant.
    pub fn truncation(&self, shift: bool) -> String {
        let yes = |b: bool| if b { "yes" } else { "no" };
        format!("pair_modify shift {} tail {}", yes(shift), yes(self.program.pair.tail && !shift))
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
