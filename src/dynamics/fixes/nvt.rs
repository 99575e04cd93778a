//! `fix nvt`: velocity Verlet coupled to a chain of Nose and Hoover's thermostats (LAMMPS doc page `fix_nh`; G. J. Martyna,
//! M. L. Klein and M. Tuckerman 1992, doi:10.1063/1.463940). The chain is integrated as M. E. Tuckerman et al. 2006
//! (doi:10.1088/0305-4470/39/19/019) split its propagator: half a step before velocities and positions move, half a step after.
//! As in LAMMPS the masses of the chain follow the temperature aimed at, and a half step takes the kinetic energy that
//! the one before has left.

use crate::dynamics::thermostat::{Group, Moment};
use crate::dynamics::{
    no_variable, nve, target_temperature, temperatures, Balance, FixArguments, FixScene, FixStyle, Given, Motion,
    Phase, Step,
};
use crate::real::Real;
use crate::script::{Args, Complaint};

/// As `nve`, velocities scaled by the chain.
pub struct Style;

/// Most links of the chain, and most parts of a half step.
const MOST: i64 = 10;
/// Bits of [`Given::choice`] that hold the number of links; those above hold the number of parts.
const BITS: u32 = 8;

/// Links of the chain, and parts that each half step is integrated in.
fn numbers(choice: u32) -> (usize, usize) {
    ((choice & ((1 << BITS) - 1)) as usize, (choice >> BITS) as usize)
}

/// The thermostat's constants at a moment.
struct Chain<R> {
    /// Boltzmann's constant times the temperature aimed at, energy units.
    energy: R,
    /// Degrees of freedom of the first link's bath: the others have one.
    freedom: R,
    /// Inverse damping time.
    frequency: R,
}

impl<R: Real> Chain<R> {
    #[inline(always)]
    fn new(energy: R, group: &Group<R>, given: &Given<'_, R>) -> Self {
        Self { energy, freedom: group.freedom, frequency: given.parameters[2] }
    }

    /// Twice the kinetic energy that a link's bath aims at, and the link's mass, energy times time squared.
    #[inline(always)]
    fn aim(&self, link: usize) -> R {
        if link == 0 {
            self.freedom * self.energy
        } else {
            self.energy
        }
    }
    #[inline(always)]
    fn mass(&self, link: usize) -> R {
        self.aim(link) / (self.frequency * self.frequency)
    }

    /// Acceleration of a link by what it is coupled to: the particles' doubled kinetic energy, or the speed of the link before.
    #[inline(always)]
    fn push(&self, link: usize, kinetic: R, speeds: &[R]) -> R {
        let driving = if link == 0 { kinetic } else { self.mass(link - 1) * speeds[link - 1] * speeds[link - 1] };
        // A single particle has no degree of freedom, and its bath no mass: nothing pushes it.
        let (mass, none) = (self.mass(link), R::constant(0.0));
        R::select(none.less(mass), (driving - self.aim(link)) / mass, none)
    }
}

/// How much the next link slows a link down in an eighth of a step.
#[inline(always)]
fn friction<R: Real>(speeds: &[R], link: usize, eighth: R) -> R {
    match speeds.get(link + 1) {
        Some(next) => (-(eighth * *next)).exp(),
        None => R::constant(1.0),
    }
}

impl FixStyle for Style {
    const NAME: &'static str = "nvt";
    const SYNTAX: &'static str = "fix ID GROUP nvt temp TSTART TSTOP TDAMP [tchain N] [tloop N] [drag D]";
    const PHASES: &'static [Phase] = &[Phase::Initial, Phase::Last, Phase::Measured];
    const BALANCE: Balance = Balance::Bath([0, 1]);

