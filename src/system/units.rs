//! Unit systems and their constants (LAMMPS doc page `units`).

/// A unit system: constants that turn its mixed units into each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Name in the `units` command.
    pub name: &'static str,
    /// Boltzmann constant, energy / temperature.
    pub boltzmann: f64,
    /// Mass times velocity squared to energy.
    pub mvv2e: f64,
    /// Energy over volume to pressure.
    pub nktv2p: f64,
    /// Force to acceleration times mass (1 / mvv2e).
    pub ftm2v: f64,
    /// Mass over volume to density.
    pub mv2d: f64,
    /// Default timestep, time units.
    pub timestep: f64,
    /// Default skin, length units.
    pub skin: f64,
    /// One angstrom in length units.
    pub angstrom: f64,
    /// One femtosecond in time units.
    pub femtosecond: f64,
    /// Thermo prints energies per atom by default.
    pub per_atom: bool,
}

/// LAMMPS writes this conversion as a square because velocities come from kcal/mol.
const REAL_MVV2E: f64 = 48.88821291 * 48.88821291;

/// All unit systems, `lj` (the default) first.
pub const UNITS: [Units; 4] = [
    Units {
        name: "lj",
        boltzmann: 1.0,
        mvv2e: 1.0,
        nktv2p: 1.0,
        ftm2v: 1.0,
        mv2d: 1.0,
        timestep: 0.005,
        skin: 0.3,
        angstrom: 1.0,
        femtosecond: 1.0,
        per_atom: true,
    },
    Units {
        name: "real",
        boltzmann: 0.0019872067,
        mvv2e: REAL_MVV2E,
        nktv2p: 68568.415,
        ftm2v: 1.0 / REAL_MVV2E,
        mv2d: 1.0 / 0.602214129,
        timestep: 1.0,
        skin: 2.0,
        angstrom: 1.0,
        femtosecond: 1.0,
        per_atom: false,
    },
    Units {
        name: "metal",
        boltzmann: 8.617343e-5,
        mvv2e: 1.0364269e-4,
        nktv2p: 1.6021765e6,
        ftm2v: 1.0 / 1.0364269e-4,
        mv2d: 1.0 / 0.602214129,
        timestep: 0.001,
        skin: 2.0,
        angstrom: 1.0,
        femtosecond: 0.001,
        per_atom: false,
    },
    Units {
        name: "si",
        boltzmann: 1.3806504e-23,
        mvv2e: 1.0,
        nktv2p: 1.0,
        ftm2v: 1.0,
        mv2d: 1.0,
        timestep: 1.0e-8,
        skin: 0.001,
        angstrom: 1.0e-10,
        femtosecond: 1.0e-15,
        per_atom: false,
    },
];

impl Units {
    /// Looks a unit system up by its name in the `units` command.
    pub fn named(name: &str) -> Option<&'static Units> {
        UNITS.iter().find(|u| u.name == name)
    }
}
