//! The mathematical functions of formulas (doc page `variable`).

use std::f64::consts::PI;

/// A function by name. Functions of time give the next step of a series after the present one, or a value that follows it.
#[derive(Debug)]
pub struct Function {
    pub name: &'static str,
    pub arguments: usize,
    pub compute: Compute,
}

/// How a function comes to its value. Errors say what was expected of the arguments.
#[derive(Clone, Copy, Debug)]
pub enum Compute {
    /// From its arguments alone.
    Pure(fn(&[f64]) -> Result<f64, &'static str>),
    /// From the clock too.
    Time(fn(&[f64], &Clock) -> Result<f64, &'static str>),
    /// `random(lo,hi,seed)`.
    Random,
    /// `normal(mean,sigma,seed)`.
    Normal,
    /// `ternary(condition,yes,no)`: only the chosen argument is evaluated.
    Ternary,
}

/// Where the simulation stands in time.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    pub step: i64,
    /// Timestep length, time units.
    pub timestep: f64,
    /// First and last step that `ramp` and its like count from; equal between runs.
    pub first: i64,
    pub last: i64,
}

/// Two functions are the same if their names are: each name stands once in the table.
impl PartialEq for Function {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Function {
    pub fn named(name: &str) -> Option<&'static Function> {
        FUNCTIONS.iter().find(|f| f.name == name)
    }
}

const fn function(name: &'static str, arguments: usize, compute: Compute) -> Function {
    Function { name, arguments, compute }
}

/// All functions.
pub static FUNCTIONS: [Function; 29] = [
    function("sqrt", 1, Compute::Pure(sqrt)),
    function("exp", 1, Compute::Pure(|a| Ok(a[0].exp()))),
    function("ln", 1, Compute::Pure(|a| positive(a[0]).map(f64::ln))),
    function("log", 1, Compute::Pure(|a| positive(a[0]).map(f64::log10))),
    function("abs", 1, Compute::Pure(|a| Ok(a[0].abs()))),
    function("sign", 1, Compute::Pure(|a| Ok(if a[0] >= 0.0 { 1.0 } else { -1.0 }))),
    function("sin", 1, Compute::Pure(|a| Ok(a[0].sin()))),
    function("cos", 1, Compute::Pure(|a| Ok(a[0].cos()))),
    function("tan", 1, Compute::Pure(|a| Ok(a[0].tan()))),
    function("asin", 1, Compute::Pure(|a| cosine(a[0]).map(f64::asin))),
    function("acos", 1, Compute::Pure(|a| cosine(a[0]).map(f64::acos))),
    function("atan", 1, Compute::Pure(|a| Ok(a[0].atan()))),
    function("atan2", 2, Compute::Pure(|a| Ok(a[0].atan2(a[1])))),
    function("random", 3, Compute::Random),
    function("normal", 3, Compute::Normal),
    function("ceil", 1, Compute::Pure(|a| Ok(a[0].ceil()))),
    function("floor", 1, Compute::Pure(|a| Ok(a[0].floor()))),
    function("round", 1, Compute::Pure(|a| Ok(round(a[0])))),
    function("ternary", 3, Compute::Ternary),
    function("ramp", 2, Compute::Time(ramp)),
    function("stagger", 2, Compute::Time(stagger)),
    function("logfreq", 3, Compute::Time(logfreq)),
    function("logfreq2", 3, Compute::Time(logfreq2)),
    function("logfreq3", 3, Compute::Time(logfreq3)),
    function("stride", 3, Compute::Time(stride)),
    function("stride2", 6, Compute::Time(stride2)),
    function("vdisplace", 2, Compute::Time(|a, clock| Ok(a[0] + a[1] * elapsed(clock) * clock.timestep))),
    function("swiggle", 3, Compute::Time(swiggle)),
    function("cwiggle", 3, Compute::Time(cwiggle)),
];

/// The step after the last one of a series, as LAMMPS has it.
const NEVER: f64 = 9.223372036854775e18;

/// Points of a series that is gone through one by one.
const MOST_POINTS: i128 = 10_000_000;

fn sqrt(a: &[f64]) -> Result<f64, &'static str> {
    if a[0] < 0.0 { Err("square root of a negative number") } else { Ok(a[0].sqrt()) }
}

fn positive(x: f64) -> Result<f64, &'static str> {
    if x <= 0.0 { Err("logarithm of zero or a negative number") } else { Ok(x) }
}

fn cosine(x: f64) -> Result<f64, &'static str> {
    if x.abs() > 1.0 { Err("arc of a number outside -1 to 1") } else { Ok(x) }
}

/// Halves go up, negative ones too: `round(-2.5)` is -2 in LAMMPS.
fn round(x: f64) -> f64 {
    if x - x.floor() >= 0.5 { x.ceil() } else { x.floor() }
}

/// Steps since the run's first.
fn elapsed(clock: &Clock) -> f64 {
    clock.step.saturating_sub(clock.first) as f64
}

