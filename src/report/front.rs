//! Points of error and time together: which of them no other beats in both, and what to advise.

use super::measure::{ENERGIES, FORCES, MISSING, SPEEDS, TRAJECTORIES};
use super::store::{Record, Store};
use crate::bench::Spread;

/// A point with all that was measured of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    pub potential: String,
    pub integrator: String,
    pub precision: String,
    /// Time units.
    pub dt: f64,
    /// Length units.
    pub skin: f64,
    pub rebuild: String,
    /// Wall seconds for a time unit.
    pub time: Spread,
    /// RMS distance from the reference trajectory, length units.
    pub trajectory: Option<f64>,
    /// Of the continuous energy, energy units per atom.
    pub fluctuation: Option<f64>,
    /// Of the continuous energy, energy units per atom and time unit, and its standard error.
    pub drift: Option<(f64, f64)>,
    /// RMS force error over the RMS force.
    pub force: Option<f64>,
    /// Part of the pairs within the cutoff that the lists lack.
    pub missing: Option<f64>,
    pub fault: String,
    /// No other point is both faster and more exact.
    pub front: bool,
}

/// The policy whose errors do not depend on the skin, as no list lacks a pair.
pub const SAFE: &str = "every 1 delay 0 check yes";

/// All points that were timed, those on the front marked; each potential has a front of its own.
pub fn points(store: &Store) -> Vec<Found> {
    let mut found: Vec<Found> = Vec::new();
    let mut times: Vec<Vec<f64>> = Vec::new();
    for row in store.rows(&SPEEDS) {
        let number = |column| row.number(column).unwrap_or(f64::NAN);
        let of = Found {
            potential: row.text("potential").into(),
            integrator: row.text("integrator").into(),
            precision: row.text("precision").into(),
            dt: number("dt"),
            skin: number("skin"),
            rebuild: row.text("rebuild").into(),
            ..Found::default()
        };
        let place = found.iter().position(|other| other.is_same(&of)).unwrap_or_else(|| {
            found.push(of);
            times.push(Vec::new());
            found.len() - 1
        });
        times[place].extend(row.number("seconds_per_time"));
        if found[place].fault.is_empty() {
            found[place].fault = row.text("fault").into();
        }
    }
    for (point, times) in found.iter_mut().zip(&times) {
        if !times.is_empty() {
            point.time = Spread::of(times);
        }
        point.join(store);
    }
    mark(&mut found);
    found
}

impl Found {
    fn is_same(&self, other: &Self) -> bool {
        let names = |of: &Self| [&of.potential, &of.integrator, &of.precision, &of.rebuild].map(String::clone);
        names(self) == names(other) && (self.dt, self.skin) == (other.dt, other.skin)
    }

    /// Whether a row of errors is of this point.
    fn is_of(&self, row: &Record<'_>, any_skin: bool) -> bool {
        let text = |column: &str, own: &str| row.text(column) == own;
        text("potential", &self.potential)
            && text("integrator", &self.integrator)
            && text("rebuild", &self.rebuild)
            && row.number("dt") == Some(self.dt)
            && (any_skin && self.rebuild == SAFE || row.number("skin") == Some(self.skin))
    }

    fn join(&mut self, store: &Store) {
        let precision = self.precision.clone();
        let own = |row: &Record<'_>| row.text("precision") == precision;
        if let Some(row) = store.rows(&TRAJECTORIES).find(|row| own(row) && self.is_of(row, true)) {
            self.trajectory = row.number("rms_error");
            self.add_fault(row.text("fault"));
        }
        if let Some(row) = store.rows(&ENERGIES).find(|row| own(row) && self.is_of(row, true)) {
            self.fluctuation = row.number("fluctuation");
            self.drift = row.number("drift").zip(row.number("drift_error"));
            self.add_fault(row.text("fault"));
        }
        // Lists are the same in every precision but for pairs that rounding decides.
        let of_list = Found { potential: "own".into(), integrator: "own".into(), ..self.clone() };
        if let Some(row) = store.rows(&MISSING).find(|row| of_list.is_of(row, false)) {
            self.missing = row.number("missing").zip(row.number("pairs")).map(|(m, all)| m / all.max(1.0));
        }
        let forces = store.rows(&FORCES).find(|row| own(row) && row.text("potential") == self.potential);
        self.force = forces.and_then(|row| row.number("force_error_rms"));
    }

    fn add_fault(&mut self, fault: &str) {
        if self.fault.is_empty() {
            self.fault = fault.into();
        }
    }

