//! How fast a scene is, and what to do with one whose forces vanish by symmetry: lengths of runs come from there.

use super::point::Potential;
use super::study::Study;
use crate::Error;
use crate::bench::{Halt, exact, go};
use crate::engine::Precision;
use crate::session::Driven;

/// Trajectories are compared over this many of the scene's fastest times: 0.4 tau of the Lennard-Jones liquid.
const FASTEST_TIMES: f64 = 7.0;

/// An atom that flies freely crosses the cutoff in that time at least; no trajectory is longer, nor has it more of the script's steps.
const MOST_STEPS: f64 = 1000.0;

/// Net forces below this part of what they are in equilibrium (of their squares: 3 k T times the curvature) are those of a lattice.
const STILL: f64 = 0.1;
/// Net forces are rounding that would pull an atom away by less than this part of the cutoff.
const ROUNDED: f64 = 1e-9;
/// For so many of its fastest times a scene is run on that has no forces yet: a crystal that is hot enough melts in about half of that.
const RUN_ON: f64 = 20.0;
const MOST_RUN_ON: u64 = 5000;

/// How atoms swing about where they are: squares of their frequency, the Einstein frequency, in two ways that agree in equilibrium, and the
/// root mean square distance from where the curvature of the energy would have them, length units.
struct Swing {
    /// <F^2 / m> / (3 k T); infinite where forces push what has no temperature.
    by_force: f64,
    /// A third of the sum of the energy's second derivatives over the mass.
    by_curvature: f64,
    away: f64,
}

/// How fast a scene is.
#[derive(Clone, Debug)]
pub struct Pace {
    /// Time units over which trajectories are compared.
    pub span: f64,
    /// The scene's fastest time, time units.
    pub fastest: Option<f64>,
    /// Where that comes from.
    pub how: &'static str,
}

impl Study {
    /// Runs a scene on whose forces vanish by symmetry: they would be nothing but rounding, and so would be all that is measured by them.
    pub(super) fn leave_lattice(&mut self, sample: usize) -> Result<(), Halt> {
        let Swing { by_force, by_curvature, .. } = self.look_for_stillness()?;
        if !self.still {
            return Ok(());
        }
        let part = (by_force / by_curvature).sqrt();
        let fault = if self.temperature > 0.0 {
            let (dt, fastest) = (self.program.timestep, by_curvature.sqrt().recip());
            let steps = ((RUN_ON * fastest / dt).ceil() as u64).clamp(20, MOST_RUN_ON);
            match self.run_on(steps) {
                Ok(()) => {
                    self.look(sample);
                    self.look_for_stillness()?;
                    self.prepared = Some(format!(
                        "The script leaves a lattice: net forces are zero by symmetry (RMS {part:.0e} of what they are in equilibrium at its \
                         temperature). It was run on for {steps} steps, and what that leaves is studied."
                    ));
                    String::new()
                }
                Err(Halt::Error(Error::Fault(fault))) => format!(" Run on, it breaks: {fault}."),
                Err(halt) => return Err(halt),
            }
        } else {
            " Nothing moves, as the temperature is 0.".into()
        };
        if self.still {
            let words = "Net forces are zero by symmetry: force errors are relative to nothing and are left out; the fastest time is that \
                         of the curvature of the energy.";
            self.prepared = Some(format!("{}{words}{fault}", self.prepared.take().map_or(String::new(), |p| p + " ")));
        }
        self.notes.extend(self.prepared.clone());
        Ok(())
    }

    /// Whether net forces are those of a lattice: far too small for the temperature, or nothing but rounding.
    fn look_for_stillness(&mut self) -> Result<Swing, Halt> {
        let swing = self.swing()?;
        let rounded = swing.away < ROUNDED * self.program.pair.largest_cutoff();
        self.still = swing.by_curvature > 0.0 && (swing.by_force < STILL * swing.by_curvature || rounded);
        Ok(swing)
    }

