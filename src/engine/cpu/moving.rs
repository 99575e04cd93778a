//! The particles between builds: positions, velocities and forces in the run's precision, one array an axis, and the slots
//! that pair arithmetic reads.

use super::mode::{Mode, Slot};
use crate::engine::particles::Particles;
use crate::neighbor::{Cells, Grid};
use crate::real::Isa;
use crate::real::lanes::{Element, Simd, SimdVisitor, Work, with_simd};
use crate::system::parallel;
use crate::system::{SimulationBox, Vec3};

/// Particles handled as one piece of work; also the unit of partial sums, so it must not depend on threads.
pub const PIECE: usize = 1024;

/// Arrays are filled up to a multiple of this, so that no lane is left over.
const FULL: usize = 16;

/// One array an axis.
pub type Axes<T> = [Vec<T>; 3];

/// Particles whose positions are relative to the same point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// First particle, one past the last.
    pub first: usize,
    pub end: usize,
    /// Length units.
    pub origin: [f64; 3],
}

/// Structure of arrays in the order of the last build; arrays end with idle particles.
#[derive(Debug, Default)]
pub struct Moving<M: Mode> {
    len: usize,
    pub x: Axes<M::Store>,
    pub v: Axes<M::Store>,
    pub f: Axes<M::Force>,
    /// Positions at the last build, as in `x`.
    pub built: Axes<M::Store>,
    /// Types from 0, and groups, of all particles, idle ones too.
    pub kind: Vec<u32>,
    pub mask: Vec<u32>,
    /// One for each particle.
    pub slots: Vec<M::Slot>,
    /// Quanta in a length unit, for slots in fixed point.
    pub quanta: f64,
    pub frames: Vec<Frame>,
}

impl<M: Mode> Moving<M> {
    /// Bytes of one particle in all arrays.
    pub const BYTES: usize =
        9 * size_of::<M::Store>() + 3 * size_of::<M::Force>() + size_of::<M::Slot>() + 2 * size_of::<u32>();

    pub fn len(&self) -> usize {
        self.len
    }

    /// Takes sorted particles over. Where positions are kept relative to cells, those of `held` become what is kept.
    pub fn take(&mut self, held: &mut Particles, grid: &Grid, cells: &Cells, simulation_box: &SimulationBox) {
        self.len = held.len();
        let full = self.len.next_multiple_of(FULL);
        self.frames.clear();
        if M::RELATIVE {
            for k in 0..cells.len() {
                let cell = grid.unhash(cells.hash(k));
                let origin = std::array::from_fn(|axis| grid.axes[axis].middle(cell[axis]));
                let (first, end) = cells.cell(k);
                self.frames.push(Frame { first: first as usize, end: end as usize, origin });
            }
        } else {
            self.frames.push(Frame { first: 0, end: self.len, origin: [0.0; 3] });
        }
        for axis in 0..3 {
            for column in [&mut self.x[axis], &mut self.v[axis], &mut self.built[axis]] {
                column.resize(full, M::Store::default());
                column[self.len..].fill(M::Store::default());
            }
            self.f[axis].resize(full, M::Force::default());
            self.f[axis][self.len..].fill(M::Force::default());
        }
        self.kind.resize(full, 0);
        self.kind[self.len..].fill(0);
        self.mask.resize(full, 0);
        self.mask[self.len..].fill(0);
        self.kind[..self.len].copy_from_slice(&held.kind);
        self.mask[..self.len].copy_from_slice(&held.mask);
        self.slots.resize(self.len, M::Slot::default());
        let frames = &self.frames;
        let (lo, hi) = (simulation_box.lo, simulation_box.hi);
        let copy = |first: usize, (to, (at, v)): (Columns<'_, M>, (&mut [Vec3], &mut [Vec3]))| {
            let ((x, u), built) = to;
            for (from, end, frame) in parts_of(frames, first, at.len()) {
                for k in from..end {
                    for axis in 0..3 {
                        let origin = frame.origin[axis];
                        let mut kept = M::Store::of(at[k][axis] - origin);
                        if M::RELATIVE {
                            kept = inside(at[k][axis], kept, origin, lo[axis], hi[axis]);
                            at[k][axis] = kept.double() + origin;
                        }
                        (x[axis][k], built[axis][k]) = (kept, kept);
                        u[axis][k] = M::Store::of(v[k][axis]);
                    }
                }
            }
        };
        let n = self.len;
        let columns = (
            (self.x.each_mut().map(|a| &mut a[..n]), self.v.each_mut().map(|a| &mut a[..n])),
            self.built.each_mut().map(|a| &mut a[..n]),
        );
        parallel::each((columns, (&mut held.x[..], &mut held.v[..])), PIECE, &copy, &|(), ()| ());
    }

