//! What each command says, as typed data: one parser per command, no meaning yet.

pub mod create_atoms;
pub mod create_box;
pub mod dump;
pub mod dump_modify;
pub mod fix;
pub mod group;
pub mod lammps_names;
pub mod lattice;
pub mod mass;
pub mod neighbor;
pub mod number_format;
pub mod output_control;
pub mod pair;
pub mod read_data;
pub mod region;
pub mod run;
pub mod setup;
pub mod thermo;
pub mod timestep;
pub mod velocity;
pub mod write_data;

use super::statement::{Args, Complaint, Name, Statement};
use crate::script::suggest;

pub use create_atoms::CreateAtomsCommand;
pub use create_box::CreateBoxCommand;
pub use dump::{DumpCommand, DumpModifyCommand, UndumpCommand};
pub use fix::{FixCommand, UnfixCommand};
pub use group::GroupCommand;
pub use lattice::LatticeCommand;
pub use mass::MassCommand;
pub use neighbor::{NeighModifyCommand, NeighborCommand};
pub use output_control::{EchoCommand, LogCommand, PrintCommand};
pub use pair::{PairCoeffCommand, PairModifyCommand, PairStyleCommand, PairWriteCommand};
pub use read_data::ReadDataCommand;
pub use region::RegionCommand;
pub use run::RunCommand;
pub use setup::{AtomModifyCommand, AtomStyleCommand, BoundaryCommand, DimensionCommand, NewtonCommand, UnitsCommand};
pub use thermo::{ThermoCommand, ThermoModifyCommand, ThermoStyleCommand};
pub use timestep::{ResetTimestepCommand, TimestepCommand};
pub use velocity::VelocityCommand;
pub use write_data::WriteDataCommand;

/// Declares [`Command`] and its dispatch: one line a command.
macro_rules! commands {
    ($($name:literal => $variant:ident($type:ty),)*) => {
        /// A parsed command.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Command {
            $($variant($type),)*
        }

        /// Names of all commands handed to the simulation.
        pub const COMMANDS: &[&str] = &[$($name),*];

        impl Command {
            /// Parses a statement to its last word.
            pub fn parse(statement: &Statement) -> Result<Self, Complaint> {
                let mut args = statement.args();
                let command = match statement.name() {
                    $($name => Self::$variant(<$type>::parse(&mut args)?),)*
                    name => return Err(unknown(name)),
                };
                args.done()?;
                Ok(command)
            }
        }
    };
}

commands! {
    "units" => Units(UnitsCommand),
    "atom_style" => AtomStyle(AtomStyleCommand),
    "atom_modify" => AtomModify(AtomModifyCommand),
    "dimension" => Dimension(DimensionCommand),
    "boundary" => Boundary(BoundaryCommand),
    "newton" => Newton(NewtonCommand),
    "lattice" => Lattice(LatticeCommand),
    "region" => Region(RegionCommand),
    "create_box" => CreateBox(CreateBoxCommand),
    "create_atoms" => CreateAtoms(CreateAtomsCommand),
    "read_data" => ReadData(ReadDataCommand),
    "write_data" => WriteData(WriteDataCommand),
    "mass" => Mass(MassCommand),
    "group" => Group(GroupCommand),
    "velocity" => Velocity(VelocityCommand),
    "neighbor" => Neighbor(NeighborCommand),
    "neigh_modify" => NeighModify(NeighModifyCommand),
    "fix" => Fix(FixCommand),
    "unfix" => Unfix(UnfixCommand),
    "pair_style" => PairStyle(PairStyleCommand),
    "pair_coeff" => PairCoeff(PairCoeffCommand),
    "pair_modify" => PairModify(PairModifyCommand),
    "pair_write" => PairWrite(PairWriteCommand),
    "timestep" => Timestep(TimestepCommand),
    "reset_timestep" => ResetTimestep(ResetTimestepCommand),
    "thermo" => Thermo(ThermoCommand),
    "thermo_style" => ThermoStyle(ThermoStyleCommand),
    "thermo_modify" => ThermoModify(ThermoModifyCommand),
    "dump" => Dump(DumpCommand),
    "dump_modify" => DumpModify(DumpModifyCommand),
    "undump" => Undump(UndumpCommand),
    "log" => Log(LogCommand),
    "print" => Print(PrintCommand),
    "echo" => Echo(EchoCommand),
    "run" => Run(RunCommand),
}

/// Commands that the interpreter carries out itself.
const CONTROL: [&str; 5] = ["variable", "next", "label", "jump", "if"];

fn unknown(name: &str) -> Complaint {
    if lammps_names::LAMMPS_COMMANDS.contains(&name) {
        return Complaint::new(0, format!("{name} is a LAMMPS command that octant does not have"));
    }
    let complaint = Complaint::new(0, format!("unknown command '{name}'"));
    let known = COMMANDS.iter().chain(&CONTROL).chain(lammps_names::LAMMPS_COMMANDS);
    match suggest::closest(name, known.copied()) {
        Some(near) => complaint.with_help(format!("did you mean '{near}'?")),
        None => complaint,
    }
}

/// All words left, as names judged elsewhere.
fn rest(args: &mut Args<'_>, what: &str) -> Result<Vec<Name>, Complaint> {
    let mut names = Vec::with_capacity(args.left());
    while args.left() > 0 {
        names.push(args.name(what)?);
    }
    Ok(names)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::script::{Interpreter, NoSimulation, Source};

    /// Parses the only command of a line; the error is its message with the help behind it.
    pub fn parse(line: &str) -> Result<Command, String> {
        let mut script = Interpreter::new(Source::new("in", line), &[]).unwrap();
        let statement = script.next(&mut NoSimulation).map_err(|e| e.to_string())?.unwrap();
        Command::parse(&statement)
            .map_err(|c| statement.complain(c))
            .map_err(|e| format!("{e}{}", e.help.as_deref().map(|h| format!("; {h}")).unwrap_or_default()))
    }

    #[test]
    fn unknown_commands_are_told_apart() {
        assert_eq!(
            parse("minimise 1").unwrap_err(),
            "in:1:1: minimise: unknown command 'minimise'; did you mean 'minimize'?"
        );
        assert_eq!(
            parse("minimize 1 2 3 4").unwrap_err(),
            "in:1:1: minimize: minimize is a LAMMPS command that octant does not have"
        );
        assert_eq!(parse("xyzzy").unwrap_err(), "in:1:1: xyzzy: unknown command 'xyzzy'");
        assert_eq!(
            parse("pair_coef 1 1").unwrap_err(),
            "in:1:1: pair_coef: unknown command 'pair_coef'; did you mean 'pair_coeff'?"
        );
    }

    #[test]
    fn no_command_takes_more_words_than_it_reads() {
        assert_eq!(parse("units lj metal").unwrap_err(), "in:1:10: units: expected the end of the line, got 'metal'");
        assert_eq!(
            parse("timestep").unwrap_err(),
            "in:1:1: timestep: expected the length of a timestep, got the end of the line"
        );
    }
}
