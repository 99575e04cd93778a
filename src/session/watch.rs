//! Signs that the timestep is too large, looked for while a run goes on: at its outputs, and at a few steps that are asked for.
//! Nothing is worked out at the steps between.
//!
//! Three signs, each told once a run. *Strides*: the fastest particle goes farther than half the skin in a step, or its collisions
//! are too hard for the timestep (`engine/stride`). *Energy*: where nothing but the timestep changes the total energy, it is
//! not what it was. *Temperature*: it has doubled, and more than half of the kinetic energy has come from nowhere. What plain
//! truncation can do is allowed for: the energy of a pair at the cutoff, for every pair there is.

use std::sync::Arc;

use super::energies::{Energy, Look};
use crate::engine::{GoodState, Needs, NeighborStatistics, Program, Stride, Sums, shorter_timestep};
use crate::output::printf::format_g;
use crate::system::{SimulationBox, State};

/// Steps between two looks of its own, in the long run. After the start of a run they come sooner: after 1, 4, 16 steps and so on.
const LONGEST: i64 = 1 << 14;

/// What the total energy may be off by, in the largest kinetic energy so far. A liquid in equilibrium stays below a hundredth up
/// to the timestep at which it breaks (the energy of velocity Verlet differs from the one it keeps by dt^2 / 24 times the mean
/// squared frequency); one spring alone reaches it at omega dt = 0.6.
const ENERGY: f64 = 0.1;

/// A temperature that has grown by this factor is looked at.
const HOTTER: f64 = 2.0;

/// How much of the kinetic energy has to have no source for the temperature to have jumped.
const SOURCELESS: f64 = 0.5;

/// A state that nobody has looked at is taken for a good one where its energy is off by this part of what calls for a warning.
const TRUSTED: f64 = 0.25;

/// Particles are kept at own steps from this one of a run on, where bringing them from the engine takes no time worth mentioning
/// beside what the steps between take.
const KEPT_FROM: i64 = 1 << 12;

/// Collisions are reckoned anew for a particle so much faster than the last.
const FASTER: f64 = 1.05;

/// Rounding of energies in single precision, generously, in potential energies.
const ROUNDING: f64 = 1e-4;

/// Watches one run.
pub struct Watch {
    program: Arc<Program>,
    first_step: i64,
    goes_on: bool,
    energy: Energy,
    /// U(cutoff) of the pair of types that has most of it.
    at_cutoff: f64,
    first: Option<Look>,
    before: Option<Look>,
    /// The most so far.
    kinetic: f64,
    /// Kinetic energy when particles were last looked at.
    kinetic_seen: f64,
    dangerous: u64,
    /// Particles are not brought from the engine for a mere suspicion before this step.
    patience: i64,
    /// Signs found, waiting for the particles that the words need.
    found: Vec<String>,
    told_stride: bool,
    told_energy: bool,
    told_temperature: bool,
    /// What the fastest particle may go in a step: it has been found fine for collisions.
    fine: f64,
    /// The first timestep that was proposed: later states are spoiled by the one that the run has.
    proposed: Option<f64>,
    /// States up to this step have passed all checks.
    clean: i64,
    /// Step of the first sign found after the start of the run.
    sign: Option<i64>,
    /// Step of the first jump of the energy or the temperature.
    alarm: Option<i64>,
}

impl Watch {
    /// `goes_on`: the run continues another one without set-up, so that nothing new is to be expected.
    pub fn new(program: Arc<Program>, first_step: i64, goes_on: bool) -> Self {
        let energy = if program.moves() { Energy::of(&program) } else { Energy::Open };
        let pairs = program.pair.pairs.iter().filter(|pair| pair.cutoff > 0.0 && !program.pair.shift);
        let at_cutoff = pairs.map(|pair| pair.energy_at_cutoff.abs()).fold(0.0, f64::max);
        Self {
            program,
            first_step,
            goes_on,
            energy,
            at_cutoff,
            first: None,
            before: None,
            kinetic: 0.0,
            kinetic_seen: f64::INFINITY,
            dangerous: 0,
            patience: first_step,
            found: Vec::new(),
            told_stride: false,
            told_energy: false,
            told_temperature: false,
            fine: 0.0,
            proposed: None,
            clean: first_step,
            sign: None,
            alarm: None,
        }
    }

