//! The quantities of the thermo table, by LAMMPS's keywords (doc page `thermo_style`).

use super::facts::SceneFacts;
use crate::engine::{Needs, Snapshot};
use crate::system::State;
use crate::system::temperature::{degrees_of_freedom, temperature};

/// A thermo value; LAMMPS prints counts as integers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Number {
    Integer(i64),
    Float(f64),
}

impl Number {
    /// As a formula sees it.
    pub fn value(self) -> f64 {
        match self {
            Self::Integer(n) => n as f64,
            Self::Float(x) => x,
        }
    }
}

/// What is known of a thermo keyword without a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeywordInfo {
    /// Name in `thermo_style custom`.
    pub name: &'static str,
    /// Column header.
    pub header: &'static str,
    /// Printed as an integer.
    pub integer: bool,
    /// Grows with the system: divided by the number of atoms under `thermo_modify norm yes`.
    pub extensive: bool,
    /// What must be computed for it.
    pub needs: Needs,
    /// Tells of the run and not of the particles at its step: wall time, list builds so far.
    pub of_run: bool,
}

const NOTHING: Needs = Needs { energy: false, virial: false, pressure: false, positions: false, forces: false };
const ENERGY: Needs = Needs { energy: true, ..NOTHING };
const VIRIAL: Needs = Needs { virial: true, ..NOTHING };
const PRESSURE: Needs = Needs { pressure: true, ..NOTHING };
const BOTH: Needs = Needs { energy: true, pressure: true, ..NOTHING };
const FORCES: Needs = Needs { forces: true, ..NOTHING };

const fn count(name: &'static str, header: &'static str) -> KeywordInfo {
    KeywordInfo { name, header, integer: true, extensive: false, needs: NOTHING, of_run: false }
}

const fn plain(name: &'static str, header: &'static str, needs: Needs) -> KeywordInfo {
    KeywordInfo { name, header, integer: false, extensive: false, needs, of_run: false }
}

const fn extensive(name: &'static str, header: &'static str, needs: Needs) -> KeywordInfo {
    KeywordInfo { name, header, integer: false, extensive: true, needs, of_run: false }
}

const fn of_run(info: KeywordInfo) -> KeywordInfo {
    KeywordInfo { of_run: true, ..info }
}

/// Every keyword, in the order of the documentation.
#[rustfmt::skip]
pub const KEYWORDS: &[KeywordInfo] = &[
    count("step", "Step"), count("elapsed", "Elapsed"), count("elaplong", "Elaplong"),
    plain("dt", "Dt", NOTHING), plain("time", "Time", NOTHING),
    of_run(plain("cpu", "CPU", NOTHING)), of_run(plain("tpcpu", "T/CPU", NOTHING)),
    of_run(plain("spcpu", "S/CPU", NOTHING)), of_run(plain("cpuremain", "CPULeft", NOTHING)), count("part", "Part"), plain("timeremain", "TimeoutLeft", NOTHING),
    count("atoms", "Atoms"), plain("temp", "Temp", NOTHING), plain("press", "Press", PRESSURE),
    extensive("pe", "PotEng", ENERGY), extensive("ke", "KinEng", NOTHING), extensive("etotal", "TotEng", ENERGY),
    extensive("evdwl", "E_vdwl", ENERGY), extensive("ecoul", "E_coul", NOTHING), extensive("epair", "E_pair", ENERGY),
    extensive("ebond", "E_bond", NOTHING), extensive("eangle", "E_angle", NOTHING),
    extensive("edihed", "E_dihed", NOTHING), extensive("eimp", "E_impro", NOTHING),
    extensive("emol", "E_mol", NOTHING), extensive("elong", "E_long", NOTHING), extensive("etail", "E_tail", NOTHING),
    extensive("enthalpy", "Enthalpy", BOTH), extensive("ecouple", "Ecouple", NOTHING),
    extensive("econserve", "Econserve", ENERGY), plain("vol", "Volume", NOTHING), plain("density", "Density", NOTHING),
    plain("xlo", "Xlo", NOTHING), plain("xhi", "Xhi", NOTHING), plain("ylo", "Ylo", NOTHING),
    plain("yhi", "Yhi", NOTHING), plain("zlo", "Zlo", NOTHING), plain("zhi", "Zhi", NOTHING),
    plain("xy", "Xy", NOTHING), plain("xz", "Xz", NOTHING), plain("yz", "Yz", NOTHING),
    plain("lx", "Lx", NOTHING), plain("ly", "Ly", NOTHING), plain("lz", "Lz", NOTHING),
    plain("avecx", "Avecx", NOTHING), plain("avecy", "Avecy", NOTHING), plain("avecz", "Avecz", NOTHING),
    plain("bvecx", "Bvecx", NOTHING), plain("bvecy", "Bvecy", NOTHING), plain("bvecz", "Bvecz", NOTHING),
    plain("cvecx", "Cvecx", NOTHING), plain("cvecy", "Cvecy", NOTHING), plain("cvecz", "Cvecz", NOTHING),
    plain("xlat", "Xlat", NOTHING), plain("ylat", "Ylat", NOTHING), plain("zlat", "Zlat", NOTHING),
    count("bonds", "Bonds"), count("angles", "Angles"), count("dihedrals", "Diheds"), count("impropers", "Impros"),
    plain("pxx", "Pxx", VIRIAL), plain("pyy", "Pyy", VIRIAL), plain("pzz", "Pzz", VIRIAL),
    plain("pxy", "Pxy", VIRIAL), plain("pxz", "Pxz", VIRIAL), plain("pyz", "Pyz", VIRIAL),
    plain("fmax", "Fmax", FORCES), plain("fnorm", "Fnorm", FORCES),
    of_run(count("nbuild", "Nbuild")), of_run(count("ndanger", "Ndanger")),
    plain("cella", "Cella", NOTHING), plain("cellb", "Cellb", NOTHING), plain("cellc", "Cellc", NOTHING),
    plain("cellalpha", "CellAlpha", NOTHING), plain("cellbeta", "CellBeta", NOTHING),
    plain("cellgamma", "CellGamma", NOTHING),
];

