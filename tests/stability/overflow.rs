//! Particles so close or so fast that numbers end: what is not finite stops the run in words, and the words help.

use std::sync::atomic::AtomicBool;

use octant::dynamics::Fix;
use octant::engine::{FaultKind, Precision, Sums};
use octant::pair::styles;
use octant::system::{GROUP_ALL, State, Vec3};

use crate::cli::Folder;
use crate::common::{Noise, arc, free_or_periodic, program_of_style, told, variants};
use crate::rows::Case;
use crate::{ALL, advanced, fetched, smooth, started};

const SECTION: &str = "overflow";

fn are_finite(sums: &Sums, state: &State) -> bool {
    let numbers = [sums.potential].into_iter().chain(sums.virial);
    let vectors = [&state.x, &state.v, &state.f].into_iter().flatten().flat_map(|v| v.iter().copied());
    numbers.chain(vectors).all(f64::is_finite)
}

#[test]
fn forces_of_all_distances_are_right_or_stop_the_run() {
    let case = Case::new(SECTION, "a pair at 1 to 1e-320 sigma, every pair style");
    let space = free_or_periodic([0.0; 3], [12.0; 3], [true; 3]);
    let distances =
        [1.0, 0.5, 0.2, 0.1, 0.05, 0.01, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-13, 1e-20, 1e-30, 1e-100, 1e-320, 0.0];
    for variant in variants() {
        // How far apart positions may lie from where they were put: a quantum of fixed point or, in single precision, f32's
        // rounding relative to a cell.
        let off = match variant.precision {
            Precision::Double => 0.0,
            Precision::Mixed => 12.0 * 2f64.powi(-30),
            Precision::Single => 12.0 * 2f64.powi(-22),
        };
        for style in styles() {
            let mut program = program_of_style(&style, false, 1.0, 1.0);
            program.pair.shift = false;
            for r in distances {
                let mut state = State::default();
                // At zero, every distance is a number.
                state.push(1, 1, Vec3::new(0.0, 5.0, 5.0));
                state.push(2, 1, Vec3::new(r, 5.0, 5.0));
                let mut backend = variant.backend(1);
                backend.load(arc(program.clone()), &state, &space, 0).unwrap();
                match backend.set_up(ALL) {
                    Err(why) => {
                        let fault = why.fault().expect("a stop of the dynamics");
                        let named = (fault.kind, fault.id, fault.count) == (FaultKind::Force, 1, 2);
                        case.holds(&variant, "a stop names both atoms", named && fault.nearest.is_some());
                        // Where the force is a number of f32 and distances are told apart there is no reason to stop.
                        let value = program.pair.evaluate(0, 0, r).unwrap();
                        let needless = r > 4.0 * off && value.force_over_r.abs() < 1e30 && r > 1e-15;
                        case.holds(&variant, "forces that can be worked out do not stop a run", !needless);
                    }
                    Ok(()) => {
                        let (now, sums) = (fetched(&*backend), backend.sums().unwrap());
                        let finite = are_finite(&sums, &now);
                        case.holds(&variant, "forces, energy, virial are finite", finite);
                        let exact = program.pair.evaluate(0, 0, r).unwrap().force_over_r * r;
                        // Forces are as steep as r^-13, most of them less.
                        let steep = 13.0 * off / r;
                        if steep < 0.3 {
                            let error = ((now.f[1].x - exact) / exact.abs().max(1e-3)).abs();
                            let bound = 1.3 * steep + 10.0 * variant.tolerance.energy;
                            let reason = "13 times the rounding of positions over the distance, and of arithmetic";
                            case.check(&variant, "force error over its bound", error / bound, 1.0, reason);
                            let error =
                                (sums.virial[0] / (exact * r) - 1.0).abs().min((sums.virial[0] - exact * r).abs());
                            case.check(&variant, "virial error over its bound", error / (bound + steep), 1.0, reason);
                        }
                    }
                }
            }
        }
    }
}

/// Pairs 0.1 sigma apart in all directions, far from each other.
fn dimers(distance: f64) -> (State, octant::system::SimulationBox) {
    let mut state = State::default();
    let mut noise = Noise(31);
    for k in 0..64 {
        let place = 5.0 * Vec3::new(f64::from(k % 4), f64::from(k / 4 % 4), f64::from(k / 16)) + Vec3::repeat(2.5);
        let half = 0.5 * distance * noise.vector().normalize();
        for x in [place - half, place + half] {
            state.push(state.len() as u32 + 1, 1, x);
        }
    }
    (state, free_or_periodic([0.0; 3], [20.0; 3], [true; 3]))
}

#[test]
fn limited_steps_take_dimers_apart() {
    let case = Case::new(SECTION, "dimers at 0.1 sigma under fix nve/limit");
    let (state, space) = dimers(0.1);
    let mut program = smooth(0.005);
    program.fixes =
        vec![Fix { id: "1".into(), style: "nve/limit", group: GROUP_ALL, parameters: vec![0.02], ..Fix::default() }];
    for variant in variants() {
        let mut backend = started(&variant, &program, &state, &space);
        let now = advanced(&variant, &mut *backend, 400);
        case.holds(&variant, "everything is finite", are_finite(&backend.sums().unwrap(), &now));
        let closest = (0..now.len()).step_by(2).map(|k| (now.x[k] - now.x[k + 1]).norm()).fold(f64::INFINITY, f64::min);
        // Steps of 0.02 in opposite directions: 23 of them part a pair, which then flies on.
        case.check(&variant, "1 / least distance of a pair", 1.0 / closest, 1.0, "apart by sigma at least");
    }
}

