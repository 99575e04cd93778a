//! Data files: `read_data`, `write_data`, and the last good state of a run that went wrong.

use std::path::Path;

use super::ScriptState;
use crate::Error;
use crate::engine::{GoodState, Program};
use crate::neighbor::SearchPlan;
use crate::pair::PairTable;
use crate::scene::builder::{Messages, describe_box};
use crate::scene::data_file::{CoefficientLines, CoefficientSection, DataFile, WriteData, read_data, write_data};
use crate::script::command::write_data::PairSection;
use crate::script::command::{ReadDataCommand, WriteDataCommand};
use crate::script::{Complaint, InputError, Source, Statement};
use crate::system::{LostAtoms, SimulationBox, State};

/// Carries out `read_data`; what it prints.
pub fn read(script: &mut ScriptState, statement: &Statement, command: &ReadDataCommand) -> Result<Messages, Error> {
    script.last_run = None;
    script.continues = false;
    let complain = |word: usize, message: String| statement.complain(Complaint::new(word, message));
    if script.scene.space.is_some() {
        return Err(complain(0, "there is a simulation box already".into()).into());
    }
    let path = &command.path;
    let bytes =
        std::fs::read(&path.text).map_err(|e| complain(path.word, format!("cannot read '{}': {e}", path.text)))?;
    let source = Source::from_bytes(path.text.clone(), &bytes);
    let file = read_data(&source, script.scene.sides)?;
    let lines = vec![
        "Reading data file ...".into(),
        format!("  {}", describe_box(&file.simulation_box)),
        format!("  {} atoms", file.state.len()),
    ];
    let scene = &mut script.scene;
    scene.set_box(file.simulation_box.clone(), file.types + command.extra_types);
    scene.masses[..file.types].copy_from_slice(&file.masses);
    if !command.no_coefficients {
        coefficients(script, statement, &file)?;
    }
    let scene = &mut script.scene;
    scene.state = file.state;
    if let Some(group) = &command.group {
        let bit = scene.groups.find_or_add(group).map_err(|c| statement.complain(c))?;
        scene.state.mask.iter_mut().for_each(|mask| *mask |= bit);
    }
    Ok(lines)
}

/// Hands the file's coefficients to the pair style.
fn coefficients(script: &mut ScriptState, statement: &Statement, file: &DataFile) -> Result<(), Error> {
    let sections = [(&file.pair_coefficients, 1), (&file.pair_ij_coefficients, 2)];
    for (section, types) in sections {
        let Some(section) = section else { continue };
        let Some(pair) = &mut script.scene.pair else {
            let message = "pair_style must come before read_data: the file has pair coefficients";
            return Err(statement
                .complain(Complaint::new(0, message).with_help("or say read_data ... nocoeff"))
                .into());
        };
        if let Some(style) = &section.style
            && style.text != pair.style().name
        {
            let message = format!(
                "{}: expected coefficients for {}, got '{}'",
                section.title.text,
                pair.style().name,
                style.text
            );
            return Err(InputError::new(&file.source, style.span, message).into());
        }
        for line in &section.lines {
            set(pair, section, line, types).map_err(|(word, message)| {
                InputError::new(&file.source, line[word.min(line.len() - 1)].span, message)
            })?;
        }
    }
    Ok(())
}

fn set(
    pair: &mut crate::pair::PairCoefficients,
    section: &CoefficientSection,
    line: &[crate::script::Word],
    types: usize,
) -> Result<(), (usize, String)> {
    let title = &section.title.text;
    let kind = |k: usize| line[k].text.parse::<usize>().map_err(|_| (k, format!("{title}: expected an atom type")));
    let (i, j) = (kind(0)?, kind(types - 1)?);
    let words: Vec<&str> = line[types..].iter().map(|w| w.text.as_str()).collect();
    pair.set((i, i), (j, j), &words).map_err(|(at, message)| (types + at, format!("{title}: {message}")))
}

/// Is everything there that `write_data` needs?
pub fn judge_write(script: &ScriptState) -> Result<(), Complaint> {
    script.scene.space().map(|_| ())
}

/// Carries out `write_data`; without `files` all but the writing.
pub fn write(
    script: &mut ScriptState,
    statement: &Statement,
    command: &WriteDataCommand,
    files: bool,
) -> Result<(), Error> {
    script.scene.space().map_err(|c| statement.complain(c))?;
    settle(script).map_err(|c| statement.complain(c))?;
    if !files {
        return Ok(());
    }
    let space = script.scene.space().map_err(|c| statement.complain(c))?;
    let pair = script.scene.pair.as_ref().and_then(|pair| {
        let (full, lines) = match command.pair {
            PairSection::Absent => return None,
            PairSection::Diagonal => (false, pair.like_type_lines()),
            PairSection::Full => (true, script.scene.program(SearchPlan::default()).ok()?.0.pair.pair_lines()),
        };
        (!lines.is_empty()).then(|| CoefficientLines { style: pair.style().name.into(), full, lines })
    });
    let path = command.path_at(script.scene.step);
    let state = (&script.scene.state, space, script.scene.step);
    write_state(Path::new(&path), script, state, pair.as_ref()).map_err(|e| {
        let message = format!("cannot write '{path}': {e}");
        statement.complain(Complaint::new(command.path.word, message)).into()
    })
}

/// LAMMPS sets the system up before it writes: atoms are wrapped, sides shrink, lost atoms go, counts of builds are forgotten.
fn settle(script: &mut ScriptState) -> Result<(), Complaint> {
    let scene = &mut script.scene;
    let Some(mut space) = scene.space.clone() else { return Ok(()) };
    let mut state = scene.state.clone();
    let gone = state.settle(&mut space);
    if gone > 0 && scene.lost == LostAtoms::Error {
        let message = format!("{gone} atoms are lost: they are beyond a fixed side of the box");
        return Err(Complaint::new(0, message).with_help("thermo_modify lost ignore leaves them out"));
    }
    (scene.state, scene.space) = (state, Some(space));
    if let Some(last) = &mut script.last_run {
        (last.neighbors.builds, last.neighbors.dangerous) = (0, Some(0));
    }
    script.continues = false;
    Ok(())
}

/// Writes the state from before a fault, with all coefficients.
pub fn write_good_state(path: &Path, script: &ScriptState, good: &GoodState, program: &Program) -> std::io::Result<()> {
    let table: &PairTable = &program.pair;
    let pair = CoefficientLines { style: table.style.into(), full: true, lines: table.pair_lines() };
    write_state(path, script, (&good.state, &good.simulation_box, good.step), Some(&pair))
}

fn write_state(
    path: &Path,
    script: &ScriptState,
    (state, simulation_box, step): (&State, &SimulationBox, i64),
    pair: Option<&CoefficientLines>,
) -> std::io::Result<()> {
    let data =
        WriteData { step, units: script.scene.units.name, state, simulation_box, masses: &script.scene.masses, pair };
    write_data(path, &data)
}
