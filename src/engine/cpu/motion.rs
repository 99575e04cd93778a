//! The per-particle rules in lanes: fixes, and sums over the motion.

use super::mode::Mode;
use super::moving::{Frame, Moving, parts_of};
use crate::dynamics::noise::noise;
use crate::dynamics::{Fix, FixStyle, FixVisitor, Given, INWARD, MOST_PARAMETERS, Motion, Phase, Push, Step, with_fix};
use crate::real::lanes::{Element, Lanes, Simd, SimdVisitor, Work, with_simd};
use crate::real::{Isa, Real};
use crate::system::GROUP_ALL;
use crate::system::parallel::Pieces;

/// What the fixes need beside the particles.
#[derive(Clone, Copy, Debug)]
pub struct Kicks<'a, M: Mode> {
    /// Timestep, time units.
    pub dt: M::Store,
    /// dt / 2 / mass by type; one where all types have the same.
    pub half: &'a [M::Store],
    /// Masses by type; one where all types have the same.
    pub masses: &'a [M::Force],
    /// Ids of all particles, for random numbers.
    pub ids: &'a [u32],
    pub step: i64,
    /// The part of the run that lies behind.
    pub progress: f64,
    /// Points that positions are relative to.
    pub frames: &'a [Frame],
    /// First particle of the piece.
    pub first: usize,
}

/// Some particles' part of [`Moving`]; as many as fill all lanes.
pub struct Piece<'a, M: Mode> {
    pub x: [&'a mut [M::Store]; 3],
    pub v: [&'a mut [M::Store]; 3],
    pub f: [&'a mut [M::Force]; 3],
    pub kind: &'a [u32],
    pub mask: &'a [u32],
    /// One for each particle, none for those that fill up.
    pub slots: &'a mut [M::Slot],
}

impl<'a, M: Mode> Piece<'a, M> {
    pub fn all(moving: &'a mut Moving<M>) -> Self {
        Self {
            x: moving.x.each_mut().map(|a| &mut a[..]),
            v: moving.v.each_mut().map(|a| &mut a[..]),
            f: moving.f.each_mut().map(|a| &mut a[..]),
            kind: &moving.kind,
            mask: &moving.mask,
            slots: &mut moving.slots,
        }
    }
}

impl<M: Mode> Pieces for Piece<'_, M> {
    fn split(self, at: usize) -> (Self, Self) {
        let (x, v, f) = (self.x.split(at), self.v.split(at), self.f.split(at));
        let (kind, mask, slots) = (self.kind.split_at(at), self.mask.split_at(at), self.slots.split_at_mut(at));
        (
            Self { x: x.0, v: v.0, f: f.0, kind: kind.0, mask: mask.0, slots: slots.0 },
            Self { x: x.1, v: v.1, f: f.1, kind: kind.1, mask: mask.1, slots: slots.1 },
        )
    }
    fn count(&self) -> usize {
        self.kind.len()
    }
}

/// A fix compiled for the CPU.
pub trait FixKernel<M: Mode>: Send + Sync {
    /// Whether it does anything in a phase.
    fn acts(&self, phase: Phase) -> bool;
    /// What it does in a phase. Returns the largest squared displacement, infinite where a position has become no number.
    /// `scale` is [`Given::scale`].
    fn act(&self, phase: Phase, piece: &mut Piece<'_, M>, kicks: &Kicks<'_, M>, scale: f64) -> f64;
}

/// The kernel of a fix.
pub fn fix_kernel<M: Mode>(fix: &Fix, isa: Isa) -> Option<Box<dyn FixKernel<M>>> {
    struct Compile<'a, M>(&'a Fix, Isa, std::marker::PhantomData<M>);
    impl<M: Mode> FixVisitor for Compile<'_, M> {
        type Output = Box<dyn FixKernel<M>>;
        fn visit<F: FixStyle>(self) -> Self::Output {
            struct On<'a, M, F>(&'a Fix, std::marker::PhantomData<(M, F)>);
            impl<M: Mode, F: FixStyle> SimdVisitor for On<'_, M, F> {
                type Output = Box<dyn FixKernel<M>>;
                fn visit<I: Simd>(self, simd: I) -> Self::Output {
                    let style = std::marker::PhantomData::<F>;
                    let Fix { group, choice, ref parameters, .. } = *self.0;
                    let coordinates = (0..parameters.len()).any(|k| F::coordinate(k).is_some());
                    Box::new(Kernel { simd, group, choice, parameters: parameters.clone(), coordinates, style })
                }
            }
            with_simd(self.1, On::<M, F>(self.0, std::marker::PhantomData))
        }
    }
    with_fix(fix.style, Compile::<M>(fix, isa, std::marker::PhantomData))
}

struct Kernel<I, F> {
    simd: I,
    group: u32,
    choice: u32,
    parameters: Vec<f64>,
    /// Some parameters are coordinates.
    coordinates: bool,
    style: std::marker::PhantomData<F>,
}