    /// Runs steps with the script's own fixes.
    fn run_on(&mut self, steps: u64) -> Result<(), Halt> {
        let from = self.heated.as_ref().unwrap_or(&self.melted).clone();
        let mut driven = Driven::new(from, self.settings(Precision::Mixed))?;
        go(&mut driven, &format!("neigh_modify every 1 delay 0 check yes once no\nrun {steps}"))?;
        let mut after = driven.into_prepared();
        let scene = after.scene_mut();
        let (state, space, step) = (scene.state.clone(), scene.space.clone(), scene.step);
        self.space = space.clone().expect("a scene that runs has a box");
        for prepared in [Some(&mut self.melted), self.heated.as_mut()].into_iter().flatten() {
            let scene = prepared.scene_mut();
            (scene.state, scene.space, scene.step) = (state.clone(), space.clone(), step);
        }
        Ok(())
    }

    fn swing(&self) -> Result<Swing, Halt> {
        /// Atoms whose curvature is worked out.
        const SAMPLE: usize = 2_000;
        let exact = self.exact(Potential::Own)?;
        let (state, units, program) = (self.melted.state(), &self.program.units, &self.program);
        let order = state.order_by_id();
        let mass = |id: &u32| {
            let place = order.binary_search_by_key(id, |k| state.id[*k]).expect("the sample is of this state");
            program.masses[state.kind[order[place]] as usize - 1]
        };
        let mean = |sum: f64, ids: &[u32]| sum * units.ftm2v / (3.0 * ids.len().max(1) as f64);
        let squares = |power: i32| {
            let each =
                exact.ids.iter().zip(exact.atoms).map(|(id, atom)| atom.force.norm_squared() / mass(id).powi(power));
            mean(each.sum(), exact.ids)
        };
        let by_force = squares(1) / (units.boltzmann * self.temperature);
        let ids = exact::sample_of(state, SAMPLE);
        let curved = exact::curvatures(&program.pair, state, &self.space, &ids);
        let by_curvature = mean(ids.iter().zip(curved).map(|(id, curved)| curved / mass(id)).sum(), &ids);
        // 0 over 0 is nothing.
        let known = |x: f64| if x.is_nan() { 0.0 } else { x.max(0.0) };
        let (by_force, by_curvature) = (known(by_force), known(by_curvature));
        let away = (3.0 * squares(2) * units.ftm2v).sqrt() / by_curvature;
        Ok(Swing { by_force, by_curvature, away })
    }

    /// The fastest time, 1 / w of the Einstein frequency w, and the time over which trajectories are compared: some of these, but no more
    /// than an atom takes to cross the largest cutoff, nor than [`MOST_STEPS`].
    pub fn pace(&self) -> Result<Pace, Halt> {
        let Swing { by_force, by_curvature, .. } = self.swing()?;
        let state = self.melted.state();
        let (squared, how) = if by_force.is_finite() && by_force > by_curvature {
            (by_force, "1 / w, w^2 = <F^2 / m> / (3 k T)")
        } else {
            (by_curvature, "1 / w, w^2 = <laplacian of U / m> / 3")
        };
        let speed = (state.v.iter().map(|v| v.norm_squared()).sum::<f64>() / state.len().max(1) as f64).sqrt();
        let bounds = [
            (FASTEST_TIMES / squared.sqrt(), how),
            (
                self.program.pair.largest_cutoff() / speed,
                "a seventh of the time in which an atom flies as far as the cutoff",
            ),
            (MOST_STEPS * self.program.timestep, "a seventh of 1000 steps, as forces are weak"),
        ];
        let usable = bounds.into_iter().filter(|(span, _)| span.is_finite() && *span > 0.0);
        let (span, how) = usable.min_by(|a, b| a.0.total_cmp(&b.0)).expect("steps have a length");
        if squared == 0.0 && speed == 0.0 {
            return Ok(Pace { span: 80.0 * self.program.timestep, fastest: None, how: "" });
        }
        Ok(Pace { span, fastest: Some(span / FASTEST_TIMES), how })
    }
}
