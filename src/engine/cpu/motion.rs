//! The per-particle rules: fixes, displacement check, kinetic sums.

use rayon::prelude::*;

use super::particles::{Particles, Site};
use crate::dynamics::{Fix, FixStyle, FixVisitor, Motion, Step, with_fix};
use crate::system::Vec3;

/// Particles handled as one piece of work; also the unit of partial sums, so it must not depend on threads.
const CHUNK: usize = 1024;

/// Constants all particles share in a step.
pub struct Kicks<'a> {
    /// Timestep, time units.
    pub dt: f64,
    /// dt / 2 / mass by type.
    pub half: &'a [f64],
}

/// A fix compiled for the CPU.
pub trait FixKernel: Send + Sync {
    /// Before the force.
    fn initial(&self, particles: &mut Particles, kicks: &Kicks<'_>);
    /// After the force.
    fn last(&self, particles: &mut Particles, kicks: &Kicks<'_>);
}

/// The kernel of a fix.
pub fn fix_kernel(fix: &Fix) -> Option<Box<dyn FixKernel>> {
    struct Compile<'a>(&'a Fix);
    impl FixVisitor for Compile<'_> {
        type Output = Box<dyn FixKernel>;
        fn visit<F: FixStyle>(self) -> Self::Output {
            let style = std::marker::PhantomData::<F>;
            Box::new(Kernel { group: self.0.group, parameters: self.0.parameters.clone(), style })
        }
    }
    with_fix(fix.style, Compile(fix))
}

struct Kernel<F> {
    group: u32,
    parameters: Vec<f64>,
    style: std::marker::PhantomData<F>,
}

impl<F: FixStyle> Kernel<F> {
    #[inline(always)]
    fn apply(&self, particles: &mut Particles, kicks: &Kicks<'_>, rule: impl Fn(&mut Motion<f64>, &Step<f64>) + Sync) {
        let sites = particles.site.par_chunks_mut(CHUNK);
        let velocities = particles.v.par_chunks_mut(CHUNK);
        let forces = particles.f.par_chunks(CHUNK);
        let masks = particles.mask.par_chunks(CHUNK);
        sites.zip(velocities).zip(forces.zip(masks)).for_each(|((sites, velocities), (forces, masks))| {
            for (((site, v), f), mask) in sites.iter_mut().zip(velocities).zip(forces).zip(masks) {
                if mask & self.group != 0 {
                    let mut motion = Motion { x: site.x, v: (*v).into(), f: (*f).into() };
                    rule(&mut motion, &Step { dt: kicks.dt, half_kick: kicks.half[site.kind as usize] });
                    site.x = motion.x;
                    *v = motion.v.into();
                }
            }
        });
    }
}

impl<F: FixStyle> FixKernel for Kernel<F> {
    fn initial(&self, particles: &mut Particles, kicks: &Kicks<'_>) {
        self.apply(particles, kicks, |motion, step| F::initial(motion, step, &self.parameters));
    }

    fn last(&self, particles: &mut Particles, kicks: &Kicks<'_>) {
        self.apply(particles, kicks, |motion, step| F::last(motion, step, &self.parameters));
    }
}

/// Has any particle moved further than the square root of `trigger` since `then`?
pub fn moved(now: &[Site], then: &[Site], trigger: f64) -> bool {
    let far = |(a, b): (&Site, &Site)| {
        let d = [a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]];
        let squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        // A position that is no number calls for a build, which finds it.
        squared > trigger || squared.is_nan()
    };
    now.par_chunks(CHUNK).zip(then.par_chunks(CHUNK)).any(|(now, then)| now.iter().zip(then).any(far))
}

/// Sum of m v_a v_b in mass times velocity squared: xx, yy, zz, xy, xz, yz.
pub fn kinetic_sums(site: &[Site], v: &[Vec3], masses: &[f64]) -> [f64; 6] {
    let chunk_sums = |(sites, velocities): (&[Site], &[Vec3])| {
        let mut t = [0.0; 6];
        for (s, v) in sites.iter().zip(velocities) {
            let m = masses[s.kind as usize];
            let products = [v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z];
            for (total, product) in t.iter_mut().zip(products) {
                *total += m * product;
            }
        }
        t
    };
    let partial: Vec<[f64; 6]> = site.par_chunks(CHUNK).zip(v.par_chunks(CHUNK)).map(chunk_sums).collect();
    let mut total = [0.0; 6];
    for part in partial {
        for (t, p) in total.iter_mut().zip(part) {
            *t += p;
        }
    }
    total
}
