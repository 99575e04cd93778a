//! Fixes that scale the velocities of their group as a whole: numbers that they keep from step to step, and what an engine has
//! to tell them. Such a fix acts in [`super::Phase::Measured`].

use super::{Fix, FixStyle, FixVisitor, Given, with_fix};

/// When a fix is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// At a set-up.
    SetUp,
    /// All particles have had the second half of a step: the kinetic energy is that of the moment.
    EndOfStep,
    /// Before the first half of a step.
    StartOfStep,
}

/// What a fix is told of its group.
#[derive(Clone, Copy, Debug)]
pub struct Group<R> {
    /// Sum of m v^2, mass times velocity squared; not looked at where a step starts.
    pub kinetic: R,
    /// Degrees of freedom: 3 N - 3.
    pub freedom: R,
    /// Timestep, time units.
    pub dt: R,
}

/// A thermostat of a scene while a run lasts.
#[derive(Clone, Debug, PartialEq)]
pub struct Thermostat {
    /// Its place among the scene's fixes.
    pub place: usize,
    /// [`Fix::group`].
    pub group: u32,
    /// What it keeps.
    pub memory: Vec<f64>,
    /// Degrees of freedom of its group, counted at the set-up.
    pub freedom: f64,
}

impl Thermostat {
    /// Those of a scene, as its last run has left them.
    pub fn all(fixes: &[Fix]) -> Vec<Self> {
        let thermostat = |(place, fix): (usize, &Fix)| {
            let numbers = fix.memory_size();
            let kept = fix.memory.len() == numbers;
            let memory = if kept { fix.memory.clone() } else { vec![0.0; numbers] };
            (numbers > 0).then_some(Self { place, group: fix.group, memory, freedom: 0.0 })
        };
        fixes.iter().enumerate().filter_map(thermostat).collect()
    }

    /// Asks the fix; the factor on the velocities of its group.
    pub fn act(&mut self, fix: &Fix, moment: Moment, kinetic: f64, dt: f64, progress: f64) -> f64 {
        struct Act<'a>(&'a Fix, Moment, &'a mut [f64], Group<f64>, f64);
        impl FixVisitor for Act<'_> {
            type Output = f64;
            fn visit<F: FixStyle>(self) -> f64 {
                let Act(fix, moment, memory, group, progress) = self;
                let given = Given { progress, ..Given::new(fix.choice, &fix.parameters) };
                F::thermostat(moment, memory, &group, &given)
            }
        }
        let group = Group { kinetic, freedom: self.freedom, dt };
        with_fix(fix.style, Act(fix, moment, &mut self.memory, group, progress)).unwrap_or(1.0)
    }

    /// Energy that has gone to the bath, energy units.
    pub fn energy(&self, fix: &Fix, dt: f64, progress: f64) -> f64 {
        struct Energy<'a>(&'a Fix, &'a [f64], Group<f64>, f64);
        impl FixVisitor for Energy<'_> {
            type Output = f64;
            fn visit<F: FixStyle>(self) -> f64 {
                let Energy(fix, memory, group, progress) = self;
                F::bath_energy(memory, &group, &Given { progress, ..Given::new(fix.choice, &fix.parameters) })
            }
        }
        let group = Group { kinetic: 0.0, freedom: self.freedom, dt };
        with_fix(fix.style, Energy(fix, &self.memory, group, progress)).unwrap_or(0.0)
    }
}

impl Fix {
    /// How many numbers it keeps from step to step.
    pub fn memory_size(&self) -> usize {
        struct Size(u32);
        impl FixVisitor for Size {
            type Output = usize;
            fn visit<F: FixStyle>(self) -> usize {
                F::memory_size(self.0)
            }
        }
        with_fix(self.style, Size(self.choice)).unwrap_or(0)
    }
}