/// Looks a thermo keyword up.
pub fn keyword(name: &str) -> Option<&'static KeywordInfo> {
    KEYWORDS.iter().find(|k| k.name == name)
}

/// A snapshot's quantities, each computed when asked for.
pub struct Quantities<'a> {
    snapshot: &'a Snapshot<'a>,
    facts: &'a SceneFacts,
    per_atom: bool,
}

impl<'a> Quantities<'a> {
    /// `per_atom` divides extensive quantities by the number of atoms (`thermo_modify norm`).
    pub fn new(snapshot: &'a Snapshot<'a>, facts: &'a SceneFacts, per_atom: bool) -> Self {
        Self { snapshot, facts, per_atom }
    }

    pub fn snapshot(&self) -> &Snapshot<'a> {
        self.snapshot
    }

    /// Value of a keyword; `None` where there is no such keyword.
    pub fn lookup(&self, keyword: &str) -> Option<Number> {
        let s = self.snapshot;
        let count = match keyword {
            "step" => s.step,
            "elapsed" => s.step - s.first_step,
            "elaplong" => s.step - self.facts.counting_from.unwrap_or(s.first_step),
            "atoms" => s.state.len() as i64,
            "nbuild" => s.neighbors.builds as i64,
            "ndanger" => s.neighbors.dangerous.unwrap_or(0) as i64,
            "part" | "bonds" | "angles" | "dihedrals" | "impropers" => 0,
            _ => return self.float(keyword).map(Number::Float),
        };
        Some(Number::Integer(count))
    }

    fn float(&self, keyword: &str) -> Option<f64> {
        let s = self.snapshot;
        let (lo, hi, edges) = (s.simulation_box.lo, s.simulation_box.hi, s.simulation_box.lengths());
        Some(match keyword {
            "dt" => s.timestep,
            "time" => self.time(),
            "cpu" => self.cpu(),
            "tpcpu" => self.per_cpu((s.step - s.first_step) as f64 * s.timestep),
            "spcpu" => self.per_cpu((s.step - s.first_step) as f64),
            "cpuremain" => self.per_cpu((s.step - s.first_step) as f64).recip_or_zero() * (s.last_step - s.step) as f64,
            "temp" => self.temperature(),
            "press" => self.pressure(),
            "pe" | "epair" | "evdwl" => self.potential(),
            "ke" => self.kinetic(),
            "etotal" => self.potential() + self.kinetic(),
            "ecouple" => self.bath(),
            "econserve" => self.potential() + self.kinetic() + self.bath(),
            "enthalpy" => self.enthalpy(),
            // A scene of atoms with pair forces alone has none of these; its box is orthogonal and its clock has no alarm.
            "ecoul" | "ebond" | "eangle" | "edihed" | "eimp" | "emol" | "elong" => 0.0,
            "etail" => self.normalized(self.facts.tail.energy / s.simulation_box.volume()),
            "xy" | "xz" | "yz" | "avecy" | "avecz" | "bvecx" | "bvecz" | "cvecx" | "cvecy" | "timeremain" => 0.0,
            "vol" => s.simulation_box.volume(),
            "density" => self.facts.units.mv2d * self.mass() / s.simulation_box.volume(),
            "xlo" => lo.x,
            "ylo" => lo.y,
            "zlo" => lo.z,
            "xhi" => hi.x,
            "yhi" => hi.y,
            "zhi" => hi.z,
            "lx" | "cella" | "avecx" => edges.x,
            "ly" | "cellb" | "bvecy" => edges.y,
            "lz" | "cellc" | "cvecz" => edges.z,
            "cellalpha" | "cellbeta" | "cellgamma" => 90.0,
            "xlat" => self.facts.lattice[0],
            "ylat" => self.facts.lattice[1],
            "zlat" => self.facts.lattice[2],
            "pxx" => self.pressure_component(0),
            "pyy" => self.pressure_component(1),
            "pzz" => self.pressure_component(2),
            "pxy" => self.pressure_component(3),
            "pxz" => self.pressure_component(4),
            "pyz" => self.pressure_component(5),
            "fmax" => largest_force_component(s.state),
            "fnorm" => s.state.f.iter().map(|f| f.norm_squared()).sum::<f64>().sqrt(),
            _ => return None,
        })
    }

    /// Simulated time, time units.
    pub fn time(&self) -> f64 {
        self.facts.time(self.snapshot)
    }

    /// Wall seconds of this run; 0 at its first step, whose row stands for the moment before the loop.
    pub fn cpu(&self) -> f64 {
        if self.snapshot.step == self.snapshot.first_step { 0.0 } else { self.snapshot.elapsed_seconds }
    }

    fn per_cpu(&self, amount: f64) -> f64 {
        let seconds = self.cpu();
        if seconds > 0.0 { amount / seconds } else { 0.0 }
    }

    /// Atoms whose degrees of freedom the temperature counts.
    fn thermal_atoms(&self) -> usize {
        self.facts.thermal_atoms.unwrap_or(self.snapshot.state.len())
    }

    fn temperature(&self) -> f64 {
        let k = &self.snapshot.sums.kinetic;
        temperature(k[0] + k[1] + k[2], degrees_of_freedom(self.thermal_atoms()), self.facts.units)
    }

    /// Scalar pressure: (dof k_B T + W) / (3 V).
    fn pressure(&self) -> f64 {
        let s = self.snapshot;
        let kinetic = degrees_of_freedom(self.thermal_atoms()) * self.facts.units.boltzmann * self.temperature();
        let [xx, yy, zz] = [0, 1, 2].map(|k| self.virial(k));
        (kinetic + xx + yy + zz) / 3.0 / s.simulation_box.volume() * self.facts.units.nktv2p
    }

    /// Pressure tensor; unlike the scalar it takes the kinetic tensor as it is, for 3N degrees of freedom.
    fn pressure_component(&self, k: usize) -> f64 {
        let s = self.snapshot;
        (s.sums.kinetic[k] * self.facts.units.mvv2e + self.virial(k)) / s.simulation_box.volume()
            * self.facts.units.nktv2p
    }

    /// Virial tensor with what lies beyond the cutoff.
    fn virial(&self, k: usize) -> f64 {
        let tail = if k < 3 { self.facts.tail.virial / self.snapshot.simulation_box.volume() } else { 0.0 };
        self.snapshot.sums.virial[k] + tail
    }

    fn potential(&self) -> f64 {
        self.normalized(self.snapshot.sums.potential + self.facts.tail.energy / self.snapshot.simulation_box.volume())
    }

    fn kinetic(&self) -> f64 {
        let freedom = degrees_of_freedom(self.thermal_atoms());
        self.normalized(self.temperature() * 0.5 * freedom * self.facts.units.boltzmann)
    }

    /// What thermostats have taken.
    fn bath(&self) -> f64 {
        self.normalized(self.snapshot.sums.bath)
    }

    fn enthalpy(&self) -> f64 {
        let volume = self.normalized(self.snapshot.simulation_box.volume());
        self.potential() + self.kinetic() + self.pressure() * volume / self.facts.units.nktv2p
    }

    fn normalized(&self, extensive: f64) -> f64 {
        let atoms = self.snapshot.state.len();
        if self.per_atom && atoms > 0 { extensive / atoms as f64 } else { extensive }
    }

    /// Mass of all atoms; counted by type, as a sum over atoms would lose digits.
    fn mass(&self) -> f64 {
        self.snapshot
            .state
            .atoms_of(self.facts.types())
            .iter()
            .zip(&self.facts.masses)
            .map(|(n, mass)| *n as f64 * mass)
            .sum()
    }
}

