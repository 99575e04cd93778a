//! Scenes for tests, made from script lines.

use super::mass::set_mass;
use super::{CreateContext, Groups, Lattice, Regions, VelocityContext};
use crate::script::Complaint;
use crate::script::command as parse;
use crate::script::testing::statement;
use crate::system::{Side, SimulationBox, State, Units};

/// Two types on an fcc lattice of 32 atoms, with a group of every other atom.
pub const TWO_TYPES: &str = "lattice fcc 0.8442
    region b block 0 2 0 2 0 2
    create_box 2 b
    create_atoms 1 box basis 3 2
    mass 1 1.5
    mass 2 0.5
    group odd id 1:32:2";

/// What the scene-making commands have made.
pub struct Scene {
    pub units: &'static Units,
    pub sides: [[Side; 2]; 3],
    pub lattice: Option<Lattice>,
    pub regions: Regions,
    pub simulation_box: Option<SimulationBox>,
    pub masses: Vec<Option<f64>>,
    pub groups: Groups,
    pub state: State,
}

impl Scene {
    /// Runs script lines in a periodic box of lj units.
    pub fn new(script: &str) -> Self {
        let mut scene = Self {
            units: Units::named("lj").unwrap(),
            sides: [[Side::Periodic; 2]; 3],
            lattice: None,
            regions: Regions::default(),
            simulation_box: None,
            masses: Vec::new(),
            groups: Groups::default(),
            state: State::default(),
        };
        for line in script.lines().filter(|line| !line.trim().is_empty()) {
            scene.run(line).unwrap_or_else(|complaint| panic!("{line}: {}", complaint.message));
        }
        scene
    }

    /// Runs one line.
    pub fn run(&mut self, line: &str) -> Result<(), Complaint> {
        let statement = statement(line);
        let mut args = statement.args();
        match statement.name() {
            "lattice" => {
                let command = parse::lattice::LatticeCommand::parse(&mut args)?;
                self.lattice = Some(Lattice::new(&command, self.units)?);
            }
            "region" => {
                let command = parse::region::RegionCommand::parse(&mut args)?;
                self.regions.apply(&command, self.lattice.as_ref(), self.simulation_box.as_ref())?;
            }
            "create_box" => {
                let command = parse::create_box::CreateBoxCommand::parse(&mut args)?;
                let region = self.regions.find(&command.region)?;
                let (simulation_box, types) = super::create_box(&command, region, self.sides)?;
                (self.simulation_box, self.masses) = (Some(simulation_box), vec![None; types]);
            }
            "create_atoms" => {
                let command = parse::create_atoms::CreateAtomsCommand::parse(&mut args)?;
                let context = CreateContext {
                    lattice: self.lattice.as_ref(),
                    regions: &self.regions,
                    simulation_box: self.simulation_box.as_ref().expect("a box"),
                    types: self.masses.len(),
                };
                super::create_atoms(&command, &context, &mut self.state)?;
            }
            "mass" => set_mass(&parse::mass::MassCommand::parse(&mut args)?, &mut self.masses)?,
            "group" => {
                let command = parse::group::GroupCommand::parse(&mut args)?;
                self.groups.apply(&command, &mut self.state, &self.regions)?;
            }
            "velocity" => {
                let command = parse::velocity::VelocityCommand::parse(&mut args)?;
                let context = VelocityContext {
                    groups: &self.groups,
                    masses: &self.masses,
                    lattice: self.lattice.as_ref(),
                    simulation_box: self.simulation_box.as_ref().expect("a box"),
                    units: self.units,
                };
                super::velocity(&command, &context, &mut self.state)?;
            }
            other => panic!("no such test command: {other}"),
        }
        Ok(())
    }

    /// The complaint a line draws: the word it points at and its message.
    pub fn complaint(&mut self, line: &str) -> (usize, String) {
        let complaint = self.run(line).expect_err(line);
        (complaint.word, complaint.message)
    }

    /// Atoms in a group, which is made by `group ID args`.
    pub fn count(&mut self, id: &str) -> usize {
        let bit = self.groups.get(id).expect("the group");
        self.state.mask.iter().filter(|mask| **mask & bit != 0).count()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const COMMANDS: [&str; 7] = ["lattice", "region", "create_box", "create_atoms", "mass", "group", "velocity"];
    const WORDS: [&str; 60] = [
        "all",
        "b",
        "r",
        "box",
        "1",
        "2",
        "3",
        "0",
        "-1",
        "0.5",
        "1e-9",
        "nan",
        "inf",
        "NULL",
        "INF",
        "EDGE",
        "*",
        "1*",
        "*2",
        "1:2",
        "3:1:0",
        "<",
        "<>",
        "fcc",
        "custom",
        "none",
        "orient",
        "origin",
        "spacing",
        "a1",
        "basis",
        "x",
        "y",
        "z",
        "block",
        "sphere",
        "cylinder",
        "union",
        "intersect",
        "delete",
        "side",
        "out",
        "units",
        "lattice",
        "single",
        "random",
        "region",
        "create",
        "set",
        "ramp",
        "scale",
        "zero",
        "linear",
        "angular",
        "vx",
        "loop",
        "geom",
        "type",
        "id",
        "subtract",
    ];

    proptest! {
        #[test]
        fn no_command_line_panics(
            command in prop::sample::select(&COMMANDS[..]),
            words in prop::collection::vec(prop::sample::select(&WORDS[..]), 0..12),
        ) {
            let mut scene = Scene::new("lattice sc 1\nregion b block 0 2 0 3 0 2\ncreate_box 2 b\ncreate_atoms 1 box\nmass * 1");
            let _ = scene.run(&format!("{command} {}", words.join(" ")));
        }
    }
}
