//! The scene while a script is read: every command changes it or is refused.

use super::{CreateContext, Groups, Lattice, Regions, VelocityContext};
use crate::dynamics::{Fix, FixArguments, FixScene, MOST_PARAMETERS_OF_ALL, parse_fix};
use crate::engine::{Program, StorageSort};
use crate::neighbor::estimate::estimate;
use crate::neighbor::{Policy, SearchPlan};
use crate::pair::PairCoefficients;
use crate::script::command::{create_atoms, create_box, group, lattice, mass, region, velocity};
use crate::script::{Args, Complaint, Name};
use crate::system::{Clock, LostAtoms, Side, SimulationBox, State, Units, Vec3, memory};

/// Lines for the log.
pub type Messages = Vec<String>;

/// Everything a script has said so far, and the particles.
#[derive(Clone, Debug)]
pub struct SceneBuilder {
    pub units: &'static Units,
    pub sides: [[Side; 2]; 3],
    pub lattice: Option<Lattice>,
    pub regions: Regions,
    pub groups: Groups,
    pub space: Option<SimulationBox>,
    /// By type from 0.
    pub masses: Vec<Option<f64>>,
    pub state: State,
    pub pair: Option<PairCoefficients>,
    pub policy: Policy,
    pub fixes: Vec<Fix>,
    /// Time units.
    pub timestep: f64,
    pub step: i64,
    /// `timestep` and `reset_timestep` set it anew.
    pub clock: Clock,
    pub lost: LostAtoms,
    pub storage_sort: Option<StorageSort>,
}

impl Default for SceneBuilder {
    fn default() -> Self {
        let units = &crate::system::units::UNITS[0];
        Self {
            units,
            sides: [[Side::Periodic; 2]; 3],
            lattice: None,
            regions: Regions::default(),
            groups: Groups::default(),
            space: None,
            masses: Vec::new(),
            state: State::default(),
            pair: None,
            policy: Policy::new(units.skin),
            fixes: Vec::new(),
            timestep: units.timestep,
            step: 0,
            clock: Clock::default(),
            lost: LostAtoms::default(),
            storage_sort: Some(StorageSort { every: 1000, bin: 0.0 }),
        }
    }
}

impl SceneBuilder {
    /// The box, or a complaint that the command comes too early.
    pub fn space(&self) -> Result<&SimulationBox, Complaint> {
        self.space.as_ref().ok_or_else(|| {
            Complaint::new(0, "there is no simulation box yet").with_help("create_box or read_data makes one")
        })
    }

    /// Refuses commands that must come before the box.
    pub fn before_box(&self) -> Result<(), Complaint> {
        match self.space {
            None => Ok(()),
            Some(_) => Err(Complaint::new(0, "must come before the simulation box is created")),
        }
    }

    /// `units`.
    pub fn set_units(&mut self, units: &'static Units) -> Result<(), Complaint> {
        self.before_box()?;
        self.units = units;
        self.timestep = units.timestep;
        self.policy.skin = units.skin;
        Ok(())
    }

    /// `lattice`.
    pub fn lattice(&mut self, command: &lattice::LatticeCommand) -> Result<Messages, Complaint> {
        let lattice = Lattice::new(command, self.units)?;
        let s = lattice.spacing();
        let line = format!("Lattice spacing in x,y,z = {} {} {}", g8(s.x), g8(s.y), g8(s.z));
        self.lattice = Some(lattice);
        Ok(vec![line])
    }

    /// `region`.
    pub fn region(&mut self, command: &region::RegionCommand) -> Result<Messages, Complaint> {
        self.regions.apply(command, self.lattice.as_ref(), self.space.as_ref())?;
        Ok(Messages::new())
    }

    /// `create_box`.
    pub fn create_box(&mut self, command: &create_box::CreateBoxCommand) -> Result<Messages, Complaint> {
        if self.space.is_some() {
            return Err(Complaint::new(0, "there is a simulation box already"));
        }
        let region = self.regions.find(&command.region)?;
        let (space, types) = super::create_box(command, region, self.sides)?;
        // As the region has it: shrink-wrapped sides keep their distance from it.
        let line = region.bounds().map(|[lo, hi]| format!("Created {}", describe_bounds(&lo, &hi)));
        self.set_box(space, types);
        Ok(line.into_iter().collect())
    }

