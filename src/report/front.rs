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
    /// The same, round by round.
    pub rounds: Vec<(String, f64)>,
    /// Part of the pairs within the cutoff that the lists lack.
    pub missing: Option<f64>,
    /// At most, where that is 0: with 95 % confidence, three over the pairs looked at.
    pub missing_most: Option<f64>,
    pub fault: String,
    /// No other point is both faster and more exact.
    pub front: bool,
}

/// The policy whose errors do not depend on the skin, as no list lacks a pair.
pub const SAFE: &str = "every 1 delay 0 check yes";

/// All points that were timed, those on the front marked; each potential has a front of its own.
pub fn points(store: &Store) -> Vec<Found> {
    let mut found: Vec<Found> = Vec::new();
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
            found.len() - 1
        });
        let time = row.number("seconds_per_time").map(|time| (row.text("round").to_string(), time));
        found[place].rounds.extend(time);
        if found[place].fault.is_empty() {
            found[place].fault = row.text("fault").into();
        }
    }
    for point in &mut found {
        let times: Vec<f64> = point.rounds.iter().map(|(_, time)| *time).collect();
        if !times.is_empty() {
            point.time = Spread::of(&times);
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
    pub fn is_of(&self, row: &Record<'_>, any_skin: bool) -> bool {
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
            (self.missing, self.missing_most) = missing(&row);
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
        self.fault.is_empty() && self.time.median > 0.0 && self.lists() == Lists::Whole
    }

    /// Whether its energy drifts by more than a limit, beyond the error of the drift.
    pub fn drifts(&self, limit: f64) -> bool {
        self.drift.is_some_and(|(drift, error)| drift.abs() - 2.0 * error > limit)
    }

    pub fn lists(&self) -> Lists {
        match (self.missing, self.missing_most) {
            (Some(part), _) if part > 0.0 => Lists::Lack(part),
            _ if self.rebuild == SAFE => Lists::Whole,
            (_, Some(most)) if most <= FEW => Lists::Whole,
            (_, most) => Lists::Unsure(most.unwrap_or(1.0)),
        }
    }

    /// How many times as fast as another point it is, the mean of the rounds that both have, and whether that is beyond their scatter: in
    /// all of them, and by a one-sided paired t-test at 95 %.
    pub fn faster(&self, than: &Self) -> Option<(f64, bool)> {
        let other = |round: &String| than.rounds.iter().find(|(name, _)| name == round).map(|(_, time)| *time);
        let logs = self.rounds.iter().filter_map(|(round, time)| Some((other(round)? / time).ln()));
        let logs: Vec<f64> = logs.filter(|log| log.is_finite()).collect();
        let n = logs.len() as f64;
        let mean = logs.iter().sum::<f64>() / n;
        let error = (logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt();
        let t = STUDENT.get(logs.len().wrapping_sub(2)).copied().unwrap_or(STUDENT[STUDENT.len() - 1]);
        let sure = logs.len() > 1 && logs.iter().all(|log| *log > 0.0) && mean > t * error;
        (!logs.is_empty()).then(|| (mean.exp(), sure))
    }
}

/// What is known of the lists of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lists {
    /// They lack no pair, or so few that it takes a million to see one.
    Whole,
    /// This part of the pairs.
    Lack(f64),
    /// None was seen to be missing, but nothing was checked, and no more than this part is ruled out.
    Unsure(f64),
}

/// Part of the pairs within the cutoff that a row's lists lack, and the most that it may be where that is 0.
pub fn missing(row: &Record<'_>) -> (Option<f64>, Option<f64>) {
    let counted = row.number("missing").zip(row.number("pairs"));
    let most = counted.filter(|(missing, _)| *missing == 0.0).map(|(_, pairs)| unseen(pairs));
    (counted.map(|(missing, pairs)| missing / pairs.max(1.0)), most)
}

/// The most that may be missing where none of so many pairs was: 95 % confidence (the rule of three).
fn unseen(pairs: f64) -> f64 {
    (3.0 / pairs.max(1.0)).min(1.0)
}

/// A part of the pairs that is as good as none.
const FEW: f64 = 1e-6;
/// Student's t, one-sided, 95 %, by degrees of freedom from 1 on; the last one for all beyond.
const STUDENT: [f64; 6] = [6.314, 2.920, 2.353, 2.132, 2.015, 1.943];

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

/// The fastest point whose errors are at most those of another: of the forces, of the trajectory, the fluctuation and, beyond its scatter,
/// the drift of the energy; it lacks no pair. It may be slower, or that point itself.
pub fn fastest<'a>(points: &'a [Found], than: &Found) -> Option<&'a Found> {
    nearest(points.iter().filter(|point| is_no_worse(point, than)).collect(), than)
}

/// The fastest such point that is faster by a twentieth and beyond the noise.
pub fn better<'a>(points: &'a [Found], than: &Found) -> Option<&'a Found> {
    let faster = |point: &&Found| point.faster(than).is_some_and(|(times, sure)| sure && times > FASTER);
    nearest(points.iter().filter(|point| is_no_worse(point, than)).filter(faster).collect(), than)
}

/// Of the fastest points, as far as noise lets tell, the one that differs from another in the least of precision, time step and skin.
fn nearest<'a>(points: Vec<&'a Found>, to: &Found) -> Option<&'a Found> {
    let by_time = |a: &&Found, b: &&Found| a.time.median.total_cmp(&b.time.median);
    let first = points.iter().copied().min_by(by_time)?;
    let slower = |point: &Found| first.faster(point).is_some_and(|(times, sure)| sure && times > FASTER);
    let changes = |point: &Found| {
        let all = [point.precision != to.precision, point.dt != to.dt, point.skin != to.skin];
        all.into_iter().filter(|other| *other).count()
    };
    points.into_iter().filter(|p| !slower(p)).min_by(|a, b| changes(a).cmp(&changes(b)).then_with(|| by_time(a, b)))
}

