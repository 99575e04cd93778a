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

/// An atom that flies freely crosses the cutoff in that time at least; no trajectory is longer, nor has it more of the script's steps.
const MOST_STEPS: f64 = 1000.0;

/// Net forces below this part of what they are in equilibrium (of their squares: 3 k T times the curvature) are those of a lattice.
const STILL: f64 = 0.1;
/// Net forces are rounding that would pull an atom away by less than this part of the cutoff.
const ROUNDED: f64 = 1e-9;
/// For so many of its fastest times a scene is run on that has no forces yet: a crystal that is hot enough melts in about half of that.
const RUN_ON: f64 = 20.0;
const MOST_RUN_ON: u64 = 5000;

/// Names of the variables of a script that hold what averages are compared with: U, energy units per atom, and P, pressure units.
const REFERENCES: [(&str, &str); 2] = [("U", "reference_u"), ("P", "reference_p")];

/// How atoms swing about where they are: squares of their frequency, the Einstein frequency, in two ways that agree in equilibrium, and the
/// root mean square distance from where the curvature of the energy would have them, length units.
struct Swing {
    /// <F^2 / m> / (3 k T); infinite where forces push what has no temperature.
    by_force: f64,
    /// A third of the sum of the energy's second derivatives over the mass.
    by_curvature: f64,
    away: f64,
}

/// How fast a scene is.
#[derive(Clone, Debug)]
pub struct Pace {
    /// Time units over which trajectories are compared.
    pub span: f64,
    /// The scene's fastest time, time units.
    pub fastest: Option<f64>,
    /// Where that comes from.
    pub how: &'static str,
}

/// A scene with what is exact about it.
pub struct Study {
    melted: Prepared,
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
    heated: Option<Prepared>,
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
    fn look(&mut self, sample: usize) {
        let state = self.melted.state();
        let sum = sum_mass_velocity_squared(state, &self.program.masses, GROUP_ALL);
        self.temperature = temperature(sum, degrees_of_freedom(state.len()), &self.program.units);
        let all = exact::sample(state);
        self.ids = if all.len() <= sample { all } else { exact::sample_of(state, sample) };
        self.exact = Default::default();
    }

    /// Runs a scene on whose forces vanish by symmetry: they would be nothing but rounding, and so would be all that is measured by them.
    fn leave_lattice(&mut self, sample: usize) -> Result<(), Halt> {
        let Swing { by_force, by_curvature, .. } = self.look_for_stillness()?;
        if !self.still {
            return Ok(());
        }
        let part = (by_force / by_curvature).sqrt();
        let fault = if self.temperature > 0.0 {
            let (dt, fastest) = (self.program.timestep, by_curvature.sqrt().recip());
            let steps = ((RUN_ON * fastest / dt).ceil() as u64).clamp(20, MOST_RUN_ON);
            match self.run_on(steps) {
                Ok(()) => {
                    self.look(sample);
                    self.look_for_stillness()?;
                    self.prepared = Some(format!(
                        "The script leaves a lattice: net forces are zero by symmetry (RMS {part:.0e} of what they are in equilibrium at its \
                         temperature). It was run on for {steps} steps, and what that leaves is studied."
                    ));
                    String::new()
                }
                Err(Halt::Error(Error::Fault(fault))) => format!(" Run on, it breaks: {fault}."),
                Err(halt) => return Err(halt),
            }
        } else {
            " Nothing moves, as the temperature is 0.".into()
        };
        if self.still {
            let words = "Net forces are zero by symmetry: force errors are relative to nothing and are left out; the fastest time is that \
                         of the curvature of the energy.";
            self.prepared = Some(format!("{}{words}{fault}", self.prepared.take().map_or(String::new(), |p| p + " ")));
        }
        self.notes.extend(self.prepared.clone());
        Ok(())
    }

    /// Whether net forces are those of a lattice: far too small for the temperature, or nothing but rounding.
    fn look_for_stillness(&mut self) -> Result<Swing, Halt> {
        let swing = self.swing()?;
        let rounded = swing.away < ROUNDED * self.program.pair.largest_cutoff();
        self.still = swing.by_curvature > 0.0 && (swing.by_force < STILL * swing.by_curvature || rounded);
        Ok(swing)
    }

