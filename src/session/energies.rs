//! Energies of a run at a step, and what they should do.

use crate::dynamics::{Balance, Fix};
use crate::engine::{NeighborStatistics, Program, Sums};
use crate::system::temperature::{degrees_of_freedom, temperature};

/// What the energy of a scene should do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Energy {
    /// Stay what it is.
    Stays,
    /// Follow baths up to this temperature.
    Bath(f64),
    /// Unknown.
    Open,
}

impl Energy {
    /// What the fixes of a scene make of it.
    pub fn of(program: &Program) -> Self {
        let one = |fix: &Fix| match fix.balance() {
            Balance::Conserves => Self::Stays,
            Balance::Bath(places) => Self::Bath(places.map(|k| fix.parameters[k]).into_iter().fold(0.0, f64::max)),
            Balance::Open => Self::Open,
        };
        program.fixes.iter().map(one).fold(Self::Stays, |all, one| match (all, one) {
            (Self::Open, _) | (_, Self::Open) => Self::Open,
            (Self::Bath(a), Self::Bath(b)) => Self::Bath(a.max(b)),
            (Self::Bath(t), Self::Stays) | (Self::Stays, Self::Bath(t)) => Self::Bath(t),
            (Self::Stays, Self::Stays) => Self::Stays,
        })
    }
}

/// Energies at a step, energy units.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    pub step: i64,
    pub potential: f64,
    pub kinetic: f64,
    pub temperature: f64,
    pub pairs: u64,
}

impl Look {
    pub fn at(program: &Program, step: i64, sums: &Sums, atoms: usize, neighbors: &NeighborStatistics) -> Self {
        let units = &program.units;
        let squares = sums.kinetic[0] + sums.kinetic[1] + sums.kinetic[2];
        Self {
            step,
            potential: sums.potential,
            kinetic: 0.5 * units.mvv2e * squares,
            temperature: temperature(squares, degrees_of_freedom(atoms), units),
            pairs: neighbors.pairs,
        }
    }

    /// How much more the total energy is than before.
    pub fn change(&self, before: &Self) -> f64 {
        self.potential + self.kinetic - (before.potential + before.kinetic)
    }
}
