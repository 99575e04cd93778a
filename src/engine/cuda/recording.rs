//! Runs over several outputs in one launch: the device records the sums of a step as it passes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::compiled::compile_recording;
use super::engine::Engine;
use super::layout::*;
use crate::engine::backend::{Reached, Stop};
use crate::engine::observer::{Needs, Record, Sums};

/// Wall seconds that outputs ahead have to cost before kernels are compiled for them. That takes about a second, but once for a
/// kind of scene: binaries are kept on disk.
const WORTH_COMPILING: f64 = 0.05;

/// Wall seconds that an output costs where it ends a launch, beside half a step: launches, copies, waiting.
const END_OF_LAUNCH: f64 = 1e-4;

/// Outputs, `stride` steps apart, that one launch of about so many steps goes to, where there are `count` ahead. The last of them
/// ends it, those before are recorded.
fn outputs_of_launch(steps: u64, stride: u64, count: u64) -> u64 {
    (steps / stride.max(1)).min(count).min(u64::from(MOST_RECORDS) + 1)
}

/// Whether kernels are to be compiled for so many outputs.
fn is_worth_compiling(count: u64, seconds_per_step: f64) -> bool {
    count as f64 * (END_OF_LAUNCH + 0.5 * seconds_per_step) > WORTH_COMPILING
}

impl Engine {
    /// Compiles what records outputs, where that is worth while as far as is known by now.
    pub fn expect_outputs(&mut self, (stride, count): (u64, u64), needs: Needs) -> Result<(), String> {
        if !self.thermostats.is_empty() {
            return Ok(());
        }
        let slow = self.seconds_per_step > 0.0 && self.steps_in_launch() < 2 * stride;
        if slow || !is_worth_compiling(count, self.seconds_per_step) {
            return Ok(());
        }
        self.prepare_recording(needs.virial)
    }

    /// As [`crate::engine::Backend::advance_recording`]: one launch, or up to the next output where a launch reaches no second
    /// one, or too few are ahead. Which of these it is depends on the clock, but does not show in any bit of the results: all
    /// kernels with sums add them up in the same order.
    pub fn advance_recording(
        &mut self,
        (stride, count): (u64, u64),
        needs: Needs,
        stop: &AtomicBool,
        records: &mut Vec<Record>,
    ) -> Result<Reached, Stop> {
        let outputs = outputs_of_launch(self.steps_in_launch(), stride, count);
        self.ask(needs);
        // What thermostats keep is not recorded.
        if outputs < 2
            || !self.thermostats.is_empty()
            || !(self.can_record(self.tensor) || is_worth_compiling(count, self.seconds_per_step))
        {
            return self.advance(stride, needs, stop);
        }
        self.prepare_recording(self.tensor)?;
        let (steps, stride) = (outputs * stride, stride as i64);
        let first = self.control.step + stride;
        (self.control.left, self.control.begin) = (steps, BEGIN_MOVE);
        let sums = needs.sums().into();
        let clock = Instant::now();
        let gone = self.go(Order { record_first: first, record_stride: stride, sums, finish: 1, ..Order::default() });
        // Whatever became of the rest, steps that have been recorded are behind.
        let passed = std::mem::take(&mut self.recorded).into_iter();
        records.extend((0..).zip(passed).map(|(k, sums)| Record { step: first + k * stride, sums }));
        gone?;
        self.seconds_per_step = clock.elapsed().as_secs_f64() / steps as f64;
        if stop.load(Ordering::Relaxed) {
            return self.interrupt(needs.sums());
        }
        Ok(Reached::End)
    }

    /// The kernels for it are there.
    fn can_record(&self, tensor: bool) -> bool {
        self.compiled.recording.as_ref().is_some_and(|recording| recording.tensor || !tensor)
    }

    /// Kernels that record, and room for what they leave; the scene may have got others since the last launch.
    pub(super) fn prepare_recording(&mut self, tensor: bool) -> Result<(), String> {
        self.compiler.device.bind()?;
        if !self.can_record(tensor) {
            let recording = compile_recording(&self.compiler, &self.program, &self.compiled, tensor)?;
            self.compiled.recording = Some(recording);
        }
        if self.sizes.records == 0 {
            self.sizes.records = MOST_RECORDS.into();
            let (device, shape, n) = (&self.compiler.device, &self.plan.shape, self.control.n as usize);
            self.memory.renew("record_sums", device, shape, &self.sizes, n)?;
            self.memory.renew("records", device, shape, &self.sizes, n)?;
        }
        Ok(())
    }

    /// Brings back what the last launch has recorded.
    pub(super) fn read_records(&mut self) -> Result<(), String> {
        const EACH: usize = SUMS as usize;
        let count = self.control.recorded as usize;
        if count > 0 {
            let all: Vec<f64> = self.memory.get("records").read(0, EACH * count)?;
            let sums: Vec<Sums> = all.chunks_exact(EACH).map(|sums| self.sums_of(sums)).collect();
            self.recorded.extend(sums);
        }
        Ok(())
    }

    /// Sums in the units of the scene, from those of the device.
    pub(super) fn sums_of(&self, sums: &[f64]) -> Sums {
        let (pairs, kinetic) = sums.split_at(TOTALS as usize);
        let plan = &self.plan;
        let third = [pairs[1] / 3.0, pairs[1] / 3.0, pairs[1] / 3.0, 0.0, 0.0, 0.0];
        // Every pair stands in two rows.
        let virial = |k: usize| {
            let sum = if self.tensor { pairs[k + PRESSURE_TOTALS as usize] } else { third[k] };
            0.5 * plan.scene.force_unit * (plan.unit / plan.scene.work_unit) * sum
        };
        Sums {
            kinetic: std::array::from_fn(|k| kinetic[k]),
            potential: 0.5 * plan.energy * pairs[0],
            virial: std::array::from_fn(virial),
            bath: self.bath(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_are_compiled_for_outputs_that_cost_time() {
        // A small scene has fast launches, a large one slow steps.
        assert!(!is_worth_compiling(100, 1e-5) && is_worth_compiling(1000, 1e-5));
        assert!(!is_worth_compiling(5, 1e-3) && is_worth_compiling(100, 1e-3));
    }

    #[test]
    fn a_launch_ends_at_an_output() {
        // As many as there is time for, as are ahead, as there is room for.
        assert_eq!(outputs_of_launch(100, 10, 1000), 10);
        assert_eq!(outputs_of_launch(109, 10, 1000), 10);
        assert_eq!(outputs_of_launch(100, 10, 3), 3);
        assert_eq!(outputs_of_launch(10_000, 1, u64::MAX), u64::from(MOST_RECORDS) + 1);
        // One alone is no reason to record, none even less.
        assert_eq!(outputs_of_launch(15, 10, 1000), 1);
        assert_eq!(outputs_of_launch(8, 10, 1000), 0);
    }
}