    /// The next step after `now` that it wants to see.
    pub fn next(&self, now: i64) -> i64 {
        if !self.program.moves() {
            return i64::MAX;
        }
        let done = now - self.first_step;
        let next = if self.goes_on || done >= LONGEST {
            (done / LONGEST + 1) * LONGEST
        } else {
            (0..).map(|k| 1 << (2 * k)).find(|steps| *steps > done).unwrap_or(LONGEST)
        };
        self.first_step.saturating_add(next)
    }

    /// What it wants computed there.
    pub fn needs(&self) -> Needs {
        Needs { energy: self.energy != Energy::Open, ..Needs::default() }
    }

    /// The energy has jumped: states from here on are not to be relied upon.
    pub fn is_alarmed(&self) -> bool {
        self.alarm.is_some()
    }

    /// Step at which that was found.
    pub fn alarm(&self) -> Option<i64> {
        self.alarm
    }

    /// Whether the state of a step has passed all checks.
    pub fn is_clean(&self, step: i64) -> bool {
        step <= self.clean || (self.energy == Energy::Open && self.sign.is_none_or(|sign| step < sign))
    }

    /// Whether this is a step whose particles are to be kept: one of its own that are far apart.
    pub fn keeps(&self, step: i64) -> bool {
        step - self.first_step >= KEPT_FROM && self.sign.is_none() && self.next(step - 1) == step
    }

    /// Whether a particle gives no sign.
    pub fn is_calm(&self, stride: &Stride, state: &State) -> bool {
        let as_fine = stride.distance <= self.fine || stride.coarse(&self.program, state).is_none();
        as_fine && !stride.leaves_skin(&self.program)
    }

    /// Whether energies of an earlier step are well within what calls for a warning; nothing is remembered.
    pub fn accepts(&self, step: i64, sums: &Sums, atoms: usize, neighbors: &NeighborStatistics) -> bool {
        let Some(first) = self.first.filter(|_| sums.broken().is_none()) else { return false };
        let now = Look::at(&self.program, step, sums, atoms, neighbors);
        match self.energy {
            Energy::Stays => now.change(&first).abs() <= TRUSTED * self.allowed(&first, &now),
            Energy::Bath(_) => {
                let before = self.before.unwrap_or(first);
                let hot = now.temperature > self.hottest(&before);
                !hot || now.change(&before) <= TRUSTED * self.sourceless(&before, &now)
            }
            Energy::Open => true,
        }
    }

    /// The timestep that was proposed first.
    pub fn proposed(&self) -> Option<f64> {
        self.proposed
    }

    /// Atoms have gone: energies before and after cannot be compared.
    pub fn forget(&mut self) {
        (self.first, self.before, self.kinetic) = (None, None, 0.0);
    }

    /// Looks at sums with energy, of so many atoms.
    pub fn see(&mut self, step: i64, sums: &Sums, atoms: usize, neighbors: &NeighborStatistics) {
        if self.energy == Energy::Open || sums.broken().is_some() {
            return;
        }
        let now = Look::at(&self.program, step, sums, atoms, neighbors);
        self.kinetic = self.kinetic.max(now.kinetic);
        if let (Some(first), Some(before)) = (self.first, self.before) {
            self.judge_energy(&first, &now);
            self.judge_temperature(&before, &now);
        } else {
            self.kinetic_seen = now.kinetic;
        }
        self.first.get_or_insert(now);
        self.before = Some(now);
        if !self.found.is_empty() {
            self.sign = self.sign.or(Some(step));
            self.alarm = self.alarm.or(Some(step));
        } else if self.sign.is_none() {
            self.clean = step;
        }
    }

    /// What the total energy may be off by.
    fn allowed(&self, first: &Look, now: &Look) -> f64 {
        ENERGY * self.kinetic + self.noise(first, now)
    }

    /// A temperature above this is looked at.
    fn hottest(&self, before: &Look) -> f64 {
        let bath = if let Energy::Bath(t) = self.energy { t } else { 0.0 };
        HOTTER * before.temperature.max(bath)
    }

    /// What the total energy may have risen by where it is.
    fn sourceless(&self, before: &Look, now: &Look) -> f64 {
        SOURCELESS * now.kinetic + self.noise(before, now)
    }

    /// What truncation and rounding may change the energy by.
    fn noise(&self, before: &Look, now: &Look) -> f64 {
        let size = before.potential.abs().max(now.potential.abs());
        self.at_cutoff * before.pairs.max(now.pairs) as f64 + ROUNDING * size
    }