    /// Whether it is measured in full and lacks no pair.
    pub fn is_sound(&self) -> bool {
        self.fault.is_empty() && self.time.median > 0.0 && self.missing.is_none_or(|missing| missing == 0.0)
    }
}

fn mark(found: &mut [Found]) {
    let charts: Vec<String> = found.iter().map(|p| p.potential.clone()).collect();
    for k in 0..found.len() {
        let others: Vec<usize> = (0..found.len())
            .filter(|m| charts[*m] == charts[k] && found[*m].is_sound() && found[*m].trajectory.is_some())
            .collect();
        let pairs: Vec<(f64, f64)> =
            others.iter().map(|m| (found[*m].time.median, found[*m].trajectory.unwrap_or(f64::NAN))).collect();
        let front = others.iter().position(|m| *m == k).is_some_and(|place| pareto(&pairs)[place]);
        found[k].front = front;
    }
}

/// Errors that differ by less are alike to the front.
const ALIKE: f64 = 1.01;

/// Which points of time and error no other beats: none is faster at the same error (to a hundredth) or a smaller one.
pub fn pareto(points: &[(f64, f64)]) -> Vec<bool> {
    let beats = |a: &(f64, f64), b: &(f64, f64)| a.0 < b.0 && a.1 <= ALIKE * b.1 || a.0 == b.0 && a.1 < b.1;
    points.iter().map(|point| !points.iter().any(|other| beats(other, point))).collect()
}

/// Errors that differ by less than this are the same: that of the trajectory and the fluctuation of the energy depend on where the run
/// happens to begin.
const SAME: f64 = 1.05;
/// An advice is worth it from here on.
const FASTER: f64 = 1.05;

/// The fastest point whose errors are at most those of another: the trajectory's, the fluctuation and, beyond its scatter, the drift of
/// the energy; it lacks no pair. `None` where none is faster by a twentieth.
pub fn better<'a>(points: &'a [Found], than: &Found) -> Option<&'a Found> {
    let no_worse = |point: &&Found| {
        let at_most = |a: Option<f64>, b: Option<f64>| matches!((a, b), (Some(a), Some(b)) if a <= SAME * b);
        let drifts = match (point.drift, than.drift) {
            (Some((a, scatter)), Some((b, other))) => a.abs() <= SAME * b.abs() + 2.0 * (scatter + other),
            _ => false,
        };
        point.is_sound()
            && (&point.potential, &point.integrator) == (&than.potential, &than.integrator)
            && at_most(point.trajectory, than.trajectory)
            && at_most(point.fluctuation, than.fluctuation)
            && drifts
    };
    let fastest = points.iter().filter(no_worse).min_by(|a, b| a.time.median.total_cmp(&b.time.median));
    fastest.filter(|point| point.time.median * FASTER < than.time.median)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [(1.0, 5.0), (2.0, 3.0), (2.0, 4.0), (3.0, 3.0), (4.0, 1.0), (5.0, 2.0)];
        assert_eq!(pareto(&points), [true, true, false, false, true, false]);
        // A hundredth is no error to wait for.
        assert_eq!(pareto(&[(1.0, 1.005), (2.0, 1.0), (3.0, 0.9)]), [true, false, true]);
        // Of two that are alike neither beats the other.
        assert_eq!(pareto(&[(1.0, 1.0), (1.0, 1.0)]), [true, true]);
        assert_eq!(pareto(&[]), [false; 0]);
    }

    fn point(time: f64, trajectory: f64, drift: f64) -> Found {
        Found {
            time: Spread::of(&[time]),
            trajectory: Some(trajectory),
            fluctuation: Some(trajectory),
            drift: Some((drift, 0.1)),
            ..Found::default()
        }
    }

    #[test]
    fn advice_is_the_fastest_that_is_no_worse() {
        let own = point(10.0, 1.0, 0.2);
        let faster = point(6.0, 1.04, -0.5);
        let lacking = Found { missing: Some(1e-6), ..point(4.0, 0.5, 0.0) };
        let broken = Found { fault: "step 3".into(), ..point(4.0, 0.5, 0.0) };
        let shifted = Found { potential: "force-shifted".into(), ..point(3.0, 0.1, 0.0) };
        let all = [own.clone(), point(5.0, 1.06, 0.0), point(5.0, 1.0, 0.7), faster.clone(), lacking, broken, shifted];
        assert_eq!(better(&all, &own), Some(&faster));
        assert_eq!(better(&[own.clone(), faster.clone()], &faster), None);
        // Four per cent faster is no news.
        assert_eq!(better(&[point(9.6, 1.0, 0.0)], &own), None);
    }
}
