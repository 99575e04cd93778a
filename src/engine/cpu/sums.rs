//! Sums over the motion in lanes, in an order of their own whatever the number of threads.

use super::mode::Mode;
use super::motion::lanes_at;
use super::moving::{Moving, PIECE};
use crate::real::Isa;
use crate::real::lanes::{Element, Lanes, Simd, SimdVisitor, Work, with_simd};
use crate::system::parallel;

/// Sum of m v_a v_b in mass times velocity squared: xx, yy, zz, xy, xz, yz.
pub fn kinetic_sums<M: Mode>(moving: &Moving<M>, masses: &[f64], isa: Isa) -> [f64; 6] {
    let sum = |_: usize, (v, kinds): ([&[M::Store]; 3], &[u32])| {
        with_simd(isa, OnLanes(KineticSums::<M::Store> { v, kinds, masses }))
    };
    let pieces = (moving.v.each_ref().map(|a| &a[..]), &moving.kind[..]);
    let join = |a: [f64; 6], b: [f64; 6]| std::array::from_fn(|k| a[k] + b[k]);
    parallel::each(pieces, PIECE, &sum, &join)
}

/// Sum of m v^2 over the particles of a group, mass times velocity squared.
pub fn group_kinetic<M: Mode>(moving: &Moving<M>, masses: &[f64], group: u32, isa: Isa) -> f64 {
    type Columns<'a, T> = ([&'a [T]; 3], (&'a [u32], &'a [u32]));
    let sum = |_: usize, (v, (kinds, groups)): Columns<'_, M::Store>| {
        with_simd(isa, OnLanes(GroupKinetic::<M::Store> { v, kinds, groups, masses, group }))
    };
    let pieces = (moving.v.each_ref().map(|a| &a[..]), (&moving.kind[..], &moving.mask[..]));
    parallel::each(pieces, PIECE, &sum, &|a, b| a + b)
}

/// Largest squared displacement since the last build, length units squared; infinite where a position is no number.
pub fn displacement<M: Mode>(moving: &Moving<M>, isa: Isa) -> f64 {
    type Pair<'a, T> = ([&'a [T]; 3], [&'a [T]; 3]);
    let largest =
        |_: usize, (now, then): Pair<'_, M::Store>| with_simd(isa, OnLanes(Displacement::<M::Store> { now, then }));
    let pieces = (moving.x.each_ref().map(|a| &a[..]), moving.built.each_ref().map(|a| &a[..]));
    parallel::each(pieces, PIECE, &largest, &f64::max)
}

/// Work on f64 lanes of any instruction set; `run` is to be `#[inline(always)]`.
trait DoubleWork {
    type Output;
    fn run<L: Lanes<Element = f64>>(self) -> Self::Output;
}

struct OnLanes<W>(W);

impl<W: DoubleWork> SimdVisitor for OnLanes<W> {
    type Output = W::Output;
    fn visit<I: Simd>(self, simd: I) -> W::Output {
        struct With<W, I>(W, std::marker::PhantomData<I>);
        impl<W: DoubleWork, I: Simd> Work for With<W, I> {
            type Output = W::Output;
            #[inline(always)]
            fn run(self) -> W::Output {
                self.0.run::<I::F64>()
            }
        }
        simd.vectorize(With(self.0, std::marker::PhantomData::<I>))
    }
}

struct KineticSums<'a, E> {
    v: [&'a [E]; 3],
    kinds: &'a [u32],
    masses: &'a [f64],
}

impl<E: Element> DoubleWork for KineticSums<'_, E> {
    type Output = [f64; 6];
    #[inline(always)]
    fn run<L: Lanes<Element = f64>>(self) -> [f64; 6] {
        let mut totals = [L::constant(0.0); 6];
        let mut k = 0;
        while k < self.kinds.len() {
            let mass = match self.masses {
                [mass] => L::splat(*mass),
                masses => L::lookup(masses, &self.kinds[k..]),
            };
            let [x, y, z] = lanes_at::<E, L>([&self.v[0][k..], &self.v[1][k..], &self.v[2][k..]]);
            for (total, product) in totals.iter_mut().zip([x * x, y * y, z * z, x * y, x * z, y * z]) {
                *total = mass.mul_add(product, *total);
            }
            k += L::COUNT;
        }
        let [a, b, c, d, e, f] = totals;
        let ([xx, yy, zz], [xy, xz, yz]) = (L::sums([a, b, c]), L::sums([d, e, f]));
        [xx, yy, zz, xy, xz, yz]
    }
}

struct GroupKinetic<'a, E> {
    v: [&'a [E]; 3],
    kinds: &'a [u32],
    groups: &'a [u32],
    masses: &'a [f64],
    group: u32,
}

impl<E: Element> DoubleWork for GroupKinetic<'_, E> {
    type Output = f64;
    #[inline(always)]
    fn run<L: Lanes<Element = f64>>(self) -> f64 {
        let mut total = L::constant(0.0);
        let mut k = 0;
        while k < self.kinds.len() {
            let mass = match self.masses {
                [mass] => L::splat(*mass),
                masses => L::lookup(masses, &self.kinds[k..]),
            };
            let mut weights = [0.0; 16];
            for (weight, groups) in weights.iter_mut().zip(&self.groups[k..k + L::COUNT]) {
                *weight = if groups & self.group != 0 { 1.0 } else { 0.0 };
            }
            let [x, y, z] = lanes_at::<E, L>([&self.v[0][k..], &self.v[1][k..], &self.v[2][k..]]);
            total = (mass * L::load(&weights)).mul_add(x * x + y * y + z * z, total);
            k += L::COUNT;
        }
        total.sum()
    }
}

struct Displacement<'a, E> {
    now: [&'a [E]; 3],
    then: [&'a [E]; 3],
}

impl<E: Element> DoubleWork for Displacement<'_, E> {
    type Output = f64;
    #[inline(always)]
    fn run<L: Lanes<Element = f64>>(self) -> f64 {
        let zero = L::constant(0.0);
        let (mut most, mut poison) = (zero, zero);
        let mut k = 0;
        while k < self.now[0].len() {
            let now = lanes_at::<E, L>([&self.now[0][k..], &self.now[1][k..], &self.now[2][k..]]);
            let then = lanes_at::<E, L>([&self.then[0][k..], &self.then[1][k..], &self.then[2][k..]]);
            let (x, y, z) = (now[0] - then[0], now[1] - then[1], now[2] - then[2]);
            // In LAMMPS's order of operations: it is compared with half the skin.
            let squared = x * x + y * y + z * z;
            most = most.max(squared);
            // A position that is no number calls for a build, which finds it.
            poison = squared.mul_add(zero, poison);
            k += L::COUNT;
        }
        if poison.sum() != 0.0 { f64::INFINITY } else { most.largest() }
    }
}