fn ramp(a: &[f64], clock: &Clock) -> Result<f64, &'static str> {
    let mut fraction = elapsed(clock);
    if fraction != 0.0 && clock.last != clock.first {
        fraction /= clock.last.saturating_sub(clock.first) as f64;
    } else {
        fraction = 0.0;
    }
    Ok(a[0] + fraction * (a[1] - a[0]))
}

fn swiggle(a: &[f64], clock: &Clock) -> Result<f64, &'static str> {
    let omega = angular_frequency(a[2])?;
    Ok(a[0] + a[1] * (omega * elapsed(clock) * clock.timestep).sin())
}

fn cwiggle(a: &[f64], clock: &Clock) -> Result<f64, &'static str> {
    let omega = angular_frequency(a[2])?;
    Ok(a[0] + a[1] * (1.0 - (omega * elapsed(clock) * clock.timestep).cos()))
}

fn angular_frequency(period: f64) -> Result<f64, &'static str> {
    if period > 0.0 { Ok(2.0 * PI / period) } else { Err("expected a period z above 0") }
}

/// Whole steps, cut towards zero. Wide enough that products of two do not overflow.
fn steps<const N: usize>(a: &[f64]) -> [i128; N] {
    std::array::from_fn(|k| a.get(k).map_or(0, |x| i128::from(*x as i64)))
}

fn stagger(a: &[f64], clock: &Clock) -> Result<f64, &'static str> {
    let [x, y] = steps(a);
    if x <= 0 || y <= 0 || x <= y {
        return Err("expected x > y > 0");
    }
    let step = i128::from(clock.step);
    let lower = step / x * x;
    Ok((lower + if step - lower < y { y } else { x }) as f64)
}

/// Largest `x z^k` that is not above `step`.
fn decade(step: i128, x: i128, z: i128) -> i128 {
    let mut lower = x;
    while step >= z * lower {
        lower *= z;
    }
    lower
}

fn logfreq(a: &[f64], clock: &Clock) -> Result<f64, &'static str> {
    let [x, y, z] = steps(a);
    if x <= 0 || y <= 0 || y >= z {
        return Err("expected x > 0 and 0 < y < z");
    }
    let step = i128::from(clock.step);
    if step < x {
        return Ok(x as f64);
    }
    let lower = decade(step, x, z);
    let multiple = step / lower;
    Ok(if multiple < y { (multiple + 1) * lower } else { lower * z } as f64)
}

fn logfreq2(a: &[f64], clock: &Clock) -> Result<f64, &'static str> {
    let [x, y, z] = steps(a);
    if x <= 0 || y <= 0 || z <= 1 || y > MOST_POINTS {
        return Err("expected x > 0, z > 1 and y from 1 to 10000000");
    }
    // The series is summed up from its start, so that its rounding errors are LAMMPS's.
    let step = clock.step as f64;
    let mut point = x as f64;
    let mut spacing = point * (z as f64 - 1.0) / y as f64;
    loop {
        for _ in 0..y {
            if step < point.ceil() {
                return Ok(point.ceil());
            }
            point += spacing;
        }
        spacing *= z as f64;
    }
}

fn logfreq3(a: &[f64], clock: &Clock) -> Result<f64, &'static str> {
    let [x, y, z] = steps(a);
    if x <= 0 || y <= 1 || z <= 0 || z - x + 1 < y || y > MOST_POINTS {
        return Err("expected x > 0, y from 2 to 10000000 and z at least x + y - 1");
    }
    let step = i128::from(clock.step);
    let ratio = (z as f64 / x as f64).powf(1.0 / (y as f64 - 1.0));
    if step > z {
        return Err("the series ends at step z");
    }
    if step == z {
        return Ok(((z - 1) as f64 * ratio).floor() + 1.0);
    }
    let mut point = x as f64;
    let mut index = 0;
    while index < y - 1 && step as f64 >= point.ceil() {
        point *= ratio;
        index += 1;
    }
    Ok(if index == y - 1 { z as f64 } else { point.ceil() })
}

fn stride(a: &[f64], clock: &Clock) -> Result<f64, &'static str> {
    let [x, y, z] = steps(a);
    if x < 0 || y < 0 || z <= 0 || x > y {
        return Err("expected 0 <= x <= y and z > 0");
    }
    let step = i128::from(clock.step);
    if step < x {
        return Ok(x as f64);
    }
    let next = next_multiple(step, x, z);
    Ok(if step < y && next <= y { next as f64 } else { NEVER })
}

fn next_multiple(step: i128, start: i128, stride: i128) -> i128 {
    step - (step - start) % stride + stride
}