    /// Parameters: temperatures at the start and the end of a run, inverse damping time, drag, Boltzmann's constant, energy in
    /// units of mass times velocity squared.
    fn parse(args: &mut Args<'_>, scene: &FixScene<'_>) -> Result<FixArguments, Complaint> {
        let (mut bath, mut links, mut parts, mut drag) = (None, 3, 1, 0.0);
        let few = |args: &mut Args<'_>, what: &str| {
            let word = args.position();
            match args.integer(what, 1)? {
                n if n > MOST => Err(Complaint::new(word, format!("expected {what} of at most {MOST}, got '{n}'"))),
                n => Ok(n as u32),
            }
        };
        let end = args.position();
        while args.left() > 0 {
            let word = args.position();
            match args.text("a keyword")? {
                "temp" => {
                    let (start, stop) = temperatures(args)?;
                    if start <= 0.0 || stop <= 0.0 {
                        let at = if start <= 0.0 { word + 1 } else { word + 2 };
                        return Err(Complaint::new(at, "expected a temperature above 0, got '0'"));
                    }
                    no_variable(args, "the damping time")?;
                    bath = Some((start, stop, args.number_where("a damping time", "above 0", |t| t > 0.0)?));
                }
                "tchain" => links = few(args, "a length of the chain")?,
                "tloop" => parts = few(args, "a number of parts of a step")?,
                "drag" => drag = args.number_where("a drag", "of at least 0", |d| d >= 0.0)?,
                other => {
                    let message =
                        format!("fix nvt {other} is not part of octant; available: temp, tchain, tloop, drag");
                    return Err(Complaint::new(word, message));
                }
            }
        }
        let Some((start, stop, damp)) = bath else {
            return Err(Complaint::new(end - 1, "fix nvt needs temp TSTART TSTOP TDAMP"));
        };
        let parameters = vec![start, stop, 1.0 / damp, drag, scene.units.boltzmann, scene.units.mvv2e];
        Ok(FixArguments { choice: links | parts << BITS, parameters })
    }

    /// Doubled kinetic energy of the group, Boltzmann's constant times the temperature aimed at; positions, speeds and
    /// accelerations of the links.
    fn memory_size(choice: u32) -> usize {
        2 + 3 * numbers(choice).0
    }

    #[inline(always)]
    fn thermostat<R: Real>(moment: Moment, memory: &mut [R], group: &Group<R>, given: &Given<'_, R>) -> R {
        let (links, parts) = numbers(given.choice);
        let [start, stop, frequency, drag, boltzmann, unit] = [0, 1, 2, 3, 4, 5].map(|k| given.parameters[k]);
        if moment != Moment::EndOfStep {
            memory[1] = boltzmann * target_temperature(start, stop, given.progress);
        }
        let chain = Chain::new(memory[1], group, given);
        let (kinetic, rest) = memory.split_at_mut(2);
        let (places, rest) = rest.split_at_mut(links);
        let (speeds, pushes) = rest.split_at_mut(links);
        let mut energy = kinetic[0];
        if moment != Moment::StartOfStep {
            energy = group.kinetic * unit;
        }
        if moment == Moment::SetUp {
            for (link, push) in pushes.iter_mut().enumerate() {
                *push = chain.push(link, energy, speeds);
            }
            kinetic[0] = energy;
            return R::constant(1.0);
        }
        let part = group.dt * R::constant(1.0 / parts as f64);
        let [half, quarter, eighth] = [0.5, 0.25, 0.125].map(|p| part * R::constant(p));
        let drag = R::constant(1.0) - part * frequency * drag;
        let mut scale = R::constant(1.0);
        pushes[0] = chain.push(0, energy, speeds);
        for _ in 0..parts {
            for link in (0..links).rev() {
                let slower = friction(speeds, link, eighth);
                speeds[link] = (speeds[link] * slower + pushes[link] * quarter) * drag * slower;
            }
            let factor = (-(half * speeds[0])).exp();
            scale = scale * factor;
            energy = energy * (factor * factor);
            for link in 0..links {
                places[link] = places[link] + half * speeds[link];
            }
            for link in 0..links {
                let slower = friction(speeds, link, eighth);
                pushes[link] = chain.push(link, energy, speeds);
                speeds[link] = (speeds[link] * slower + pushes[link] * quarter) * slower;
            }
        }
        kinetic[0] = energy;
        scale
    }

    #[inline(always)]
    fn bath_energy<R: Real>(memory: &[R], group: &Group<R>, given: &Given<'_, R>) -> R {
        let chain = Chain::new(memory[1], group, given);
        let links = numbers(given.choice).0;
        let mut energy = R::constant(0.0);
        for link in 0..links {
            let (place, speed) = (memory[2 + link], memory[2 + links + link]);
            energy = energy + chain.aim(link) * place + R::constant(0.5) * chain.mass(link) * speed * speed;
        }
        energy
    }

    #[inline(always)]
    fn initial<R: Real>(motion: &mut Motion<R>, step: &Step<R>, given: &Given<'_, R>) {
        Self::measured(motion, given);
        nve::Style::initial(motion, step, given);
    }

    #[inline(always)]
    fn last<R: Real>(motion: &mut Motion<R>, step: &Step<R>, given: &Given<'_, R>) {
        nve::Style::last(motion, step, given);
    }

    #[inline(always)]
    fn measured<R: Real>(motion: &mut Motion<R>, given: &Given<'_, R>) {
        for v in &mut motion.v {
            *v = *v * given.scale;
        }
    }
}
