//! Forward-mode differentiation.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::Real;

/// A value and its derivative with respect to one variable (dual number a + b e with e^2 = 0).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual {
    pub value: f64,
    pub derivative: f64,
}

impl Dual {
    /// The variable itself: derivative 1.
    pub fn variable(value: f64) -> Self {
        Self { value, derivative: 1.0 }
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self { value: self.value + b.value, derivative: self.derivative + b.derivative }
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        Self { value: self.value - b.value, derivative: self.derivative - b.derivative }
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        Self { value: self.value * b.value, derivative: self.derivative * b.value + self.value * b.derivative }
    }
}

impl Div for Dual {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let value = self.value / b.value;
        Self { value, derivative: (self.derivative - value * b.derivative) / b.value }
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, derivative: -self.derivative }
    }
}

impl Real for Dual {
    type Mask = bool;
    fn constant(value: f64) -> Self {
        Self { value, derivative: 0.0 }
    }
    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        Self { value, derivative: 0.5 * self.derivative / value }
    }
    fn exp(self) -> Self {
        let value = self.value.exp();
        Self { value, derivative: self.derivative * value }
    }
    fn ln(self) -> Self {
        Self { value: self.value.ln(), derivative: self.derivative / self.value }
    }
    fn less(self, other: Self) -> bool {
        self.value < other.value
    }
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn derivatives_are_those_of_calculus() {
        let x = Dual::variable(1.7);
        let y = (x * x).exp() / (x.ln() - Dual::constant(3.0)) + x.sqrt();
        let (u, w) = ((1.7f64 * 1.7).exp(), 1.7f64.ln() - 3.0);
        assert_relative_eq!(y.value, u / w + 1.7f64.sqrt(), max_relative = 1e-15);
        let expected = (2.0 * 1.7 * u * w - u / 1.7) / (w * w) + 0.5 / 1.7f64.sqrt();
        assert_relative_eq!(y.derivative, expected, max_relative = 1e-14);
    }
}
