//! Launches, and what the host does between them.

use std::ffi::c_void;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::compiled::Compiled;
use super::engine::Engine;
use super::layout::*;
use crate::engine::backend::{Reached, Stop};
use crate::engine::observer::{Needs, Sums};

/// Wall seconds that a launch may take, so that an interrupted run stops soon.
const LAUNCH_SECONDS: f64 = 0.1;

/// Builds that one series of launches is ready for.
const MOST_BUILDS: f64 = 64.0;

/// Part of the usual time between builds after which another one is reckoned with.
const EARLY: f64 = 0.7;

/// Room in rows beyond what was asked for when they grow.
const GROWTH: f64 = 1.1;

impl Engine {
    /// Runs steps in launches of bounded length; what `needs` asks for is computed at the last step.
    pub fn advance(&mut self, steps: u64, needs: Needs, stop: &AtomicBool) -> Result<Reached, Stop> {
        self.ask(needs);
        let (mut left, mut begin) = (steps, BEGIN_MOVE);
        while left > 0 {
            let now = left.min(self.steps_in_launch());
            let end = now == left;
            // What thermostats keep is read between launches, of the step that is behind.
            let moves_on = !end && self.thermostats.is_empty();
            let (sums, finish, goes_on) = ((end && needs.sums()).into(), end.into(), moves_on.into());
            let clock = Instant::now();
            (self.control.left, self.control.begin) = (now, begin);
            self.go(Order { sums, finish, goes_on, ..Order::default() })?;
            self.seconds_per_step = clock.elapsed().as_secs_f64() / now as f64;
            left -= now;
            begin = if moves_on { BEGIN_MOVED } else { BEGIN_MOVE };
            if stop.load(Ordering::Relaxed) {
                return self.interrupt(end && needs.sums());
            }
        }
        Ok(Reached::End)
    }

    /// Notes which sums are wanted; where none are, those of before still stand.
    pub(super) fn ask(&mut self, needs: Needs) {
        if needs.sums() {
            self.tensor = needs.virial || !needs.pressure;
        }
    }

    /// Steps of a launch that takes as long as one may.
    pub(super) fn steps_in_launch(&self) -> u64 {
        let bound = if self.seconds_per_step > 0.0 { LAUNCH_SECONDS / self.seconds_per_step } else { 8.0 };
        (bound as u64).max(1)
    }

    /// Ends at the current step, or the next one where particles are on their way to it, all of whose sums whoever looks at it
    /// may want; they may be there.
    pub(super) fn interrupt(&mut self, summed: bool) -> Result<Reached, Stop> {
        self.tensor = true;
        if self.control.begin == BEGIN_MOVED {
            self.control.left = 1;
            self.go(Order { sums: 1, finish: 1, ..Order::default() })?;
        } else if !summed {
            self.control.begin = BEGIN_FORCE;
            self.go(Order { sums: 1, finish: 1, ..Order::default() })?;
        }
        Ok(Reached::Interrupted)
    }

    /// Goes through the steps that are left, from where the control says, whatever the host has to do in between.
    pub(super) fn go(&mut self, order: Order) -> Result<(), Stop> {
        loop {
            self.launch(&order)?;
            let Control { trouble, begin, .. } = self.control;
            self.losing &= trouble != 0;
            if trouble == 0 && (begin == BEGIN_END || begin == BEGIN_MOVED) {
                return Ok(());
            }
            if trouble == 0 {
                continue;
            }
            if trouble & TROUBLE_BOUNDS != 0 {
                // A part of every build.
                if self.follow_bounds(order)? {
                    continue;
                }
                return Ok(());
            }
            self.losing = self.lose()?;
            if self.losing {
                continue;
            }
            self.redone += 1;
            if trouble & TROUBLE_CAPACITY != 0 {
                let wanted = (f64::from(self.control.wanted) * GROWTH) as u32 + 8;
                self.set_capacity(wanted);
                let n = self.control.n as usize;
                for name in ["inner", "list"] {
                    self.memory.renew(name, &self.compiler.device, &self.plan.shape, &self.sizes, n)?;
                }
            } else if trouble & TROUBLE_FORCE != 0 {
                return self.force_fault();
            } else if trouble & TROUBLE_RANGE != 0 {
                self.fall_back()?;
            } else if trouble & TROUBLE_RUNS != 0 {
                self.long_runs = true;
                let particles = self.read_particles(true)?;
                return self.build_from(particles, order);
            } else {
                let particles = self.read_particles(true)?;
                return self.build_from(particles, order);
            }
        }
    }

