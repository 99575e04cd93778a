//! Fixes as CUDA C: rules for a particle, and what thermostats make of the kinetic energy of their group.

use super::shape::Shape;
use crate::dynamics::thermostat::{Group, Moment, Thermostat};
use crate::dynamics::{Fix, FixStyle, FixVisitor, Given, INWARD, Motion, Phase, Push, Step, noise, with_fix};
use crate::real::{Arithmetic, Expr, Real, Recording};
use crate::system::GROUP_ALL;

/// `fixes_initial`, `fixes_force`, `fixes_last` and, for thermostats, `fixes_measured`: all fixes of the scene, one after the other. What is done to positions that
/// have moved belongs to the first.
pub fn fix_formulas(fixes: &[Fix], shape: &Shape) -> String {
    let store = if shape.double_store { Arithmetic::F64 } else { Arithmetic::F32 };
    let real = if shape.double_pairs { Arithmetic::F64 } else { Arithmetic::F32 };
    let moving = "store x[3], store v[3], const store f[3], store dt, store half_kick, u32 mask";
    let pushed = if shape.noise { ", const real v[3], real dt, real progress, u32 id, i64 step" } else { "" };
    let scales = if shape.thermostats > 0 { ", const double* scales" } else { "" };
    let mut functions: Vec<(&str, String, &[Phase], Arithmetic)> = vec![
        ("fixes_initial", format!("{moving}, const double* origin{scales}"), &[Phase::Initial, Phase::Moved], store),
        ("fixes_force", format!("real f[3], real mass, u32 mask{pushed}"), &[Phase::Force], real),
        ("fixes_last", moving.into(), &[Phase::Last], store),
    ];
    if shape.thermostats > 0 {
        functions.push(("fixes_measured", format!("store v[3], u32 mask{scales}"), &[Phase::Measured], store));
    }
    let mut text = if shape.noise { noise::cuda_text() } else { String::new() };
    for (name, arguments, phases, arithmetic) in functions {
        text += &format!("__device__ __forceinline__ void {name}({arguments}, const Scene& s) {{\n");
        for phase in phases {
            let (mut first, mut scale) = (0, 0);
            for fix in fixes {
                if fix.acts(*phase) {
                    let relative = !shape.double_store;
                    let trace = TraceFix { fix, first, scale, phase: *phase, arithmetic, relative };
                    let body = with_fix(fix.style, trace).expect("the fix is registered");
                    let condition =
                        if fix.group == GROUP_ALL { String::new() } else { format!("if (mask & {}u) ", fix.group) };
                    text += &format!("    {condition}{{ // fix {}\n{body}    }}\n", fix.style);
                }
                first += fix.parameters.len();
                scale += usize::from(fix.memory_size() > 0);
            }
        }
        text += "}\n";
    }
    if shape.thermostats > 0 { text + &thermostat_formulas(fixes) } else { text }
}

/// Numbers that all thermostats keep on the device: of each its degrees of freedom, then what its fix keeps.
pub fn bath_numbers(fixes: &[Fix]) -> usize {
    Thermostat::all(fixes).iter().map(|thermostat| 1 + thermostat.memory.len()).sum()
}

/// `thermostats_end` and `thermostats_start`: what is done at the end of a step, when kinetic energies are known, and at the
/// start of the next; and the groups of all thermostats.
fn thermostat_formulas(fixes: &[Fix]) -> String {
    let all = Thermostat::all(fixes);
    let groups: Vec<String> = all.iter().map(|thermostat| format!("{}u", thermostat.group)).collect();
    let mut text = format!("__constant__ const u32 THERMOSTAT_GROUPS[THERMOSTATS] = {{{}}};\n", groups.join(", "));
    let functions = [
        ("thermostats_end", "const double* kinetic", Moment::EndOfStep),
        ("thermostats_start", "double progress", Moment::StartOfStep),
    ];
    for (name, argument, moment) in functions {
        text += &format!(
            "__device__ __noinline__ void {name}(double* bath, {argument}, const Scene& s, double* scales) {{\n"
        );
        let mut bath = 0;
        for (place, thermostat) in all.iter().enumerate() {
            let fix = &fixes[thermostat.place];
            let first = fixes[..thermostat.place].iter().map(|fix| fix.parameters.len()).sum();
            let trace = TraceThermostat { fix, first, bath, place, moment };
            let body = with_fix(fix.style, trace).expect("the fix is registered");
            text += &format!("    {{ // fix {}\n{body}    }}\n", fix.style);
            bath += 1 + thermostat.memory.len();
        }
        text += "}\n";
    }
    text
}