    /// Slots of all particles, in any form.
    pub fn pack<S: Slot>(&self, isa: Isa, quanta: f64, to: &mut Vec<S>) {
        to.resize(self.len, S::default());
        let pieces = (self.x.each_ref().map(|a| &a[..self.len]), &self.kind[..self.len]);
        let work = |first: usize, (to, (x, kinds)): (&mut [S], Places<'_, M>)| {
            with_simd(isa, Pack::<M, S> { first, x, kinds, frames: &self.frames, quanta, to });
        };
        parallel::each((&mut to[..], pieces), PIECE, &work, &|(), ()| ());
    }

    /// Writes positions and velocities over those of particles in the same order.
    pub fn copy_to(&self, to: &mut Particles) {
        let copy = |first: usize, (x, v): (&mut [Vec3], &mut [Vec3])| {
            for (from, end, frame) in parts_of(&self.frames, first, x.len()) {
                for k in from..end {
                    for axis in 0..3 {
                        x[k][axis] = self.x[axis][first + k].double() + frame.origin[axis];
                        v[k][axis] = self.v[axis][first + k].double();
                    }
                }
            }
        };
        parallel::each((&mut to.x[..], &mut to.v[..]), PIECE, &copy, &|(), ()| ());
    }

    /// Force on particle `k`, force units.
    pub fn force(&self, k: usize) -> Vec3 {
        Vec3::from(std::array::from_fn(|axis| self.f[axis][k].double()))
    }
}

type Columns<'a, M> =
    (([&'a mut [<M as Mode>::Store]; 3], [&'a mut [<M as Mode>::Store]; 3]), [&'a mut [<M as Mode>::Store]; 3]);
type Places<'a, M> = ([&'a [<M as Mode>::Store]; 3], &'a [u32]);

/// Each frame's part of `count` particles from `first`: from, end (counted from `first`), frame.
#[inline(always)]
pub fn parts_of(frames: &[Frame], first: usize, count: usize) -> impl Iterator<Item = (usize, usize, &Frame)> {
    let begin = frames.partition_point(|frame| frame.end <= first);
    let inside = frames[begin..].iter().take_while(move |frame| frame.first < first + count);
    inside.map(move |frame| (frame.first.max(first) - first, frame.end.min(first + count) - first, frame))
}

/// What is kept of a coordinate x in the box: rounding must put it neither below the lower side nor at or beyond the upper.
fn inside<E: Element>(x: f64, mut kept: E, origin: f64, lo: f64, hi: f64) -> E {
    let mut step = (hi - lo).abs().min((x - origin).abs().max(f64::MIN_POSITIVE)) * 6e-8;
    while (lo..hi).contains(&x) && !(lo..hi).contains(&(kept.double() + origin)) && step <= hi - lo {
        kept = E::of(if kept.double() + origin < lo { lo - origin + step } else { hi - origin - step });
        step *= 2.0;
    }
    kept
}

/// Slots of one piece.
pub struct Pack<'a, M: Mode, S> {
    pub first: usize,
    pub x: [&'a [M::Store]; 3],
    pub kinds: &'a [u32],
    pub frames: &'a [Frame],
    pub quanta: f64,
    pub to: &'a mut [S],
}

impl<M: Mode, S: Slot> Pack<'_, M, S> {
    #[inline(always)]
    pub fn run<I: Simd>(self) {
        let Pack { first, x, kinds, frames, quanta, to } = self;
        let count = to.len();
        for (from, end, frame) in parts_of(frames, first, count) {
            let x = [&x[0][from..end], &x[1][from..end], &x[2][from..end]];
            S::pack::<I, M::Store>(x, &frame.origin, &kinds[from..end], quanta, &mut to[from..end]);
        }
    }
}

impl<M: Mode, S: Slot> SimdVisitor for Pack<'_, M, S> {
    type Output = ();
    fn visit<I: Simd>(self, simd: I) {
        struct On<'a, M: Mode, S, I>(Pack<'a, M, S>, std::marker::PhantomData<I>);
        impl<M: Mode, S: Slot, I: Simd> Work for On<'_, M, S, I> {
            type Output = ();
            #[inline(always)]
            fn run(self) {
                self.0.run::<I>();
            }
        }
        simd.vectorize(On(self, std::marker::PhantomData::<I>));
    }
}
