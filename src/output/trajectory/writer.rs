//! Writes snapshots through chemfiles.

use chemfiles::{Frame as ChemfilesFrame, Trajectory, UnitCell};

use super::{dcd, trajectory_formats, warnings};
use crate::Error;
use crate::engine::Needs;
use crate::output::dump::{Frame, SnapshotWriter, WrittenFile};
use crate::output::{Console, SceneFacts};
use crate::script::Complaint;
use crate::script::command::dump::{DumpChange, DumpColumn, DumpCommand, DumpStyle, SortBy};
use crate::system::Units;

/// chemfiles builds a cell from edges and angles; for longer edges the cosine of its right angles, which is not quite 0, makes
/// it refuse the cell.
const LONGEST_EDGE: f64 = 1.0e11;

/// Atoms in order of id. Positions are the engine's, not moved to the box's corner: a chemfiles cell has no origin, and
/// LAMMPS's own DCD and XTC files do the same.
pub(super) struct TrajectoryWriter {
    path: String,
    style: &'static str,
    /// Name of the chemfiles format, with its compression if any: `XTC`, `XYZ / GZ`.
    format: String,
    kind: Kind,
    velocities: bool,
    unwrap: bool,
    append: bool,
    elements: Option<Vec<String>>,
    /// What positions are multiplied by to be what chemfiles takes for angstrom.
    length: f64,
    /// Velocities to angstrom / ps.
    velocity: f64,
    /// Times to ps.
    time: f64,
    precision: Option<u32>,
    open: Option<Trajectory>,
    frame: Option<ChemfilesFrame>,
    /// Names and masses in `frame` belong to these ids and types.
    topology: Vec<(u32, u32)>,
    frames: u64,
    steps: Option<dcd::Steps>,
}

/// What each format wants treated in its own way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Dcd,
    Xtc,
    /// LAMMPS's text format as chemfiles writes it: unwrapped coordinates in the scene's own units.
    Lammps,
    /// Extended XYZ: the step fits into the comment.
    Xyz,
    Other,
}

/// XTC files hold nanometers; chemfiles divides its angstrom by this.
const ANGSTROM_A_NANOMETER: f64 = 10.0;
const FEMTOSECONDS_A_PICOSECOND: f64 = 1000.0;

impl TrajectoryWriter {
    pub fn new(command: &DumpCommand, facts: &SceneFacts) -> Result<Self, Complaint> {
        warnings::collect();
        let path = &command.file;
        if path.text.contains('\0') {
            return Err(Complaint::new(path.word, "expected a file name, got one with a zero byte"));
        }
        let (format, has_velocities) = match &command.style {
            DumpStyle::Dcd => ("DCD".to_string(), false),
            DumpStyle::Xtc => ("XTC".to_string(), false),
            DumpStyle::Netcdf(columns) => ("Amber NetCDF".to_string(), netcdf_velocities(columns, command)?),
            DumpStyle::Chemfiles { format: Some(name) } => named_format(&name.text, name.word)?,
            _ => guessed_format(&path.text, path.word)?,
        };
        let kind = match format.split(" / ").next().unwrap_or_default() {
            "DCD" => Kind::Dcd,
            "XTC" => Kind::Xtc,
            "LAMMPS" => Kind::Lammps,
            "XYZ" => Kind::Xyz,
            _ => Kind::Other,
        };
        let lammps = matches!(command.style, DumpStyle::Dcd | DumpStyle::Xtc);
        let (length, velocity, time) = factors(kind, lammps, facts.units);
        let unwrap = match &command.style {
            DumpStyle::Netcdf(columns) => columns.contains(&DumpColumn::Unwrapped(0)),
            _ => kind == Kind::Lammps,
        };
        Ok(Self {
            path: path.text.clone(),
            style: command.style.name(),
            format,
            kind,
            velocities: has_velocities,
            unwrap,
            append: false,
            elements: None,
            length,
            velocity,
            time,
            precision: None,
            open: None,
            frame: None,
            topology: Vec::new(),
            frames: 0,
            steps: None,
        })
    }

    fn failed(&self, error: &chemfiles::Error) -> Error {
        Error::file(&self.path, "cannot write", std::io::Error::other(error.to_string()))
    }

    /// Opens the file, unless it is open. A dump that was closed and goes on appends to what it has written.
    fn open(&mut self) -> Result<&mut Trajectory, Error> {
        if self.open.is_none() {
            let append = self.append || self.frames > 0;
            let trajectory =
                Trajectory::open_with_format(&self.path, if append { 'a' } else { 'w' }, self.format.as_str())
                    .map_err(|e| self.failed(&e))?;
            self.open = Some(trajectory);
        }
        self.open.as_mut().ok_or_else(|| Error::Unavailable(format!("{}: cannot write", self.path)))
    }