/// A moment of a thermostat as CUDA C.
struct TraceThermostat<'a> {
    fix: &'a Fix,
    /// Its first parameter among those of all fixes, and its first number in the bath.
    first: usize,
    bath: usize,
    /// Its place among thermostats.
    place: usize,
    moment: Moment,
}

impl FixVisitor for TraceThermostat<'_> {
    type Output = String;
    fn visit<F: FixStyle>(self) -> String {
        let Self { fix, first, bath, place, moment } = self;
        let tape = Recording::start();
        let names: Vec<String> = (0..fix.memory_size()).map(|k| format!("bath[{}]", bath + 1 + k)).collect();
        let mut memory: Vec<Expr> = names.iter().map(|name| tape.input(name.as_str())).collect();
        let number = |k| tape.input(format!("s.fix_parameters[{}]", first + k));
        let parameters: Vec<Expr> = (0..fix.parameters.len()).map(number).collect();
        let kinetic = tape.input(format!("kinetic[{place}]"));
        let group = Group { kinetic, freedom: tape.input(format!("bath[{bath}]")), dt: tape.input("s.dt") };
        let given = Given { progress: tape.input("progress"), ..Given::new(fix.choice, &parameters) };
        let scale = F::thermostat(moment, &mut memory, &group, &given);
        let scaled = format!("scales[{place}]");
        let outputs = names.iter().map(String::as_str).zip(memory).chain([(scaled.as_str(), scale)]);
        tape.print(&outputs.collect::<Vec<_>>(), Arithmetic::F64, "t")
    }
}

/// One phase of a fix as CUDA C.
struct TraceFix<'a> {
    fix: &'a Fix,
    /// Its first parameter among those of all fixes.
    first: usize,
    /// Its place among thermostats, if it is one.
    scale: usize,
    phase: Phase,
    arithmetic: Arithmetic,
    /// Positions are displacements from `origin`.
    relative: bool,
}

impl FixVisitor for TraceFix<'_> {
    type Output = String;
    fn visit<F: FixStyle>(self) -> String {
        let Self { fix, first, scale, phase, arithmetic, relative } = self;
        let tape = Recording::start();
        let three = |name: &str| std::array::from_fn(|a| tape.input(format!("{name}[{a}]")));
        let mut motion = Motion { x: three("x"), v: three("v"), f: three("f") };
        let step = Step { dt: tape.input("dt"), half_kick: tape.input("half_kick") };
        let kind = if phase == Phase::Force { "real" } else { "store" };
        let number = |k| {
            let value = format!("s.fix_parameters[{}]", first + k);
            tape.input(match F::coordinate(k) {
                Some(axis) if relative => format!("({kind})(({value} - origin[{axis}]) * {INWARD:e})"),
                _ => format!("({kind}){value}"),
            })
        };
        let parameters: Vec<Expr> = (0..fix.parameters.len()).map(number).collect();
        let (choice, progress) = (fix.choice, tape.input("progress"));
        let scale = match fix.memory_size() {
            0 => Expr::constant(1.0),
            _ => tape.input(format!("({kind})scales[{scale}]")),
        };
        let given = Given { choice, parameters: &parameters, progress, scale };
        let (mass, dt) = (tape.input("mass"), step.dt);
        let mut push = Push { f: motion.f, v: motion.v, mass, dt, noise: three("noise") };
        let seed = F::NOISE.filter(|_| phase == Phase::Force).map_or(String::new(), |k| {
            format!("    real noise[3];\n    noise_of((u32)s.fix_parameters[{}], id, step, noise);\n", first + k)
        });
        match phase {
            Phase::Initial => F::initial(&mut motion, &step, &given),
            Phase::Moved => F::moved(&mut motion, &step, &given),
            Phase::Force => {
                F::force(&mut push, &given);
                motion.f = push.f;
            }
            Phase::Last => F::last(&mut motion, &step, &given),
            Phase::Measured => F::measured(&mut motion, &given),
        }
        let names = ["x[0]", "x[1]", "x[2]", "v[0]", "v[1]", "v[2]", "f[0]", "f[1]", "f[2]"];
        let values = motion.x.into_iter().chain(motion.v).chain(motion.f);
        seed + &tape.print(&names.into_iter().zip(values).collect::<Vec<_>>(), arithmetic, "t")
    }
}