    /// Puts the box in place, for `types` atom types.
    pub fn set_box(&mut self, space: SimulationBox, types: usize) {
        self.space = Some(space);
        self.masses = vec![None; types];
        if let Some(pair) = &mut self.pair {
            pair.set_types(types);
        }
    }

    /// `create_atoms`.
    pub fn create_atoms(&mut self, command: &create_atoms::CreateAtomsCommand) -> Result<Messages, Complaint> {
        let space = self.space()?.clone();
        let context = CreateContext {
            lattice: self.lattice.as_ref(),
            regions: &self.regions,
            simulation_box: &space,
            types: self.masses.len(),
        };
        let created = super::create_atoms(command, &context, &mut self.state)?;
        let short = match &command.style {
            create_atoms::CreateAtomsStyle::Random { count, .. } if created < *count => {
                Some(format!("WARNING: only {created} of {count} random atoms found a place in the region"))
            }
            _ => None,
        };
        let units = if command.lattice_units { "lattice" } else { "box" };
        let lines = [format!("Created {created} atoms"), format!("  using {units} units in {}", describe_box(&space))];
        Ok(lines.into_iter().chain(short).collect())
    }

    /// `mass`.
    pub fn mass(&mut self, command: &mass::MassCommand) -> Result<Messages, Complaint> {
        self.space()?;
        super::mass::set_mass(command, &mut self.masses)?;
        Ok(Messages::new())
    }

    /// `group`.
    pub fn group(&mut self, command: &group::GroupCommand) -> Result<Messages, Complaint> {
        self.space()?;
        if command.action == group::GroupAction::Delete
            && let Some(fix) = self.fixes.iter().find(|f| Some(f.group) == self.groups.get(&command.name.text))
        {
            return Err(Complaint::new(1, format!("fix {} still uses the group", fix.id)));
        }
        let count = self.groups.apply(command, &mut self.state, &self.regions)?;
        Ok(vec![format!("{count} atoms in group {}", command.name.text)])
    }

    /// `velocity`.
    pub fn velocity(&mut self, command: &velocity::VelocityCommand) -> Result<Messages, Complaint> {
        let mut state = std::mem::take(&mut self.state);
        let changed = self.space().and_then(|space| {
            let context = VelocityContext {
                groups: &self.groups,
                masses: &self.masses,
                lattice: self.lattice.as_ref(),
                simulation_box: space,
                units: self.units,
            };
            super::velocity(command, &context, &mut state)
        });
        self.state = state;
        changed?;
        Ok(Messages::new())
    }

    /// `fix ID GROUP STYLE ...`; `args` stands behind the style.
    pub fn fix(&mut self, id: &Name, group: &Name, style: &Name, args: &mut Args<'_>) -> Result<Messages, Complaint> {
        let space = self.space()?;
        let group = self.groups.find(group)?;
        let lattice_unit = self.lattice.as_ref().map_or(Vec3::repeat(1.0), Lattice::spacing);
        let scene = FixScene { simulation_box: space, lattice_unit, units: self.units };
        let Some(parsed) = parse_fix(&style.text, args, &scene) else {
            let names: Vec<_> = crate::dynamics::fixes().iter().map(|f| f.0).collect();
            let message = format!("fix style '{}' is not part of octant; available: {}", style.text, names.join(", "));
            return Err(Complaint::new(style.word, message));
        };
        let (style_name, FixArguments { choice, parameters }) = parsed?;
        let others = self.fixes.iter().filter(|f| f.id != id.text).map(|f| f.parameters.len()).sum::<usize>();
        if others + parameters.len() > MOST_PARAMETERS_OF_ALL {
            let message = format!("all fixes together have more than {MOST_PARAMETERS_OF_ALL} numbers");
            return Err(Complaint::new(style.word, message));
        }
        let fix = Fix { id: id.text.clone(), style: style_name, group, choice, parameters, memory: Vec::new() };
        match self.fixes.iter_mut().find(|f| f.id == fix.id) {
            Some(old) if old.style != style_name => {
                return Err(Complaint::new(id.word, format!("fix ID '{}' is in use by another style", fix.id)));
            }
            Some(old) => *old = fix,
            None => self.fixes.push(fix),
        }
        Ok(Messages::new())
    }

    /// `unfix ID`.
    pub fn unfix(&mut self, id: &Name) -> Result<Messages, Complaint> {
        let Some(place) = self.fixes.iter().position(|f| f.id == id.text) else {
            let known: Vec<_> = self.fixes.iter().map(|f| f.id.as_str()).collect();
            let known =
                if known.is_empty() { "there is none".into() } else { format!("defined: {}", known.join(", ")) };
            return Err(Complaint::new(id.word, format!("expected a fix ID, got '{}' ({known})", id.text)));
        };
        self.fixes.remove(place);
        Ok(Messages::new())
    }