impl<M: Mode, I: Simd, F: FixStyle> FixKernel<M> for Kernel<I, F> {
    fn acts(&self, phase: Phase) -> bool {
        F::PHASES.contains(&phase)
    }

    fn act(&self, phase: Phase, piece: &mut Piece<'_, M>, kicks: &Kicks<'_, M>, scale: f64) -> f64 {
        const INITIAL: usize = Phase::Initial as usize;
        const MOVED: usize = Phase::Moved as usize;
        const LAST: usize = Phase::Last as usize;
        const MEASURED: usize = Phase::Measured as usize;
        match phase {
            Phase::Initial => self.simd.vectorize(Apply::<M, I, F, INITIAL> { kernel: self, piece, kicks, scale }),
            Phase::Moved => self.simd.vectorize(Apply::<M, I, F, MOVED> { kernel: self, piece, kicks, scale }),
            Phase::Force => self.simd.vectorize(AddForces::<M, I, F> { kernel: self, piece, kicks }),
            Phase::Last => self.simd.vectorize(Apply::<M, I, F, LAST> { kernel: self, piece, kicks, scale }),
            Phase::Measured => self.simd.vectorize(Apply::<M, I, F, MEASURED> { kernel: self, piece, kicks, scale }),
        }
    }
}

impl<I, F> Kernel<I, F> {
    /// Parameters in all lanes.
    #[inline(always)]
    fn parameters<L: Lanes>(&self) -> [L; MOST_PARAMETERS] {
        let mut parameters = [L::constant(0.0); MOST_PARAMETERS];
        for (to, from) in parameters.iter_mut().zip(&self.parameters) {
            *to = L::constant(*from);
        }
        parameters
    }

    /// In which lanes from particle `k` of a piece there are particles of the group, where that is not all of them. Lanes that
    /// only fill up are in no group.
    #[inline(always)]
    fn members<M: Mode, L: Lanes>(&self, piece: &Piece<'_, M>, k: usize) -> Option<L::Mask> {
        if self.group == GROUP_ALL && k + L::COUNT <= piece.slots.len() {
            return None;
        }
        let member = |l: usize| {
            let member = piece.mask[k + l] & self.group != 0;
            L::Element::of(if member { 1.0 } else { 0.0 })
        };
        Some(L::constant(0.0).less(L::from_fn(member)))
    }
}

/// One phase of a fix on the motion of a piece.
struct Apply<'a, 'b, M: Mode, I, F, const PHASE: usize> {
    kernel: &'a Kernel<I, F>,
    piece: &'a mut Piece<'b, M>,
    kicks: &'a Kicks<'a, M>,
    scale: f64,
}

impl<M: Mode, I: Simd, F: FixStyle, const PHASE: usize> Work for Apply<'_, '_, M, I, F, PHASE> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        type Of<M, I> = <M as Mode>::StoreLanes<I>;
        let Apply { kernel, piece, kicks, scale } = self;
        let moves = PHASE != Phase::Last as usize && PHASE != Phase::Measured as usize;
        let lanes = Of::<M, I>::COUNT;
        let mut parameters = kernel.parameters::<Of<M, I>>();
        let dt = Of::<M, I>::splat(kicks.dt);
        let scale = Of::<M, I>::constant(scale);
        let zero = Of::<M, I>::constant(0.0);
        let (mut most, mut poison) = (zero, zero);
        let mut k = 0;
        while k < piece.kind.len() {
            let half_kick = match kicks.half {
                [half] => Of::<M, I>::splat(*half),
                halves => Of::<M, I>::lookup(halves, &piece.kind[k..]),
            };
            let step = Step { dt, half_kick };
            if M::RELATIVE && kernel.coordinates {
                relative_coordinates::<M, F, Of<M, I>>(&kernel.parameters, kicks, k, &mut parameters);
            }
            let progress = Of::<M, I>::constant(kicks.progress);
            let parameters = &parameters[..kernel.parameters.len()];
            let given = Given { choice: kernel.choice, parameters, progress, scale };
            let was = Motion {
                x: lanes_at::<M::Store, Of<M, I>>([&piece.x[0][k..], &piece.x[1][k..], &piece.x[2][k..]]),
                v: lanes_at::<M::Store, Of<M, I>>([&piece.v[0][k..], &piece.v[1][k..], &piece.v[2][k..]]),
                f: lanes_at::<M::Force, Of<M, I>>([&piece.f[0][k..], &piece.f[1][k..], &piece.f[2][k..]]),
            };
            let mut motion = was;
            if PHASE == Phase::Initial as usize {
                F::initial(&mut motion, &step, &given);
            } else if PHASE == Phase::Moved as usize {
                F::moved(&mut motion, &step, &given);
            } else if PHASE == Phase::Measured as usize {
                F::measured(&mut motion, &given);
            } else {
                F::last(&mut motion, &step, &given);
            }
            if let Some(members) = kernel.members::<M, Of<M, I>>(piece, k) {
                for a in 0..3 {
                    motion.x[a] = Of::<M, I>::select(members, motion.x[a], was.x[a]);
                    motion.v[a] = Of::<M, I>::select(members, motion.v[a], was.v[a]);
                }
            }
            for a in 0..3 {
                motion.v[a].store(&mut piece.v[a][k..]);
            }
            if moves {
                let mut squared = zero;
                for a in 0..3 {
                    let d = motion.x[a] - was.x[a];
                    squared = d.mul_add(d, squared);
                }
                most = most.max(squared);
                // Infinite and undefined numbers make this undefined for good.
                poison = squared.mul_add(zero, poison);
                for a in 0..3 {
                    motion.x[a].store(&mut piece.x[a][k..]);
                }
            }
            k += lanes;
        }
        if moves && poison.sum().double() != 0.0 { f64::INFINITY } else { most.largest().double() }
    }
}

