//! Which pairs belong into the list: exactly LAMMPS's, those whose distance at the build is at most R in f64.

use crate::engine::particles::Particles;
use crate::neighbor::guard;
use crate::neighbor::ties::Ties;
use crate::real::Isa;
use crate::real::lanes::{Lanes, Simd, SimdVisitor, with_simd};
use crate::system::SimulationBox;

/// Squared neighbor cutoffs by pair of types, and what exactness needs to know of the box.
#[derive(Clone, Debug, Default)]
pub struct Membership {
    pub types: usize,
    squared: Vec<f64>,
    pub lengths: [f64; 3],
    pub ties: Ties,
    /// Squared distances, in quanta, below which a pair certainly is in the list and above which it certainly is not.
    /// Rows of as many entries as there are types, filled up to a register.
    pub inner: Vec<f32>,
    pub outer: Vec<f32>,
    pub stride: usize,
    /// Largest of `outer`.
    pub reach: f32,
    pub quanta: f64,
}

impl Membership {
    /// `cutoffs` are the neighbor cutoffs R of each pair of types.
    pub fn update(&mut self, types: usize, cutoffs: &[f64], simulation_box: &SimulationBox, quanta: f64, isa: Isa) {
        self.types = types;
        self.stride = if types == 1 { 1 } else { types.max(lanes_of(isa)) };
        self.lengths = simulation_box.lengths().into();
        self.quanta = quanta;
        self.ties = Ties::new(cutoffs, simulation_box);
        self.squared.clear();
        self.squared.extend(cutoffs.iter().map(|r| r * r));
        let coordinate = simulation_box.lo.amax().max(simulation_box.hi.amax());
        for limits in [&mut self.inner, &mut self.outer] {
            limits.clear();
            limits.resize(types * self.stride, 0.0);
        }
        for (k, r) in cutoffs.iter().enumerate() {
            let at = k / types * self.stride + k % types;
            (self.inner[at], self.outer[at]) = guard::limits(*r, quanta, coordinate, 0.0);
        }
        self.reach = self.outer.iter().copied().fold(0.0, f32::max);
    }

    /// Whether j, seen in an image, is a neighbor of i.
    #[cold]
    pub fn holds(&self, particles: &Particles, i: usize, j: usize, image: [i32; 3]) -> bool {
        let (a, b) = (&particles.x[i], &particles.x[j]);
        let limit = self.squared[particles.kind[i] as usize * self.types + particles.kind[j] as usize];
        self.ties.hold(a, b, image, limit)
    }
}

/// Lanes that distances are tested in.
fn lanes_of(isa: Isa) -> usize {
    struct Count;
    impl SimdVisitor for Count {
        type Output = usize;
        fn visit<I: Simd>(self, _: I) -> usize {
            I::F32::COUNT
        }
    }
    with_simd(isa, Count)
}
