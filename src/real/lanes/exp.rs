//! The exponential in lanes, written once for all of them.

use super::Lanes;
use crate::real::Real;

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

/// The natural logarithm, lane by lane.
#[inline(always)]
pub fn ln<L: Lanes>(x: L) -> L {
    // The widest register holds 16 numbers.
    let mut values = [L::Element::default(); 16];
    x.store(&mut values);
    L::from_fn(|k| <L::Element as Real>::ln(values[k]))
}
