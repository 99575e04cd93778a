//! Exponential and logarithm in lanes, written once for all of them.

use super::Lanes;

/// 1 / k! for k from 0.
const INVERSE_FACTORIALS: [f64; 14] = {
    let mut table = [1.0; 14];
    let mut k = 1;
    while k < table.len() {
        table[k] = table[k - 1] / k as f64;
        k += 1;
    }
    table
};

/// e^x = 2^n e^r with n = round(x / ln 2) and |r| <= ln 2 / 2, e^r by its Taylor series, whose rest is below rounding (7 terms
/// for f32: 5e-9; 13 for f64: 4e-18), even and odd powers side by side. Below the smallest normal number 0, above the largest
/// infinity; NaN stays NaN.
#[inline(always)]
pub fn exp<L: Lanes>(x: L) -> L {
    let single = size_of::<L::Element>() == 4;
    // ln 2 in two parts, the upper with few enough bits that n times it is exact.
    let (least, most, upper, lower, degree) = if single {
        (-87.0, 88.722_83, 0.693_359_375, -2.121_944_400_546_905_8e-4, 7)
    } else {
        (-708.0, 709.782_712_893_384, 0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10, 13)
    };
    // Far enough beyond the bounds for the result to be 0 or infinity. A NaN comes through as the second argument.
    let limited = L::constant(4.0 * least).max(L::constant(4.0 * most).min(x));
    let n = (limited * L::constant(std::f64::consts::LOG2_E)).round();
    let r = n.mul_add(L::constant(-lower), n.mul_add(L::constant(-upper), limited));
    let square = r * r;
    let mut even = L::constant(INVERSE_FACTORIALS[degree - 1]);
    let mut odd = L::constant(INVERSE_FACTORIALS[degree]);
    for k in (0..degree / 2).rev() {
        even = even.mul_add(square, L::constant(INVERSE_FACTORIALS[2 * k]));
        odd = odd.mul_add(square, L::constant(INVERSE_FACTORIALS[2 * k + 1]));
    }
    let sum = odd.mul_add(r, even);
    if L::SATURATES {
        return sum.times_power_of_two(n);
    }
    let value = sum.times_power_of_two(n);
    let value = L::select(x.less(L::constant(least)), L::constant(0.0), value);
    L::select(L::constant(most).less(x), L::constant(f64::INFINITY), value)
}

/// 2 / (2 k + 3) for k from 0.
const SERIES: [f64; 10] = {
    let mut table = [0.0; 10];
    let mut k = 0;
    while k < table.len() {
        table[k] = 2.0 / (2 * k + 3) as f64;
        k += 1;
    }
    table
};

/// ln x = n ln 2 + ln(1 + f) with x = 2^n (1 + f) and 1 + f between the roots of 1/2 and 2. With s = f / (2 + f) the last is
/// 2 (s + s^3 / 3 + s^5 / 5 ..), whose rest is below rounding (4 terms more for f32: 4e-9; 10 for f64: 1e-17), and is put as
/// f - s (f - 2 s^2 / 3 - 2 s^4 / 5 ..), since f is exact. Of 0 and less than the smallest normal number minus infinity, of less
/// than 0 NaN; infinity and NaN stay what they are.
#[inline(always)]
pub fn ln<L: Lanes>(x: L) -> L {
    let single = size_of::<L::Element>() == 4;
    let (least, upper, lower, terms) = if single {
        (f64::from(f32::MIN_POSITIVE), 0.693_359_375, -2.121_944_400_546_905_8e-4, 4)
    } else {
        (f64::MIN_POSITIVE, 0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10, 10)
    };
    let one = L::constant(1.0);
    let (n, m) = x.split();
    let above = L::constant(std::f64::consts::SQRT_2).less(m);
    let (n, m) = (L::select(above, n + one, n), L::select(above, m * L::constant(0.5), m));
    let f = m - one;
    let s = f / (f + L::constant(2.0));
    let square = s * s;
    let mut sum = L::constant(SERIES[terms - 1]);
    for k in (0..terms - 1).rev() {
        sum = sum.mul_add(square, L::constant(SERIES[k]));
    }
    let rest = n.mul_add(L::constant(lower), -(s * (f - sum * square)));
    let value = n.mul_add(L::constant(upper), f + rest);
    let value = L::select(x.less(L::constant(least)), L::constant(f64::NEG_INFINITY), value);
    let value = L::select(x.less(L::constant(0.0)), L::constant(f64::NAN), value);
    L::select(x.less(L::constant(f64::INFINITY)), value, x)
}