trait RecipOrZero {
    fn recip_or_zero(self) -> f64;
}

impl RecipOrZero for f64 {
    fn recip_or_zero(self) -> f64 {
        if self == 0.0 { 0.0 } else { self.recip() }
    }
}

/// Largest component of any atom's force, without its sign.
fn largest_force_component(state: &State) -> f64 {
    state.f.iter().flat_map(|f| f.iter()).fold(0.0, |most, component| component.abs().max(most))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::engine::{NeighborStatistics, Sums};
    use crate::system::{Clock, Side, SimulationBox, State, Units, Vec3};

    /// Two atoms in a box with one side of each kind: metal units, at step 25 of a run from 5 to 105.
    pub(crate) fn sample() -> (State, SimulationBox, Sums) {
        let mut state = State::default();
        state.push(7, 1, Vec3::new(1.0, 1.0, 1.0));
        state.push(3, 2, Vec3::new(2.125, 1.25, 6.5));
        state.v = vec![Vec3::new(0.5, -0.25, 1.0), Vec3::new(-1.0, 2.0, 0.125)];
        state.f = vec![Vec3::new(1.0, 2.0, -7.0), Vec3::new(-1.0, -2.0, 6.0)];
        state.image = vec![[0, 0, 2], [0, 0, -1]];
        let simulation_box = SimulationBox {
            lo: Vec3::new(0.5, -1.0, 0.0),
            hi: Vec3::new(2.5, 6.0, 6.5),
            sides: [[Side::Shrink; 2], [Side::Fixed, Side::Shrink], [Side::Periodic; 2]],
            margin: Vec3::zeros(),
        };
        let sums = Sums {
            // In energy units 0.5, 0.25, ...: metal units have mvv2e = 1.0364269e-4.
            kinetic: [0.5, 0.25, 0.125, 0.01, 0.02, 0.03].map(|k| k / 1.0364269e-4),
            potential: -3.0,
            virial: [1.0, 2.0, 4.0, 0.1, 0.2, 0.3],
            bath: 0.75,
        };
        (state, simulation_box, sums)
    }

    pub(crate) fn snapshot<'a>(state: &'a State, simulation_box: &'a SimulationBox, sums: &'a Sums) -> Snapshot<'a> {
        Snapshot {
            step: 25,
            first_step: 5,
            last_step: 105,
            timestep: 0.002,
            state,
            simulation_box,
            sums,
            neighbors: NeighborStatistics { builds: 4, dangerous: Some(1), pairs: 10, redone: 0 },
            elapsed_seconds: 2.0,
        }
    }

    pub(crate) fn facts() -> SceneFacts {
        SceneFacts {
            clock: Clock { time: 1.0, step: 5 },
            ..SceneFacts::new(Units::named("metal").unwrap(), vec![26.98, 12.5])
        }
    }

    #[test]
    fn every_keyword_has_a_value_of_its_kind() {
        let (state, simulation_box, sums) = sample();
        let (snapshot, facts) = (snapshot(&state, &simulation_box, &sums), facts());
        let quantities = Quantities::new(&snapshot, &facts, false);
        for info in KEYWORDS {
            match quantities.lookup(info.name) {
                Some(Number::Integer(_)) => assert!(info.integer, "{}", info.name),
                Some(Number::Float(_)) => assert!(!info.integer, "{}", info.name),
                None => panic!("{} has no value", info.name),
            }
        }
        assert_eq!(quantities.lookup("fmin"), None);
    }

    /// Norm divides exactly the keywords that say so.
    #[test]
    fn extensive_values_are_divided_by_the_number_of_atoms() {
        let (state, simulation_box, sums) = sample();
        let (snapshot, facts) = (snapshot(&state, &simulation_box, &sums), facts());
        let total = Quantities::new(&snapshot, &facts, false);
        let per_atom = Quantities::new(&snapshot, &facts, true);
        for info in KEYWORDS {
            let (a, b) = (total.lookup(info.name).unwrap().value(), per_atom.lookup(info.name).unwrap().value());
            let expected = if info.extensive { a / 2.0 } else { a };
            approx::assert_relative_eq!(b, expected, max_relative = 1e-14);
        }
    }

    #[test]
    fn formulas_in_metal_units() {
        let (state, simulation_box, sums) = sample();
        let (snapshot, facts) = (snapshot(&state, &simulation_box, &sums), facts());
        let value = |name: &str| Quantities::new(&snapshot, &facts, false).lookup(name).unwrap().value();
        let near = |name: &str, expected: f64| approx::assert_relative_eq!(value(name), expected, max_relative = 1e-14);
        near("temp", 0.875 / (3.0 * 8.617343e-5));
        near("ke", 0.4375);
        near("vol", 91.0);
        near("press", (0.875 + 7.0) / 273.0 * 1.6021765e6);
        near("pxz", 0.22 / 91.0 * 1.6021765e6);
        near("enthalpy", -3.0 + 0.4375 + 7.875 / 3.0);
        near("density", 39.48 / 91.0 / 0.602214129);
        near("time", 1.04);
        near("cpuremain", 8.0);
        near("fmax", 7.0);
        near("fnorm", 95.0_f64.sqrt());
        assert_eq!(value("elapsed"), 20.0);
    }

    #[test]
    fn a_single_atom_has_no_temperature() {}
}