    fn judge_energy(&mut self, first: &Look, now: &Look) {
        let change = now.change(first);
        if self.told_energy || self.energy != Energy::Stays || change.abs() <= self.allowed(first, now) {
            return;
        }
        self.told_energy = true;
        let (way, part) = (if change > 0.0 { "risen" } else { "fallen" }, short(100.0 * change.abs() / self.kinetic));
        self.found.push(format!(
            "step {}: since step {} the total energy, which should stay, has {way} by {} ({part} % of the kinetic energy){}",
            now.step,
            first.step,
            short(change.abs()),
            self.lists()
        ));
    }

    fn judge_temperature(&mut self, before: &Look, now: &Look) {
        if self.told_temperature
            || now.temperature <= self.hottest(before)
            || now.change(before) <= self.sourceless(before, now)
        {
            return;
        }
        self.told_temperature = true;
        self.found.push(format!(
            "step {}: since step {} the temperature has jumped from {} to {}, which nothing in the scene accounts for{}",
            now.step,
            before.step,
            short(before.temperature),
            short(now.temperature),
            self.lists()
        ));
    }

    /// What else than the timestep may be the reason.
    fn lists(&self) -> &'static str {
        let policy = &self.program.policy;
        if policy.once || !policy.check { " (lists that are not checked may lack pairs, too)" } else { "" }
    }

    /// Whether particles should be brought from the engine.
    pub fn asks_for_particles(&self, step: i64, neighbors: &NeighborStatistics) -> bool {
        let hotter = self.before.is_some_and(|now| now.kinetic > HOTTER * self.kinetic_seen);
        let suspicious = hotter || neighbors.dangerous.is_some_and(|n| n > self.dangerous);
        !self.found.is_empty() || (suspicious && !self.told_stride && step >= self.patience)
    }

    /// Looks at particles; what is to be told. `good` is the latest state of the run that has passed all checks, if it is another.
    pub fn look(
        &mut self,
        step: i64,
        state: &State,
        good: Option<&GoodState>,
        simulation_box: &SimulationBox,
        neighbors: &NeighborStatistics,
    ) -> Vec<String> {
        self.dangerous = neighbors.dangerous.unwrap_or(0);
        self.patience = step + 2 * (step - self.first_step);
        if let Some(now) = self.before {
            self.kinetic_seen = now.kinetic;
        }
        let found = std::mem::take(&mut self.found);
        let Some(stride) = Stride::fastest(&self.program, state) else { return found };
        let program = self.program.clone();
        let leaves = stride.leaves_skin(&program);
        let looks = !self.told_stride && stride.distance > self.fine;
        let coarse = if looks { stride.coarse(&program, state) } else { None };
        if looks && coarse.is_none() {
            self.fine = FASTER * stride.distance;
        }
        let tells = !self.told_stride && (leaves || coarse.is_some());
        if found.is_empty() && !tells {
            return found;
        }
        let nearest = stride.nearest(state, simulation_box);
        if self.proposed.is_none() {
            let now = || GoodState { step, state: state.clone(), simulation_box: simulation_box.clone() };
            let before = good.and_then(|good| shorter_timestep(&program, good, Some(stride.id)));
            // What the energy has jumped into says little of a timestep; a mere stride does.
            self.proposed = match before {
                Some(before) if !found.is_empty() => Some(before),
                _ => before.into_iter().chain(shorter_timestep(&program, &now(), None)).reduce(f64::min),
            };
        }
        if step > self.first_step && self.sign.is_none() {
            self.sign = Some(step);
            self.clean = self.clean.min(step - 1);
        }
        let end = self.end(nearest);
        let goes = format!("goes {} in a timestep", short(stride.distance));
        let fastest = format!("; the fastest is atom {}, which {goes}{end}", stride.id);
        let mut told: Vec<String> = Vec::new();
        if tells {
            self.told_stride = true;
            let why = if leaves {
                format!("farther than half the skin ({})", short(0.5 * program.policy.skin))
            } else {
                format!("too far for its collisions (omega dt = {}, stable below 2)", short(coarse.unwrap_or(f64::NAN)))
            };
            told.push(format!("step {step}: atom {} {goes}, {why}{end}", stride.id));
        }
        told.extend(found.into_iter().map(|sign| sign + &fastest));
        told
    }

    /// Signs found, where there are no particles to name.
    pub fn take_found(&mut self) -> Vec<String> {
        std::mem::take(&mut self.found)
    }

    /// The neighbor and the timestep that would do.
    fn end(&self, nearest: Option<(u32, f64)>) -> String {
        let neighbor = nearest.map(|(id, r)| format!("; nearest to it is atom {id} at distance {}", short(r)));
        let timestep = self.proposed.map(|dt| format!("; {}", would_do(dt)));
        [neighbor, timestep].into_iter().flatten().collect()
    }
}