fn stride2(a: &[f64], clock: &Clock) -> Result<f64, &'static str> {
    let [x, y, z, from, to, fine] = steps(a);
    if x < 0 || y < 0 || z <= 0 || fine <= 0 || x > y || from > to || from < x || to > y {
        return Err("expected 0 <= x <= a <= b <= y and z, c > 0");
    }
    let step = i128::from(clock.step);
    if step < x {
        return Ok(x as f64);
    }
    if step >= y {
        return Ok(NEVER);
    }
    let coarse = next_multiple(step, x, z);
    Ok(if step < from {
        coarse.min(from)
    } else if step < to {
        let next = next_multiple(step, from, fine);
        if next <= to { next } else { coarse }
    } else {
        coarse
    } as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(step: i64, name: &str, args: &[f64]) -> Result<f64, &'static str> {
        let clock = Clock { step, timestep: 0.002, first: 0, last: 0 };
        match Function::named(name).unwrap().compute {
            Compute::Time(compute) => compute(args, &clock),
            _ => Err("not a function of time"),
        }
    }

    /// A function, its arguments, and steps with the values there.
    type Series = (&'static str, &'static [f64], &'static [(i64, f64)]);

    /// Values of LAMMPS 22Jul2025 at the steps on the left, timestep 0.002.
    #[test]
    fn functions_of_time_are_those_of_lammps() {
        let series: [Series; 14] = [
            ("stagger", &[100.0, 7.0], &[(0, 7.0), (6, 7.0), (7, 100.0), (100, 107.0), (108, 200.0), (1001, 1007.0)]),
            ("stagger", &[10.9, 3.0], &[(1, 3.0), (4, 10.0), (10, 13.0), (13, 20.0), (251, 253.0)]),
            (
                "logfreq",
                &[10.0, 4.0, 10.0],
                &[(9, 10.0), (10, 20.0), (21, 30.0), (39, 40.0), (40, 100.0), (5003, 10000.0)],
            ),
            ("logfreq", &[7.0, 2.0, 3.0], &[(7, 14.0), (20, 21.0), (21, 42.0), (199, 378.0), (5003, 5103.0)]),
            (
                "logfreq2",
                &[10.0, 4.0, 10.0],
                &[(9, 10.0), (10, 33.0), (39, 55.0), (80, 100.0), (100, 325.0), (5003, 5500.0)],
            ),
            ("logfreq2", &[7.0, 3.0, 3.0], &[(7, 12.0), (13, 17.0), (20, 22.0), (22, 35.0), (999, 1323.0)]),
            ("logfreq2", &[2.0, 10.0, 3.0], &[(6, 7.0), (18, 22.0), (33, 36.0), (36, 40.0), (119, 130.0)]),
            ("logfreq2", &[5.0, 7.0, 10.0], &[(44, 51.0), (51, 115.0), (499, 500.0), (5000, 5001.0), (5002, 11429.0)]),
            (
                "logfreq3",
                &[10.0, 25.0, 1000.0],
                &[(1, 10.0), (11, 13.0), (13, 15.0), (24, 27.0), (95, 100.0), (999, 1000.0), (1000, 1211.0)],
            ),
            ("logfreq3", &[3.0, 4.0, 50.0], &[(0, 3.0), (4, 8.0), (9, 20.0), (21, 50.0), (50, 126.0)]),
            ("stride", &[5.0, 100.0, 10.0], &[(4, 5.0), (5, 15.0), (81, 85.0), (95, NEVER), (5003, NEVER)]),
            (
                "stride2",
                &[5.0, 200.0, 10.0, 50.0, 80.0, 3.0],
                &[(41, 45.0), (49, 50.0), (51, 53.0), (79, 80.0), (80, 85.0), (199, 205.0), (200, NEVER)],
            ),
            ("stride2", &[0.0, 20.0, 7.0, 9.0, 11.0, 10.0], &[(5, 7.0), (8, 9.0), (9, 14.0), (19, 21.0), (20, NEVER)]),
            (
                "vdisplace",
                &[1.5, 2.25],
                &[(0, 1.5), (41, 1.6844999999999999), (330, 2.9850000000000003), (5003, 24.0135)],
            ),
        ];
        for (name, args, values) in series {
            for (step, expected) in values {
                assert_eq!(at(*step, name, args), Ok(*expected), "{name} {args:?} at step {step}");
            }
        }
        for (step, sine, cosine) in [
            (5, 1.041884839766714, 1.000438633050309),
            (101, 1.821119427724256, 1.1763325726948484),
            (499, 2.7362243902964787, 3.9927360507907537),
            (5003, 2.7193480122349865, 4.021686063731713),
        ] {
            assert_eq!(at(step, "swiggle", &[1.0, 2.0, 3.0]), Ok(sine));
            assert_eq!(at(step, "cwiggle", &[1.0, 2.0, 3.0]), Ok(cosine));
        }
        assert!(at(1001, "logfreq3", &[10.0, 25.0, 1000.0]).is_err());
    }

    #[test]
    fn ramp_follows_the_run() {
        let clock = |step| Clock { step, timestep: 0.0, first: 130, last: 160 };
        assert_eq!(ramp(&[1.0, 2.0], &clock(130)), Ok(1.0));
        assert_eq!(ramp(&[1.0, 4.0], &clock(145)), Ok(2.5));
    }

    #[test]
    fn names_are_unique() {
        for function in &FUNCTIONS {
            assert!(std::ptr::eq(Function::named(function.name).unwrap(), function));
        }
    }
}