    /// Runs steps with the script's own fixes.
    fn run_on(&mut self, steps: u64) -> Result<(), Halt> {
        let from = self.heated.as_ref().unwrap_or(&self.melted).clone();
        let mut driven = Driven::new(from, self.settings(Precision::Mixed))?;
        go(&mut driven, &format!("neigh_modify every 1 delay 0 check yes once no\nrun {steps}"))?;
        let mut after = driven.into_prepared();
        let scene = after.scene_mut();
        let (state, space, step) = (scene.state.clone(), scene.space.clone(), scene.step);
        self.space = space.clone().expect("a scene that runs has a box");
        for prepared in [Some(&mut self.melted), self.heated.as_mut()].into_iter().flatten() {
            let scene = prepared.scene_mut();
            (scene.state, scene.space, scene.step) = (state.clone(), space.clone(), step);
        }
        Ok(())
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

    fn swing(&self) -> Result<Swing, Halt> {
        /// Atoms whose curvature is worked out.
        const SAMPLE: usize = 2_000;
        let exact = self.exact(Potential::Own)?;
        let (state, units, program) = (self.melted.state(), &self.program.units, &self.program);
        let order = state.order_by_id();
        let mass = |id: &u32| {
            let place = order.binary_search_by_key(id, |k| state.id[*k]).expect("the sample is of this state");
            program.masses[state.kind[order[place]] as usize - 1]
        };
        let mean = |sum: f64, ids: &[u32]| sum * units.ftm2v / (3.0 * ids.len().max(1) as f64);
        let squares = |power: i32| {
            let each =
                exact.ids.iter().zip(exact.atoms).map(|(id, atom)| atom.force.norm_squared() / mass(id).powi(power));
            mean(each.sum(), exact.ids)
        };
        let by_force = squares(1) / (units.boltzmann * self.temperature);
        let ids = exact::sample_of(state, SAMPLE);
        let curved = exact::curvatures(&program.pair, state, &self.space, &ids);
        let by_curvature = mean(ids.iter().zip(curved).map(|(id, curved)| curved / mass(id)).sum(), &ids);
        // 0 over 0 is nothing.
        let known = |x: f64| if x.is_nan() { 0.0 } else { x.max(0.0) };
        let (by_force, by_curvature) = (known(by_force), known(by_curvature));
        let away = (3.0 * squares(2) * units.ftm2v).sqrt() / by_curvature;
        Ok(Swing { by_force, by_curvature, away })
    }

    /// The fastest time, 1 / w of the Einstein frequency w, and the time over which trajectories are compared: some of these, but no more
    /// than an atom takes to cross the largest cutoff, nor than [`MOST_STEPS`].
    pub fn pace(&self) -> Result<Pace, Halt> {
        let Swing { by_force, by_curvature, .. } = self.swing()?;
        let state = self.melted.state();
        let (squared, how) = if by_force.is_finite() && by_force > by_curvature {
            (by_force, "1 / w, w^2 = <F^2 / m> / (3 k T)")
        } else {
            (by_curvature, "1 / w, w^2 = <laplacian of U / m> / 3")
        };
        let speed = (state.v.iter().map(|v| v.norm_squared()).sum::<f64>() / state.len().max(1) as f64).sqrt();
        let bounds = [
            (FASTEST_TIMES / squared.sqrt(), how),
            (
                self.program.pair.largest_cutoff() / speed,
                "a seventh of the time in which an atom flies as far as the cutoff",
            ),
            (MOST_STEPS * self.program.timestep, "a seventh of 1000 steps, as forces are weak"),
        ];
        let usable = bounds.into_iter().filter(|(span, _)| span.is_finite() && *span > 0.0);
        let (span, how) = usable.min_by(|a, b| a.0.total_cmp(&b.0)).expect("steps have a length");
        if squared == 0.0 && speed == 0.0 {
            return Ok(Pace { span: 80.0 * self.program.timestep, fastest: None, how: "" });
        }
        Ok(Pace { span, fastest: Some(span / FASTEST_TIMES), how })
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