    /// Atoms with their names and masses.
    fn frame_of(&self, shown: &Frame<'_>, topology: &[(u32, u32)]) -> ChemfilesFrame {
        let mut frame = ChemfilesFrame::new();
        frame.resize(topology.len());
        for (k, (_, kind)) in topology.iter().enumerate() {
            let name = self.name(*kind);
            let mut atom = frame.atom_mut(k);
            atom.set_name(name.as_str());
            atom.set_atomic_type(if self.kind == Kind::Lammps { kind.to_string() } else { name }.as_str());
            atom.set_mass(shown.facts.mass(*kind));
        }
        if self.velocities {
            frame.add_velocities();
        }
        match self.kind {
            Kind::Lammps => frame.set("lammps_units", shown.facts.units.name),
            Kind::Xtc => {
                if let Some(precision) = self.precision {
                    frame.set("xtc_precision", f64::from(precision));
                }
            }
            _ => (),
        }
        frame
    }

    fn name(&self, kind: u32) -> String {
        let names = self.elements.as_deref().unwrap_or_default();
        names.get((kind as usize).wrapping_sub(1)).cloned().unwrap_or_else(|| kind.to_string())
    }

    fn fill(&self, frame: &mut ChemfilesFrame, shown: &Frame<'_>) -> Result<(), Error> {
        let snapshot = shown.snapshot;
        for (slot, &atom) in frame.positions_mut().iter_mut().zip(&shown.atoms) {
            let x = if self.unwrap { shown.unwrapped(atom) } else { shown.place(atom).0 };
            *slot = (x * self.length).into();
        }
        if let Some(velocities) = frame.velocities_mut() {
            for (slot, &atom) in velocities.iter_mut().zip(&shown.atoms) {
                *slot = (snapshot.state.v[atom] * self.velocity).into();
            }
        }
        let edges = snapshot.simulation_box.lengths() * self.length;
        if edges.max() > LONGEST_EDGE {
            let what =
                format!("{}: chemfiles takes box edges up to {LONGEST_EDGE:e}, got {:e}", self.path, edges.max());
            return Err(Error::Unavailable(what));
        }
        frame.set_cell(&UnitCell::new(edges.into()));
        frame.set_step(usize::try_from(snapshot.step).unwrap_or(0));
        // LAMMPS's XTC time is step times timestep, whatever came before.
        let time = match self.kind {
            Kind::Xtc if self.style == "xtc" => snapshot.step as f64 * snapshot.timestep * self.time,
            _ => shown.facts.time(snapshot) * self.time,
        };
        if self.kind == Kind::Xyz {
            // As text: chemfiles prints numbers of a comment with six digits.
            frame.set("step", snapshot.step.to_string().as_str());
            frame.set("time", time.to_string().as_str());
        } else {
            frame.set("time", time);
        }
        Ok(())
    }
}

/// Factors for lengths, velocities and times. chemfiles has angstrom and picoseconds; reduced units are written as they
/// are, as if sigma were an angstrom and tau a picosecond.
fn factors(kind: Kind, lammps: bool, units: &Units) -> (f64, f64, f64) {
    let reduced = units.name == "lj";
    let time = if reduced { 1.0 } else { 1.0 / (units.femtosecond * FEMTOSECONDS_A_PICOSECOND) };
    let length = 1.0 / units.angstrom;
    match kind {
        Kind::Lammps => (1.0, 1.0, 1.0),
        // LAMMPS writes the scene's own lengths into DCD files, and lengths of reduced units into XTC files.
        Kind::Dcd if lammps => (1.0, 1.0, time),
        Kind::Xtc if lammps && reduced => (ANGSTROM_A_NANOMETER, 1.0, time),
        _ => (length, length / time, time),
    }
}

/// Whether velocities are among the columns of `dump netcdf`, all of which the format must hold.
fn netcdf_velocities(columns: &[DumpColumn], command: &DumpCommand) -> Result<bool, Complaint> {
    use DumpColumn::{Id, Position, Type, Unwrapped, Velocity};
    // Columns stand behind the file name, one word each.
    let word = |k: usize| command.file.word + 1 + k;
    if let Some(k) = columns.iter().position(|c| !matches!(c, Id | Type | Position(_) | Unwrapped(_) | Velocity(_))) {
        let why = format!("an Amber NetCDF file of octant holds no '{}'", columns[k].name());
        let help = "columns: id type x y z xu yu zu vx vy vz";
        return Err(Complaint::new(word(k), why).with_help(help));
    }
    let all = |column: fn(usize) -> DumpColumn| (0..3).all(|axis| columns.contains(&column(axis)));
    let any = |column: fn(usize) -> DumpColumn| (0..3).any(|axis| columns.contains(&column(axis)));
    let one = |column: fn(usize) -> DumpColumn| any(column) == all(column);
    if all(Position) == all(Unwrapped) || !(one(Position) && one(Unwrapped) && one(Velocity)) {
        let why = "expected x y z or xu yu zu among the columns, and vx vy vz together or not at all";
        return Err(Complaint::new(word(0), why));
    }
    Ok(any(Velocity))
}

