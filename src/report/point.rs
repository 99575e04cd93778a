//! A way to run the scene: potential, integrator, precision, time step, list.

use crate::engine::Precision;
use crate::neighbor::Policy;

/// Which potential: another truncation is another Hamiltonian, whose points are never compared with those of the scene's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Potential {
    /// The script's.
    Own,
    /// `lj/smooth/linear` in place of `lj/cut`.
    ForceShifted,
}

/// What moves the atoms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Integrator {
    /// The script's fixes.
    Own,
    /// `nve/euler2` in place of `nve`.
    Euler2,
}

/// A way to run the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    pub potential: Potential,
    pub integrator: Integrator,
    pub precision: Precision,
    /// Time units.
    pub dt: f64,
    pub policy: Policy,
}

/// Columns that name a point.
pub const KEYS: &[&str] = &["potential", "integrator", "precision", "dt", "skin", "rebuild"];

impl Point {
    pub fn cells(&self) -> Vec<String> {
        vec![
            self.potential.name().into(),
            self.integrator.name().into(),
            self.precision.name().into(),
            self.dt.to_string(),
            self.policy.skin.to_string(),
            rebuild(&self.policy),
        ]
    }
}

impl Potential {
    pub fn name(self) -> &'static str {
        ["own", "force-shifted"][self as usize]
    }
}

impl Integrator {
    pub fn name(self) -> &'static str {
        ["own", "nve/euler2"][self as usize]
    }
}

/// The words of `neigh_modify`.
pub fn rebuild(policy: &Policy) -> String {
    let yes = |b: bool| if b { "yes" } else { "no" };
    let once = if policy.once { " once yes" } else { "" };
    format!("every {} delay {} check {}{once}", policy.every, policy.delay, yes(policy.check))
}

/// Whether lists are built as soon as an atom could have come into reach unseen, so that none lacks a pair.
pub fn is_safe(policy: &Policy) -> bool {
    policy.check && policy.every == 1 && policy.delay <= 1 && !policy.once
}

/// The policy that never lacks a pair, with the same skin.
pub fn safe(policy: &Policy) -> Policy {
    Policy { every: 1, delay: 0, check: true, once: false, ..*policy }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_have_words() {
        let policy = Policy { every: 20, check: false, ..Policy::new(0.3) };
        let (potential, integrator) = (Potential::ForceShifted, Integrator::Own);
        let point = Point { potential, integrator, precision: Precision::Mixed, dt: 0.005, policy };
        let expected = ["force-shifted", "own", "mixed", "0.005", "0.3", "every 20 delay 0 check no"];
        assert_eq!(point.cells(), expected);
        assert_eq!(point.cells().len(), KEYS.len());
        assert!(!is_safe(&policy) && is_safe(&safe(&policy)));
    }
}