    /// Launches kernels in the order of steps until all is done, the host has to act, or there were more builds than expected;
    /// a kernel that is not asked for ends at once.
    fn launch(&mut self, order: &Order) -> Result<(), String> {
        self.compiler.device.bind()?;
        if order.record_stride != 0 {
            self.prepare_recording(self.tensor)?;
        }
        let device = &self.compiler.device;
        let control = self.memory.get("control");
        (self.control.wanted, self.control.trouble) = (0, 0);
        (self.control.turn, self.control.barrier, self.control.met) = (0, [0; 2], [0; 2]);
        (self.control.sort_trouble, self.control.lost, self.control.marks) = (0, 0, [0; MARKS as usize]);
        (self.control.recorded, self.summed) = (0, false);
        if self.control.begin == BEGIN_LIST {
            (self.control.entries, self.control.tests, self.control.taken) = (0, 0, 0);
        }
        let before = self.control;
        control.write(0, &[self.control])?;
        let (table, scene) = (self.memory.table.as_ptr(), &self.plan.scene as *const Scene);
        let parameters = [table.cast::<c_void>(), scene.cast(), (order as *const Order).cast()];
        let Compiled { advance, sort, list, conclude, recording, .. } = &self.compiled;
        let recording = recording.as_ref().filter(|_| order.record_stride != 0);
        let advance = recording.map_or(advance, |recording| &recording.advance);
        // Where one is lost another soon is, and kernels after that build would be launched for nothing.
        let most = if self.losing { 1 } else { MOST_BUILDS as u64 };
        for _ in 0..expected_builds(&before, before.step - self.counting_from).min(most) {
            advance.go(&parameters)?;
            sort.go(&parameters)?;
            list.go(&parameters)?;
        }
        advance.go(&parameters)?;
        if let Some(recording) = recording {
            recording.sum.go(&parameters)?;
        }
        // Where there is nothing else to do, kinetic sums are asked for.
        let concludes = order.sums != 0 || order.finish != 0 || before.begin == BEGIN_END;
        if concludes {
            conclude.go(&parameters)?;
        }
        device.wait()?;
        self.control = control.read(0, 1)?[0];
        self.read_baths()?;
        let sorted = self.control.trouble & (TROUBLE_POSITION | TROUBLE_LOST | TROUBLE_GRID) == 0;
        self.built |= sorted;
        if self.control.builds != before.builds || (sorted && before.begin == BEGIN_BUILD) {
            self.held_box.clone_from(&self.simulation_box);
            self.held_step = self.control.step - self.control.ago as i64;
        }
        if concludes && self.control.trouble == 0 && self.control.begin == BEGIN_END {
            // Without a set-up, energy and virial of the last run still stand.
            let from = if order.sums != 0 { 0 } else { TOTALS as usize };
            self.sums[from..].copy_from_slice(&self.control.sums[from..]);
            self.summed = true;
        }
        self.read_records()
    }

    /// Sums of the current step; energy and virial as the last launch that was asked for them left them.
    pub fn sums(&mut self) -> Result<Sums, String> {
        if !self.summed {
            // Velocities may be others than a run left behind.
            self.compiler.device.bind()?;
            (self.control.left, self.control.begin) = (0, BEGIN_END);
            self.go(Order::default()).map_err(|stop| stop.to_string())?;
        }
        Ok(self.sums_of(&self.sums))
    }
}

/// Builds to be ready for in the steps that are left, `steps` after the set-up from which on they are counted.
fn expected_builds(control: &Control, steps: i64) -> u64 {
    let Control { begin, left, builds, ago, .. } = *control;
    // One more than there were: a run that has had none may yet have its first.
    let each = ((builds + 1) as f64 / steps.max(1) as f64).min(1.0);
    // They come at much the same intervals. Right after one, three kernels that end at once would cost a short launch more
    // than the rare one that has to be launched again.
    let soon = (ago + left) as f64 * each >= EARLY;
    let more = if soon { (left as f64 * each * 1.1).ceil().min(left as f64).min(MOST_BUILDS) as u64 } else { 0 };
    more + u64::from(begin == BEGIN_BUILD || begin == BEGIN_LIST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn builds_are_expected_where_they_are_due() {
        let expected = |builds, steps, ago, left, begin| {
            expected_builds(&Control { builds, ago, left, begin, ..Control::default() }, steps)
        };
        // One in ten steps: none right after one, one when it is due, all of a long launch.
        assert_eq!(expected(99, 1000, 2, 1, BEGIN_MOVE), 0);
        assert_eq!(expected(99, 1000, 8, 1, BEGIN_MOVE), 1);
        assert_eq!(expected(99, 1000, 0, 100, BEGIN_MOVE), 11);
        assert_eq!(expected(99, 1000, 0, 100_000, BEGIN_MOVE), MOST_BUILDS as u64);
        // The one that is under way, and no other where nothing is left.
        assert_eq!(expected(99, 1000, 10, 0, BEGIN_LIST), 1);
        // Nothing is known at the start; later that there are none.
        assert_eq!(expected(0, 0, 0, 8, BEGIN_MOVE), 8);
        assert_eq!(expected(0, 10_000, 10_000, 100, BEGIN_MOVE), 1);
    }
}
