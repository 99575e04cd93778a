//! Values that others have published for the Lennard-Jones fluid.

use crate::cli::Folder;
use crate::common::told;
use crate::rows::{Case, is_full};

const SECTION: &str = "external truth";

/// Temperature, density, energy per atom and pressure by Monte Carlo of 500 particles, cut at 3 sigma with long-range corrections:
/// NIST Standard Reference Simulation Website, SRD 173, Lennard-Jones fluid (doi:10.18434/T4M88Q).
const NIST: [[f64; 4]; 3] =
    [[0.85, 0.776, -5.5121, 0.0068], [0.85, 0.82, -5.7947, 0.5536], [0.90, 0.776, -5.4689, 0.2406]];

const ATOMS: f64 = 500.0;

/// Atoms are melted hot, cooled, brought to rest and then looked at.
fn script([temperature, density, ..]: [f64; 4], modify: &str, steps: u64) -> String {
    format!(
        "units lj\nlattice fcc {density}\nregion box block 0 5 0 5 0 5\ncreate_box 1 box\ncreate_atoms 1 box\nmass 1 1.0\n\
         velocity all create 3.0 4711\npair_style lj/cut 3.0\npair_coeff 1 1 1.0 1.0\npair_modify {modify}\nneighbor 0.3 bin\n\
         timestep 0.002\nthermo 1000000\nfix 1 all nvt temp 3.0 {temperature} 0.2\nrun 5000\n\
         fix 1 all nvt temp {temperature} {temperature} 0.2\nrun 5000\n\
         thermo_style custom step temp pe press\nthermo_modify format float %.17g\nthermo 20\nrun {steps}\n"
    )
}

/// Temperature, energy and pressure from row to row.
fn measured(folder: &Folder, script: &str, words: &str) -> Vec<[f64; 3]> {
    folder.write("a.in", script);
    let said = folder.says(&format!("run a.in {words}"));
    let table = said.rsplit("Step ").next().unwrap();
    let rows = table.lines().skip(1).take_while(|line| !line.starts_with("Loop time"));
    let numbers = |line: &str| line.split_whitespace().map(|w| w.parse().unwrap()).collect::<Vec<f64>>();
    rows.map(|line| <[f64; 3]>::try_from(&numbers(line)[1..]).unwrap()).collect()
}

/// Weighted mean of a series and its standard error from means of 20 blocks.
fn mean(series: &[f64], weights: &[f64]) -> (f64, f64) {
    let whole = weights.iter().sum::<f64>();
    let middle = series.iter().zip(weights).map(|(x, w)| x * w).sum::<f64>() / whole;
    let off: Vec<f64> = series.iter().zip(weights).map(|(x, w)| w * (x - middle)).collect();
    let blocks = off.chunks_exact(off.len() / 20).take(20).map(|block| block.iter().sum::<f64>() / whole);
    (middle, (blocks.map(|block| block.powi(2)).sum::<f64>() * 20.0 / 19.0).sqrt())
}

/// What dynamics gives, as Monte Carlo has it: energy and pressure with their standard errors.
///
/// Forces that end at the cutoff are those of energies shifted to zero there, and so it is the ensemble of these that dynamics
/// samples. Monte Carlo decides by energies that jump: each pair within the cutoff counts U(cutoff) more, and configurations have
/// weights exp(-pairs U(cutoff) / T) over those of dynamics. The same trajectory with the energy of either form tells them. And
/// where the momentum is zero, the kinetic pressure is that of N - 1 atoms.
fn as_monte_carlo(point: [f64; 4], tail: &[[f64; 3]], shift: &[[f64; 3]]) -> [(f64, f64); 2] {
    let [temperature, density, ..] = point;
    // Tail corrections are the same for all rows, and weights are of differences.
    let jumps: Vec<f64> = tail.iter().zip(shift).map(|(a, b)| -ATOMS * (a[1] - b[1]) / temperature).collect();
    let middle = jumps.iter().sum::<f64>() / jumps.len() as f64;
    let weights: Vec<f64> = jumps.iter().map(|jump| (jump - middle).exp()).collect();
    let column = |k: usize| tail.iter().map(|row| row[k]).collect::<Vec<f64>>();
    let (pressure, error) = mean(&column(2), &weights);
    [mean(&column(1), &weights), (pressure + density * temperature / ATOMS, error)]
}

#[test]
fn energies_and_pressures_are_those_of_nist() {
    let (points, steps) = if is_full() { (3, 500_000) } else { (1, 10_000) };
    let folder = Folder::new("nist");
    for (variant, words) in told() {
        let mut all = [(0.0, 0.0); 2];
        for point in &NIST[..points] {
            let [temperature, density, ..] = *point;
            let name = match (temperature, density) {
                (0.85, 0.776) => "NIST, Lennard-Jones, T 0.85, density 0.776, rc 3 with tail corrections",
                (0.85, _) => "NIST, Lennard-Jones, T 0.85, density 0.82, rc 3 with tail corrections",
                _ => "NIST, Lennard-Jones, T 0.90, density 0.776, rc 3 with tail corrections",
            };
            let case = Case::new(SECTION, name);
            let [tail, shift] = ["tail yes", "shift yes"].map(|m| measured(&folder, &script(*point, m, steps), &words));
            assert_eq!(tail.len() as u64, steps / 20 + 1);
            let same = tail.iter().zip(&shift).all(|(a, b)| a[0] == b[0]);
            case.holds(&variant, "energies shifted at the cutoff leave the trajectory as it is", same);
            let found = as_monte_carlo(*point, &tail, &shift);
            for ((what, other), (expected, ((found, error), all))) in
                OTHER.into_iter().zip(point[2..].iter().zip(found.into_iter().zip(&mut all)))
            {
                let measured = format!("{what} {found:.4} +- {error:.4}, NIST {expected}: difference");
                case.check(&variant, &measured, (found - expected).abs(), 4.0 * error + other, REASON);
                *all = (all.0 + (found - expected) / points as f64, all.1 + (error / points as f64).powi(2));
            }
        }
        // What errs to one side at every point shows in the mean.
        let case = Case::new(SECTION, "NIST, Lennard-Jones, mean of all differences");
        for ((what, other), (off, square)) in OTHER.into_iter().zip(all) {
            let measured = format!("{what} off by {off:.4} +- {:.4}", square.sqrt());
            case.check(&variant, &measured, off.abs(), 4.0 * square.sqrt() + other, REASON);
        }
    }
}

/// What else energy and pressure may be off by. NIST's own standard error of U is 4.6e-4 (at the first point), and P errs with U, four
/// to five times as much. Velocity Verlet at this temperature of the velocities has positions hotter by (omega dt)^2 / 4, omega^2 = 270
/// or so: 2.3e-4, and so 2e-4 in U and 1.1e-3 in P, by the derivatives between NIST's two temperatures.
const OTHER: [(&str, f64); 2] = [("U", 7e-4), ("P", 3.1e-3)];

const REASON: &str = "4 standard errors, NIST's own, and the timestep's shift of the distribution";