fn script(atoms: &[[f64; 3]], more: &str) -> String {
    let mut text = String::from("units lj\nregion b block 0 10 0 10 0 10 units box\ncreate_box 1 b\n");
    for [x, y, z] in atoms {
        text += &format!("create_atoms 1 single {x} {y} {z}\n");
    }
    text + "mass 1 1\npair_style lj/cut 2.5\npair_coeff 1 1 1 1\n" + more
}

#[test]
fn a_stop_offers_what_helps() {
    let case = Case::new(SECTION, "what a stop offers");
    let at = |distance: f64| vec![[2.0, 3.0, 4.0], [5.0, 6.0, 7.0], [5.0, 6.0, 7.0 + distance]];
    let folder = Folder::new("advice");
    let fails = |words: &str, atoms: &[[f64; 3]], more: &str| {
        folder.write("a.in", &script(atoms, more));
        folder.fails(1, &format!("run a.in {words}"))
    };
    let nve = "fix 1 all nve\nrun 100\n";
    for (variant, words) in told() {
        let said = fails(&words, &at(0.1), nve);
        let limit = |said: &str| said.contains("fix nve/limit");
        case.holds(&variant, "0.1 sigma: fix nve/limit is offered", limit(&said));
        folder.write("b.in", &script(&at(0.1), "fix 1 all nve/limit 0.02\nrun 400\nunfix 1\nfix 1 all nve\nrun 100\n"));
        case.holds(&variant, "and helps", folder.says(&format!("run b.in {words}")).contains("Loop time"));

        let said = fails(&words, &at(0.0), nve);
        let coincident = !limit(&said) && said.contains("no direction");
        case.holds(&variant, "coincident atoms: fix nve/limit is not offered", coincident);

        // A force of 1e40.
        let said = fails(&words, &at(1e-3), nve);
        let double = said.contains("--precision double") || variant.precision == Precision::Double;
        case.holds(&variant, "forces beyond f32: double precision is offered, too", limit(&said) && double);
        let words = words.replace(variant.precision.name(), "double");
        folder
            .write("b.in", &script(&at(1e-3), "fix 1 all nve/limit 0.02\nrun 400\nunfix 1\nfix 1 all nve\nrun 100\n"));
        case.holds(&variant, "and helps", folder.says(&format!("run b.in {words}")).contains("Loop time"));
    }
}

#[test]
fn speeds_that_overflow_stop_the_run_whatever_the_policy() {
    let case = Case::new(SECTION, "speeds beyond the range of numbers");
    let space = free_or_periodic([0.0; 3], [12.0; 3], [true; 3]);
    // Positions that overflow at once, after some steps, and kinetic energies that do, which is for who looks at them to tell.
    let speeds = [(1e300, 1e10), (1e37, 3e3), (1e200, 1e-210), (1e30, 1e-40), (1e155, 1e-160)];
    for variant in variants() {
        for (v, timestep) in speeds {
            for (once, check) in [(false, true), (false, false), (true, true)] {
                let mut program = smooth(timestep);
                (program.policy.once, program.policy.check) = (once, check);
                program.policy.every = if check { 1 } else { 1000 };
                let mut state = State::default();
                state.push(1, 1, Vec3::new(3.0, 5.0, 5.0));
                state.push(2, 1, Vec3::new(4.1, 5.0, 5.0));
                state.v[0].x = -v;
                let mut backend = variant.backend(1);
                backend.load(arc(program), &state, &space, 0).unwrap();
                let end = backend.set_up(ALL).and_then(|()| backend.advance(20, ALL, &AtomicBool::new(false)));
                let fine = match end {
                    Err(why) => why.fault().is_some(),
                    Ok(_) => match backend.sums() {
                        Ok(sums) => are_finite(&sums, &fetched(&*backend)),
                        Err(_) => true,
                    },
                };
                let what = format!("v {v:e}, dt {timestep:e}, once {once}, check {check}: finite or a stop");
                case.holds(&variant, &what, fine);
            }
        }
    }
}

#[test]
fn energies_that_are_no_numbers_are_not_shown() {
    let case = Case::new(SECTION, "a kinetic energy beyond the range of numbers");
    let folder = Folder::new("energies");
    let atoms = [[2.0, 3.0, 4.0], [5.0, 6.0, 7.0]];
    folder.write("a.in", &script(&atoms, "velocity all set 1e200 0 0\nfix 1 all nve\ntimestep 1e-210\nrun 5\n"));
    for (variant, words) in told() {
        let said = folder.fails(1, &format!("run a.in {words}"));
        // In single precision the speed itself is none, which the set-up finds.
        let named = said.contains("step 0: the kinetic energy is beyond the range of numbers; the fastest is atom ")
            || said.contains("velocity of atom 1");
        case.holds(&variant, "a stop in words", named);
    }
}