    /// `timestep`: time so far stays what it was.
    pub fn set_timestep(&mut self, timestep: f64) {
        self.clock = Clock { time: self.time(), step: self.step };
        self.timestep = timestep;
    }

    /// `reset_timestep`: unless a time is given, time goes on as if steps had been made, or, at a step back, begins at 0.
    pub fn reset_step(&mut self, step: i64, time: Option<f64>) {
        match time {
            Some(time) => self.clock = Clock { time, step },
            None if step < self.step => self.clock = Clock { time: 0.0, step },
            None => {}
        }
        self.step = step;
    }

    /// Simulated time, time units.
    pub fn time(&self) -> f64 {
        self.clock.at(self.step, self.timestep)
    }

    /// Freezes what a run needs; also the numbers of mixed and mixable pairs. The complaint names what is missing.
    pub fn program(&self, search: SearchPlan) -> Result<(Program, usize, usize), Complaint> {
        self.space()?;
        let Some(pair) = &self.pair else {
            return Err(Complaint::new(0, "there is no pair_style"));
        };
        if self.state.is_empty() {
            return Err(Complaint::new(0, "there are no atoms").with_help("create_atoms or read_data makes them"));
        }
        let Policy { every, delay, .. } = self.policy;
        if !delay.is_multiple_of(every.max(1)) {
            let message =
                format!("neigh_modify: delay must be 0 or a multiple of every, got delay {delay} and every {every}");
            return Err(Complaint::new(0, message));
        }
        let masses = super::mass::all_masses(&self.masses).map_err(|m| Complaint::new(0, m))?;
        let (table, mixed, mixable) = pair.complete().map_err(|m| Complaint::new(0, m))?;
        if table.largest_cutoff() <= 0.0 {
            return Err(Complaint::new(0, "all pair cutoffs are 0"));
        }
        let space = self.space()?;
        list_fits(&self.state, space, table.largest_cutoff() + self.policy.skin)?;
        let program = Program {
            units: *self.units,
            pair: table,
            masses,
            fixes: self.fixes.clone(),
            timestep: self.timestep,
            policy: self.policy,
            range: (self.step, self.step),
            search,
            lost: self.lost,
            storage_sort: self.storage_sort,
        };
        Ok((program, mixed, mixable))
    }
}

/// Refuses a cutoff for which the neighbor list would not fit in memory.
pub fn list_fits(state: &State, space: &SimulationBox, radius: f64) -> Result<(), Complaint> {
    let list = estimate(state, space, radius, crate::engine::cpu::LIST_BYTES);
    // Rows have room to grow.
    if 2.0 * list.bytes <= memory::available() as f64 {
        return Ok(());
    }
    let (pairs, bytes) = (list.entries / 2.0, list.bytes);
    let message = format!(
        "about {pairs:.0e} pairs lie within cutoff and skin; their list ({bytes:.0e} bytes) does not fit in memory"
    );
    Err(Complaint::new(0, message))
}

/// `%.8g`, LAMMPS's way of printing lengths in the log.
pub fn g8(x: f64) -> String {
    crate::output::printf::format_g(x, 0, 8, false)
}

/// "orthogonal box = (0 0 0) to (1 1 1)".
pub fn describe_box(space: &SimulationBox) -> String {
    describe_bounds(&space.lo, &space.hi)
}

fn describe_bounds(lo: &Vec3, hi: &Vec3) -> String {
    let point = |p: &Vec3| format!("({} {} {})", g8(p.x), g8(p.y), g8(p.z));
    format!("orthogonal box = {} to {}", point(lo), point(hi))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reset_step_keeps_or_restarts_time() {
        let mut scene = SceneBuilder { step: 10, ..SceneBuilder::default() };
        let mut reset = |step, time: Option<f64>| {
            scene.reset_step(step, time);
            scene.time()
        };
        // Times that LAMMPS 22Jul2025 prints, timestep 0.005.
        assert_eq!(reset(10, None), 0.05);
        assert_eq!(reset(0, None), 0.0);
        assert_eq!(reset(50, None), 0.25);
        assert_eq!(reset(7, Some(1.5)), 1.5);
        assert_eq!(reset(3, None), 0.0);
    }
}