fn format_help() -> String {
    let shown = trajectory_formats().into_iter().map(|format| match format.extension {
        Some(extension) => format!("{} ({extension})", format.name),
        None => format.name,
    });
    format!("formats: {}", shown.collect::<Vec<_>>().join(", "))
}

fn named_format(name: &str, word: usize) -> Result<(String, bool), Complaint> {
    match trajectory_formats().into_iter().find(|format| format.name.eq_ignore_ascii_case(name)) {
        Some(format) => Ok((format.name, format.velocities)),
        None => Err(Complaint::new(word, format!("chemfiles writes no format '{name}'")).with_help(format_help())),
    }
}

fn guessed_format(path: &str, word: usize) -> Result<(String, bool), Complaint> {
    let no_format = |why: String| Complaint::new(word, why).with_help(format_help());
    let guess = chemfiles::guess_format(path)
        .map_err(|_| no_format(format!("chemfiles knows no format by the extension of '{path}'")))?;
    let name = guess.split(" / ").next().unwrap_or_default();
    let Some(format) = trajectory_formats().into_iter().find(|format| format.name == name) else {
        return Err(no_format(format!("chemfiles writes no trajectories in {name} format ('{path}')")));
    };
    if guess.contains(" / ") && !format.is_text {
        return Err(no_format(format!("{name} files cannot be compressed, got '{path}'")));
    }
    Ok((guess.clone(), format.velocities))
}

impl SnapshotWriter for TrajectoryWriter {
    fn needs(&self) -> Needs {
        Needs { positions: true, ..Needs::default() }
    }

    fn change(&mut self, change: &DumpChange, facts: &SceneFacts) -> Result<bool, Complaint> {
        let lammps_xtc = self.style == "xtc";
        match change {
            DumpChange::Append(append) => {
                if *append && self.format.contains(" / ") {
                    return Err(Complaint::new(0, "compressed files cannot be appended to"));
                }
                self.append = *append;
            }
            // Files are whole when they are closed.
            DumpChange::Flush(_) => (),
            DumpChange::Unwrap(unwrap) if self.style != "netcdf" => self.unwrap = *unwrap,
            DumpChange::Element(names) if self.style == "chemfiles" => {
                if names.len() != facts.types() {
                    let why = format!("expected {} element names, one a type, got {}", facts.types(), names.len());
                    return Err(Complaint::new(0, why));
                }
                if names.iter().any(|name| name.contains('\0')) {
                    return Err(Complaint::new(0, "expected element names, got one with a zero byte"));
                }
                self.elements = Some(names.clone());
            }
            DumpChange::Precision(precision) if self.kind == Kind::Xtc => self.precision = Some(*precision),
            DumpChange::LengthFactor(factor) if lammps_xtc => self.length = factor * ANGSTROM_A_NANOMETER,
            DumpChange::TimeFactor(factor) if lammps_xtc => self.time = *factor,
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn check(&self, sort: SortBy) -> Result<(), String> {
        if sort == SortBy::Id { Ok(()) } else { Err(format!("dump style {} needs atoms sorted by id", self.style)) }
    }

    fn write(&mut self, shown: &Frame<'_>, console: &mut Console) -> Result<(), Error> {
        let state = shown.snapshot.state;
        let topology: Vec<(u32, u32)> = shown.atoms.iter().map(|&k| (state.id[k], state.kind[k])).collect();
        let mut frame = match self.frame.take() {
            Some(frame) if topology == self.topology => frame,
            _ => self.frame_of(shown, &topology),
        };
        self.fill(&mut frame, shown)?;
        let written = self.open()?.write(&frame);
        for message in warnings::take() {
            console.warning(&format!("{}: {message}", self.path));
        }
        written.map_err(|e| self.failed(&e))?;
        self.frames += 1;
        self.topology = topology;
        self.frame = Some(frame);
        let (step, timestep, every) = (shown.snapshot.step, shown.snapshot.timestep, shown.every);
        let first = self.steps.map_or(step, |steps| steps.first);
        self.steps = Some(dcd::Steps { first, every, last: step, timestep });
        Ok(())
    }

    fn sort_value(&self, _: usize, frame: &Frame<'_>, atom: usize) -> f64 {
        f64::from(frame.snapshot.state.id[atom])
    }

    fn close(&mut self) -> Result<(), Error> {
        if let Some(trajectory) = self.open.take() {
            // chemfiles completes and closes the file here.
            drop(trajectory);
            if let (Kind::Dcd, Some(steps)) = (self.kind, self.steps) {
                dcd::write_steps(self.path.as_ref(), steps, self.append)
                    .map_err(|e| Error::file(&self.path, "cannot write", e))?;
            }
        }
        Ok(())
    }

    fn report(&self) -> WrittenFile {
        let bytes = if self.frames > 0 { std::fs::metadata(&self.path).map_or(0, |found| found.len()) } else { 0 };
        WrittenFile { path: self.path.clone(), format: self.format.clone(), frames: self.frames, bytes }
    }
}
