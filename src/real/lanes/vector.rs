//! What the vector instruction sets of x86-64 have in common, once for both number types of each.
//!
//! Safety of every block here: that of the file which calls the macro; its type proves that the instructions are there, and
//! loads and stores go through slices whose length is checked.

/// Implements [`super::Lanes`] for `$name`, a register of `$count` numbers `$t`, from the intrinsics that both instruction sets
/// have. What they do differently is found in modules of the calling file, in a function named by the number type.
macro_rules! vector_lanes {
    ($name:ident: $t:ident x $count:literal, mask $mask:ident, saturates $saturates:literal,
     set $set:ident, load $load:ident, store $store:ident, add $add:ident, sub $sub:ident, mul $mul:ident, div $div:ident,
     sqrt $sqrt:ident, fmadd $fmadd:ident, compare $compare:ident, max $max:ident, min $min:ident) => {
        impl Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, b: Self) -> Self {
                unsafe { Self($add(self.0, b.0)) }
            }
        }
        impl Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, b: Self) -> Self {
                unsafe { Self($sub(self.0, b.0)) }
            }
        }
        impl Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, b: Self) -> Self {
                unsafe { Self($mul(self.0, b.0)) }
            }
        }
        impl Div for $name {
            type Output = Self;
            #[inline(always)]
            fn div(self, b: Self) -> Self {
                unsafe { Self($div(self.0, b.0)) }
            }
        }
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self::constant(-0.0) - self
            }
        }

        impl Real for $name {
            type Mask = $mask;
            #[inline(always)]
            fn constant(value: f64) -> Self {
                Self::splat(value as $t)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                unsafe { Self($sqrt(self.0)) }
            }
            #[inline(always)]
            fn exp(self) -> Self {
                super::exp::exp(self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                super::exp::ln(self)
            }
            #[inline(always)]
            fn less(self, other: Self) -> $mask {
                unsafe { $compare::<_CMP_LT_OQ>(self.0, other.0) }
            }
            #[inline(always)]
            fn select(mask: $mask, yes: Self, no: Self) -> Self {
                select::$t(mask, yes, no)
            }
            #[inline(always)]
            fn recip(self) -> Self {
                recip::$t(self)
            }
            #[inline(always)]
            fn rsqrt(self) -> Self {
                rsqrt::$t(self)
            }
            #[inline(always)]
            fn mul_add(self, a: Self, b: Self) -> Self {
                unsafe { Self($fmadd(self.0, a.0, b.0)) }
            }
        }

        impl Lanes for $name {
            type Element = $t;
            const COUNT: usize = $count;
            const SATURATES: bool = $saturates;
            #[inline(always)]
            fn from_fn(value: impl FnMut(usize) -> $t) -> Self {
                let values: [$t; $count] = std::array::from_fn(value);
                Self::load(&values)
            }
            #[inline(always)]
            fn splat(value: $t) -> Self {
                unsafe { Self($set(value)) }
            }
            #[inline(always)]
            fn load(from: &[$t]) -> Self {
                let from = &from[..$count];
                unsafe { Self($load(from.as_ptr())) }
            }
            #[inline(always)]
            fn load_single(from: &[f32]) -> Self {
                load_single::$t(&from[..$count])
            }
            #[inline(always)]
            fn load_double(from: &[f64]) -> Self {
                load_double::$t(&from[..$count])
            }
            #[inline(always)]
            fn store(self, to: &mut [$t]) {
                let to = &mut to[..$count];
                unsafe { $store(to.as_mut_ptr(), self.0) }
            }
            #[inline(always)]
            fn round(self) -> Self {
                round::$t(self)
            }
            #[inline(always)]
            fn times_power_of_two(self, n: Self) -> Self {
                times_power_of_two::$t(self, n)
            }
            #[inline(always)]
            fn split(self) -> (Self, Self) {
                split::$t(self)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                unsafe { Self($max(self.0, other.0)) }
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                unsafe { Self($min(self.0, other.0)) }
            }
            #[inline(always)]
            fn sum(self) -> $t {
                sum::$t(self)
            }
            #[inline(always)]
            fn sums(three: [Self; 3]) -> [$t; 3] {
                sums::$t(three)
            }
            #[inline(always)]
            fn largest(self) -> $t {
                largest::$t(self)
            }
            #[inline(always)]
            fn lookup(column: &[$t], index: &[u32]) -> Self {
                lookup::$t(column, index)
            }
            #[inline(always)]
            fn bits(mask: $mask) -> u32 {
                bits::$t(mask)
            }
            #[inline(always)]
            fn mask(bits: u32) -> $mask {
                mask::$t(bits)
            }
        }
    };
}
pub(super) use vector_lanes;
