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

/// Room in rows beyond what was asked for when they grow.
const GROWTH: f64 = 1.1;

impl Engine {
    /// Runs steps in launches of bounded length; what `needs` asks for is computed at the last step.
    pub fn advance(&mut self, steps: u64, needs: Needs, stop: &AtomicBool) -> Result<Reached, Stop> {
        let mut left = steps;
        while left > 0 {
            let bound = if self.seconds_per_step > 0.0 { LAUNCH_SECONDS / self.seconds_per_step } else { 8.0 };
            let now = left.min((bound as u64).max(1));
            let end = now == left;
            let (sums, finish) = ((end && needs.sums()).into(), end.into());
            let clock = Instant::now();
            (self.control.left, self.control.begin) = (now, BEGIN_MOVE);
            self.go(Order { sums, finish, set_up: 0 })?;
            self.seconds_per_step = clock.elapsed().as_secs_f64() / now as f64;
            left -= now;
            if stop.load(Ordering::Relaxed) {
                if !(end && needs.energy && needs.virial) {
                    // Whoever looks at the last step may want its sums.
                    self.control.begin = BEGIN_FORCE;
                    self.go(Order { sums: 1, finish: 1, set_up: 0 })?;
                }
                return Ok(Reached::Interrupted);
            }
        }
        Ok(Reached::End)
    }

    /// Goes through the steps that are left, from where the control says, whatever the host has to do in between.
    pub(super) fn go(&mut self, order: Order) -> Result<(), Stop> {
        loop {
            self.launch(&order)?;
            let Control { trouble, begin, .. } = self.control;
            if trouble == 0 && begin == BEGIN_END {
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
        let device = &self.compiler.device;
        device.bind()?;
        let control = self.memory.get("control");
        (self.control.wanted, self.control.trouble) = (0, 0);
        (self.control.turn, self.control.barrier, self.control.met) = (0, [0; 2], [0; 2]);
        (self.control.sort_trouble, self.control.marks) = (0, [0; MARKS as usize]);
        if self.control.begin == BEGIN_LIST {
            (self.control.entries, self.control.tests, self.control.taken) = (0, 0, 0);
        }
        let before = self.control;
        control.write(0, &[self.control])?;
        let (table, scene) = (self.memory.table.as_ptr(), &self.plan.scene as *const Scene);
        let parameters = [table.cast::<c_void>(), scene.cast(), (order as *const Order).cast()];
        let Compiled { advance, sort, list, conclude, .. } = &self.compiled;
        for _ in 0..self.expected_builds() {
            advance.go(&parameters)?;
            sort.go(&parameters)?;
            list.go(&parameters)?;
        }
        advance.go(&parameters)?;
        if order.sums != 0 || order.finish != 0 {
            conclude.go(&parameters)?;
        }
        device.wait()?;
        self.control = control.read(0, 1)?[0];
        let sorted = self.control.trouble & (TROUBLE_POSITION | TROUBLE_LOST | TROUBLE_GRID) == 0;
        self.built |= sorted;
        if self.control.builds != before.builds || (sorted && before.begin == BEGIN_BUILD) {
            self.held_box.clone_from(&self.simulation_box);
            self.held_step = self.control.step - self.control.ago as i64;
        }
        if order.sums != 0 && self.control.trouble == 0 && self.control.begin == BEGIN_END {
            self.pair_sums = self.block_sums(self.compiled.conclude.blocks)?;
        }
        Ok(())
    }

    /// Builds to be ready for in the steps that are left.
    fn expected_builds(&self) -> u64 {
        let Control { begin, left, builds, .. } = self.control;
        let steps = (self.control.step - self.counting_from).max(1) as f64;
        let each = if builds > 0 { builds as f64 / steps } else { 1.0 };
        let more = (left as f64 * each * 1.1).ceil().min(left as f64).min(MOST_BUILDS) as u64;
        more + u64::from(begin == BEGIN_BUILD || begin == BEGIN_LIST)
    }

    pub fn sums(&mut self) -> Result<Sums, String> {
        let device = &self.compiler.device;
        device.bind()?;
        let (table, scene) = (self.memory.table.as_ptr(), &self.plan.scene as *const Scene);
        self.compiled.kinetic.go(&[table.cast::<c_void>(), scene.cast()])?;
        device.wait()?;
        let kinetic = self.block_sums(self.compiled.kinetic.blocks)?;
        let (scene, energy) = (&self.plan.scene, self.plan.energy);
        // Every pair stands in two rows.
        Ok(Sums {
            kinetic: std::array::from_fn(|k| kinetic[k]),
            potential: 0.5 * energy * self.pair_sums[0],
            virial: std::array::from_fn(|k| 0.5 * scene.force_unit * self.plan.unit * self.pair_sums[k + 1]),
        })
    }
}
