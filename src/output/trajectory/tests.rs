//! Files read back by chemfiles itself.

use chemfiles::Trajectory;

use super::writer::TrajectoryWriter;
use super::{SINGLE_FRAME, trajectory_formats};
use crate::output::SceneFacts;
use crate::output::dump::tests::{dump, sample, show, show_with};
use crate::script::command::dump::DumpCommand;
use crate::script::testing::statement;
use crate::system::Units;

/// A frame as read back.
struct Read {
    step: usize,
    positions: Vec<[f64; 3]>,
    edges: [f64; 3],
    names: Vec<String>,
}

/// Steps 40 and 60 of the sample, read back.
fn frames(name: &str, lines: &[&str]) -> Vec<Read> {
    let (mut dump, path) = dump(name, lines);
    for step in [40, 60] {
        let (mut state, _) = sample();
        // Wide numbers do not fit into the columns of GRO files.
        state.v[1].x = -0.75;
        show_with(&mut *dump, step, state).unwrap();
    }
    dump.close().unwrap();
    let report = dump.report();
    assert_eq!(report.frames, 2);
    assert!(report.bytes > 0, "{report:?}");
    let format = report.format.as_str();
    let mut trajectory = Trajectory::open_with_format(&path, 'r', format).unwrap();
    let mut frames = Vec::new();
    for _ in 0..trajectory.nsteps() {
        let mut frame = chemfiles::Frame::new();
        trajectory.read(&mut frame).unwrap();
        let names = frame.iter_atoms().map(|atom| atom.name()).collect();
        let (positions, edges) = (frame.positions().to_vec(), frame.cell().lengths());
        frames.push(Read { step: frame.step(), positions, edges, names });
    }
    std::fs::remove_file(path).unwrap();
    frames
}

const BY_ID: [[f64; 3]; 3] = [[0.5, -0.25, 1.125], [3.75, 2.5, 6.0625], [1.0625, 0.125, 2.0]];

fn assert_near(found: &[[f64; 3]], expected: &[[f64; 3]], tolerance: f64, name: &str) {
    assert_eq!(found.len(), expected.len(), "{name}");
    for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((a - b).abs() <= tolerance, "{name}: {found:?}");
    }
}

/// Two frames in every format on offer, atoms in order of id.
#[test]
fn every_format_takes_a_trajectory() {
    // chemfiles writes several mmCIF models but does not read the second.
    for format in trajectory_formats().into_iter().filter(|format| format.name != "mmCIF") {
        let name = format.name.replace(' ', "_");
        let command = format!("dump a all chemfiles 20 FILE format '{}'", format.name);
        let frames = frames(&name, &[&command, "dump_modify a element Al C unwrap no"]);
        assert_eq!(frames.len(), 2, "{name}");
        // CIF files hold fractions of the cell, wrapped.
        let edges = [5.0, 5.0, 6.0632];
        let nearest = |(k, (a, b)): (usize, (&f64, &f64))| a - edges[k % 3] * ((a - b) / edges[k % 3]).round();
        let found = frames[1].positions.iter().flatten().zip(BY_ID.iter().flatten()).enumerate().map(nearest);
        let found: Vec<f64> = found.collect();
        let found: Vec<[f64; 3]> = found.chunks(3).map(|x| [x[0], x[1], x[2]]).collect();
        assert_near(&found, &BY_ID, 6e-3, &name);
    }
}

#[test]
fn steps_cells_and_names_where_the_format_has_them() {
    let xtc = frames("t.xtc", &["dump a all xtc 20 FILE", "dump_modify a precision 100000"]);
    assert_eq!([xtc[0].step, xtc[1].step], [40, 60]);
    assert_near(&xtc[0].positions, &BY_ID, 1e-6, "xtc");
    assert_near(&[xtc[0].edges], &[[5.0, 5.0, 6.0632]], 1e-6, "xtc cell");
    let xyz = frames("t.xyz.gz", &["dump a g chemfiles 20 FILE", "dump_modify a element Al C"]);
    assert_eq!(xyz[0].names, ["C", "C"]);
    let group = [BY_ID[0], BY_ID[2]];
    assert_near(&xyz[1].positions, &group, 1e-6, "xyz");
    let unwrapped = frames("u.dcd", &["dump a g dcd 20 FILE", "dump_modify a unwrap yes"]);
    assert_near(&unwrapped[1].positions, &[[10.5, -0.25, 1.125], [-3.9375, 0.125, 2.0]], 1e-6, "dcd");
    let netcdf = frames("t.nc", &["dump a all netcdf 20 FILE id xu yu zu vx vy vz"]);
    assert_near(&netcdf[0].positions[..1], &[[10.5, -0.25, 1.125]], 1e-6, "netcdf");
}

/// The header words that LAMMPS fills: first step, interval, last step, timestep.
#[test]
fn a_dcd_file_knows_its_steps() {
    let (mut dump, path) = dump("steps.dcd", &["dump a all dcd 20 FILE"]);
    show(&mut *dump, 40).unwrap();
    dump.close().unwrap();
    show(&mut *dump, 60).unwrap();
    drop(dump);
    let bytes = std::fs::read(&path).unwrap();
    let word = |at: usize| i32::from_ne_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!([word(8), word(12), word(16), word(20)], [2, 40, 20, 60]);
    assert_eq!(f32::from_ne_bytes(bytes[44..48].try_into().unwrap()), 0.5);
    std::fs::remove_file(path).unwrap();
}

#[test]
fn what_cannot_be_written_is_refused() {
    let facts = SceneFacts::new(Units::named("lj").unwrap(), vec![1.0]);
    for (line, word) in [
        ("dump a all chemfiles 1 f.docx", 5),
        ("dump a all chemfiles 1 f.xtc.gz", 5),
        ("dump a all chemfiles 1 f.tpr", 5),
        ("dump a all chemfiles 1 f.xyz format nonsense", 7),
        ("dump a all netcdf 1 f.nc x y z fx", 9),
        ("dump a all netcdf 1 f.nc x y", 6),
        ("dump a all netcdf 1 f.nc x y z vx", 6),
    ] {
        let command = DumpCommand::parse(&mut statement(line).args()).unwrap();
        let error = TrajectoryWriter::new(&command, &facts).err().unwrap();
        assert_eq!(error.word, word, "{line}: {error:?}");
    }
    for name in SINGLE_FRAME {
        assert!(trajectory_formats().iter().all(|format| format.name != *name));
    }
}