fn is_no_worse(point: &Found, than: &Found) -> bool {
    let at_most = |a: Option<f64>, b: Option<f64>| matches!((a, b), (Some(a), Some(b)) if a <= SAME * b);
    let drifts = match (point.drift, than.drift) {
        (Some((a, scatter)), Some((b, other))) => a.abs() <= SAME * b.abs() + 2.0 * scatter.hypot(other),
        _ => false,
    };
    point.is_sound()
        && (&point.potential, &point.integrator) == (&than.potential, &than.integrator)
        && at_most(point.trajectory, than.trajectory)
        && at_most(point.fluctuation, than.fluctuation)
        && (at_most(point.force, than.force) || (point.force, than.force) == (None, None))
        && drifts
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
            rounds: ["1", "2", "3"].iter().map(|round| (round.to_string(), time)).collect(),
            rebuild: SAFE.into(),
            trajectory: Some(trajectory),
            fluctuation: Some(trajectory),
            force: Some(1e-7),
            drift: Some((drift, 0.1)),
            ..Found::default()
        }
    }

    #[test]
    fn advice_is_the_fastest_that_is_no_worse() {
        let own = point(10.0, 1.0, 0.2);
        let faster = point(6.0, 1.04, -0.45);
        let lacking = Found { missing: Some(1e-6), ..point(4.0, 0.5, 0.0) };
        let broken = Found { fault: "step 3".into(), ..point(4.0, 0.5, 0.0) };
        let shifted = Found { potential: "force-shifted".into(), ..point(3.0, 0.1, 0.0) };
        // Forces of half the digits are no same error, whatever the trajectory makes of them.
        let coarse = Found { force: Some(2e-7), ..point(3.0, 0.5, 0.0) };
        let all = [
            own.clone(),
            point(5.0, 1.06, 0.0),
            point(5.0, 1.0, 0.7),
            faster.clone(),
            lacking,
            broken,
            shifted,
            coarse,
        ];
        assert_eq!(better(&all, &own), Some(&faster));
        assert_eq!(better(&[own.clone(), faster.clone()], &faster), None);
        // Four per cent faster is no news; slower is what one may have to take.
        assert_eq!(better(&[point(9.6, 1.0, 0.0)], &own), None);
        assert_eq!(fastest(&[point(12.0, 1.0, 0.0), point(11.0, 1.0, 0.0)], &own), Some(&point(11.0, 1.0, 0.0)));
    }

    #[test]
    fn drifts_count_beyond_their_errors() {
        let drifting = |drift| point(1.0, 1.0, drift).drifts(0.5);
        assert!(drifting(-0.71) && drifting(0.71) && !drifting(0.69));
        assert!(!Found { drift: None, ..point(1.0, 1.0, 9.0) }.drifts(0.5));
    }

    #[test]
    fn faster_is_what_all_rounds_say() {
        let of = |times: &[f64]| Found {
            rounds: times.iter().enumerate().map(|(k, time)| (k.to_string(), *time)).collect(),
            ..point(times[0], 1.0, 0.0)
        };
        let own = of(&[10.0, 20.0, 15.0]);
        // What else the machine did met both: ratios are 1.25 in all rounds.
        let (times, sure) = of(&[8.0, 16.0, 12.0]).faster(&own).unwrap();
        assert!((times - 1.25).abs() < 1e-12 && sure);
        // Where noise does not tell, what is nearest to the script's is as good.
        let other = Found { precision: "double".into(), ..of(&[7.9, 16.2, 11.9]) };
        let all = [other, of(&[8.0, 16.0, 12.0])];
        assert_eq!(better(&all, &own), Some(&all[1]));
        // One round is slower; all are faster, but in a scatter that may be chance: mean 0.33, error 0.24.
        assert!(!of(&[5.0, 10.0, 15.1]).faster(&own).unwrap().1);
        assert!(!of(&[4.5, 19.0, 14.5]).faster(&own).unwrap().1);
        // Of one round nobody knows.
        assert!(!of(&[5.0]).faster(&own).unwrap().1);
        assert_eq!(better(&[of(&[5.0, 10.0, 15.1])], &own), None);
        assert!(better(&[of(&[8.0, 16.0, 12.0])], &own).is_some());
    }

    #[test]
    fn none_seen_is_not_none() {
        let unchecked = |missing: f64, pairs: f64| Found {
            rebuild: "every 20 delay 0 check no".into(),
            missing: Some(missing / pairs),
            missing_most: (missing == 0.0).then(|| unseen(pairs)),
            ..point(5.0, 0.5, 0.0)
        };
        assert_eq!(unchecked(0.0, 1e5).lists(), Lists::Unsure(3e-5));
        assert_eq!(unchecked(0.0, 4e6).lists(), Lists::Whole);
        assert_eq!(unchecked(1.0, 1e7).lists(), Lists::Lack(1e-7));
        assert_eq!(point(1.0, 1.0, 1.0).lists(), Lists::Whole);
        assert!(!unchecked(0.0, 1e5).is_sound() && unchecked(0.0, 4e6).is_sound());
        assert_eq!(better(&[unchecked(0.0, 1e5)], &point(10.0, 1.0, 0.2)), None);
        let mut all = [point(10.0, 1.0, 0.2), unchecked(0.0, 1e5)];
        mark(&mut all);
        assert_eq!(all.map(|p| p.front), [true, false]);
    }
}
