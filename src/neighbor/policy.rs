//! When lists are built anew (LAMMPS doc page `neigh_modify`), the same on every backend.

/// Edge of the bins that LAMMPS sorts atoms into, as a part of the largest neighbor cutoff. Octant's cells are its own; these
/// bins show in storage order and in the rounding of ties.
pub const LAMMPS_BIN: f64 = 0.5;

/// Settings of `neighbor` and `neigh_modify`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Policy {
    /// Length units added to every cutoff.
    pub skin: f64,
    pub every: u64,
    pub delay: u64,
    /// Build only if a particle has moved more than half the skin.
    pub check: bool,
    /// Build at the start of a run only.
    pub once: bool,
}

impl Policy {
    /// LAMMPS's defaults with the skin of the unit system.
    pub fn new(skin: f64) -> Self {
        Self { skin, every: 1, delay: 0, check: true, once: false }
    }

    /// What to do `ago` steps after the last build.
    pub fn decide(&self, ago: u64) -> Decision {
        if self.once || ago < self.delay || !ago.is_multiple_of(self.every) {
            Decision::Keep
        } else if self.check {
            Decision::Check { first_chance: ago == self.every.max(self.delay) }
        } else {
            Decision::Build
        }
    }

    /// Squared displacement beyond which a particle calls for a build.
    pub fn trigger(&self) -> f64 {
        0.25 * self.skin * self.skin
    }

    /// Steps until the policy next has a say, from `ago` steps after the last build.
    pub fn next_chance(&self, ago: u64) -> Option<u64> {
        if self.once {
            return None;
        }
        let earliest = (ago + 1).max(self.delay);
        Some(earliest.div_ceil(self.every) * self.every - ago)
    }
}

/// Outcome of [`Policy::decide`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    Keep,
    /// Build if a particle has moved too far; if it has at the first chance to notice, the build came too late to be sure
    /// ("dangerous").
    Check {
        first_chance: bool,
    },
    Build,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delay_and_every_decide_when_a_build_may_come() {
        let policy = Policy { every: 5, delay: 10, ..Policy::new(0.3) };
        assert_eq!(policy.decide(5), Decision::Keep);
        assert_eq!(policy.decide(10), Decision::Check { first_chance: true });
        assert_eq!(policy.decide(12), Decision::Keep);
        assert_eq!(policy.decide(15), Decision::Check { first_chance: false });
        assert_eq!(Policy { check: false, ..policy }.decide(15), Decision::Build);
        assert_eq!(Policy { once: true, ..policy }.decide(15), Decision::Keep);
        for ago in 0..40 {
            let next = policy.next_chance(ago).unwrap();
            assert!((1..next).all(|k| policy.decide(ago + k) == Decision::Keep), "ago {ago}");
            assert_ne!(policy.decide(ago + next), Decision::Keep);
        }
    }
}