/// Coordinates among the parameters as the particles from `k` of a piece on see them: relative to what their positions are
/// relative to.
#[inline(always)]
fn relative_coordinates<M: Mode, F: FixStyle, L: Lanes<Element = M::Store>>(
    from: &[f64],
    kicks: &Kicks<'_, M>,
    k: usize,
    to: &mut [L; MOST_PARAMETERS],
) {
    // The widest register holds 16 numbers.
    let mut relative = [[M::Store::default(); 16]; MOST_PARAMETERS];
    for (first, end, frame) in parts_of(kicks.frames, kicks.first + k, L::COUNT) {
        for (parameter, value) in from.iter().enumerate() {
            if let Some(axis) = F::coordinate(parameter) {
                relative[parameter][first..end].fill(M::Store::of((value - frame.origin[axis]) * INWARD));
            }
        }
    }
    for parameter in 0..from.len() {
        if F::coordinate(parameter).is_some() {
            to[parameter] = L::load(&relative[parameter]);
        }
    }
}

/// What a fix adds to the forces on a piece, in the arithmetic of forces.
struct AddForces<'a, 'b, M: Mode, I, F> {
    kernel: &'a Kernel<I, F>,
    piece: &'a mut Piece<'b, M>,
    kicks: &'a Kicks<'a, M>,
}

impl<M: Mode, I: Simd, F: FixStyle> Work for AddForces<'_, '_, M, I, F> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        type Of<M, I> = <M as Mode>::PairLanes<I>;
        let AddForces { kernel, piece, kicks } = self;
        let parameters = kernel.parameters::<Of<M, I>>();
        let (parameters, progress) = (&parameters[..kernel.parameters.len()], Of::<M, I>::constant(kicks.progress));
        let given = Given { choice: kernel.choice, parameters, progress, scale: Of::<M, I>::constant(1.0) };
        let dt = Of::<M, I>::constant(kicks.dt.double());
        let mut k = 0;
        while k < piece.kind.len() {
            let mass = match kicks.masses {
                [mass] => Of::<M, I>::splat(*mass),
                masses => Of::<M, I>::lookup(masses, &piece.kind[k..]),
            };
            let was = lanes_at::<M::Force, Of<M, I>>([&piece.f[0][k..], &piece.f[1][k..], &piece.f[2][k..]]);
            let v = lanes_at::<M::Store, Of<M, I>>([&piece.v[0][k..], &piece.v[1][k..], &piece.v[2][k..]]);
            let noise = match F::NOISE {
                Some(seed) => noise_at(kernel.parameters[seed] as u32, kicks, k),
                None => [Of::<M, I>::constant(0.0); 3],
            };
            let mut push = Push { f: was, v, mass, dt, noise };
            F::force(&mut push, &given);
            let mut f = push.f;
            if let Some(members) = kernel.members::<M, Of<M, I>>(piece, k) {
                for a in 0..3 {
                    f[a] = Of::<M, I>::select(members, f[a], was[a]);
                }
            }
            for (f, to) in f.into_iter().zip(piece.f.iter_mut()) {
                f.store(&mut to[k..]);
            }
            k += Of::<M, I>::COUNT;
        }
        0.0
    }
}

/// Random numbers of the particles from `k` of a piece on.
#[inline(always)]
fn noise_at<M: Mode, L: Lanes>(seed: u32, kicks: &Kicks<'_, M>, k: usize) -> [L; 3] {
    // The widest register holds 16 numbers.
    let mut numbers = [[L::Element::default(); 16]; 3];
    // Lanes that only fill up are of no particle.
    for (l, id) in kicks.ids[(kicks.first + k).min(kicks.ids.len())..].iter().take(L::COUNT).enumerate() {
        for (axis, number) in noise(seed, *id, kicks.step).into_iter().enumerate() {
            numbers[axis][l] = L::Element::of(number);
        }
    }
    [L::load(&numbers[0]), L::load(&numbers[1]), L::load(&numbers[2])]
}

/// Three coordinates of as many particles as there are lanes. (No closure: it might not be inlined, and then would be compiled
/// without the instruction set.)
#[inline(always)]
pub(super) fn lanes_at<E: Element, L: Lanes>(axes: [&[E]; 3]) -> [L; 3] {
    [E::lanes(axes[0]), E::lanes(axes[1]), E::lanes(axes[2])]
}