/// The proposal in words.
pub fn would_do(timestep: f64) -> String {
    format!("a timestep of {} would do", short(timestep))
}

pub fn short(x: f64) -> String {
    format_g(x, 0, 4, false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::{Settings, first_run};

    /// A watch of a scene with these fixes.
    fn watch(fixes: &str) -> Watch {
        let script = format!(
            "units lj\nregion b block 0 9 0 9 0 9\nlattice sc 1\ncreate_box 1 b\ncreate_atoms 1 single 1 1 1\n\
             mass 1 1\npair_style lj/cut 2.5\npair_coeff 1 1 1 1\n{fixes}run 1\n"
        );
        let program = first_run("scene", &script, &Settings::default()).unwrap().program;
        Watch::new(Arc::new(program), 100, false)
    }

    /// What there is to tell of potential and kinetic energies of 100 atoms, 1000 pairs in reach, one look after another.
    fn found(watch: &mut Watch, energies: &[(f64, f64)]) -> Vec<String> {
        for (k, (potential, kinetic)) in energies.iter().enumerate() {
            let kinetic = [2.0 * kinetic, 0.0, 0.0, 0.0, 0.0, 0.0];
            let sums = Sums { potential: *potential, kinetic, ..Sums::default() };
            let neighbors = NeighborStatistics { pairs: 1000, ..NeighborStatistics::default() };
            watch.see(100 + k as i64, &sums, 100, &neighbors);
        }
        watch.take_found()
    }

    #[test]
    fn looks_become_rare() {
        let at = |watch: &Watch, now| watch.next(now) - 100;
        let new = watch("fix 1 all nve\n");
        assert_eq!([100, 101, 103, 104, 116, 100 + 4096].map(|now| at(&new, now)), [1, 4, 4, 16, 64, 16384]);
        assert_eq!([16484, 16485, 40000].map(|now| at(&new, now)), [32768, 32768, 49152]);
        assert_eq!(at(&Watch { goes_on: true, ..watch("fix 1 all nve\n") }, 100), 16384);
        assert_eq!(watch("").next(100), i64::MAX);
    }

    #[test]
    fn an_energy_may_change_as_truncation_changes_it_and_a_little() {
        // 1000 pairs of U(2.5) = -0.016317; a tenth of the largest kinetic energy; rounding of the potential energy.
        let most = 16.317 + 20.0 + 0.05;
        let jump = |off: f64| found(&mut watch("fix 1 all nve\n"), &[(-500.0, 200.0), (-500.0 + off, 200.0)]);
        assert!(jump(most - 0.1).is_empty() && jump(0.1 - most).is_empty());
        let told = jump(most + 0.1);
        assert!(
            told[0]
                .starts_with("step 101: since step 100 the total energy, which should stay, has risen by 36.47 (18.2")
        );
        assert!(jump(-most - 0.1)[0].contains("has fallen by "));
        // Slowly all the same, and once.
        let slow: Vec<_> = (0..20).map(|k| (-500.0 + 5.0 * f64::from(k), 200.0)).collect();
        assert_eq!(found(&mut watch("fix 1 all nve\n"), &slow).len(), 1);
        assert!(found(&mut watch("fix 1 all nve\nfix 2 all gravity 1 vector 0 0 1\n"), &slow).is_empty());
    }

    #[test]
    fn a_temperature_may_double_where_something_pays_for_it() {
        let bath = |t: &str| watch(&format!("fix 1 all nve\nfix 2 all langevin {t} {t} 1.0 5\n"));
        // T = 1.35, then 4.
        let risen = [(-500.0, 200.0), (-500.0, 600.0)];
        assert_eq!(found(&mut bath("1.0"), &risen).len(), 1);
        assert!(found(&mut bath("2.5"), &risen).is_empty(), "the bath");
        assert!(found(&mut bath("1.0"), &[(-200.0, 200.0), (-500.0, 600.0)]).is_empty(), "the potential energy");
        assert_eq!(found(&mut watch("fix 1 all nve\n"), &risen).len(), 2, "energy and temperature");
    }
}
