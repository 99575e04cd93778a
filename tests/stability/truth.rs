//! Values that others have published for the Lennard-Jones fluid.

use crate::cli::Folder;
use crate::common::told;
use crate::rows::{Case, is_full};

const SECTION: &str = "external truth";

/// Temperature, density, energy per atom and pressure, cut at 3 sigma or farther with long-range corrections: NIST Standard
/// Reference Simulation Website, SRD 173, Lennard-Jones fluid (doi:10.18434/T4M88Q).
const NIST: [[f64; 4]; 3] =
    [[0.85, 0.776, -5.5121, 0.0068], [0.85, 0.82, -5.7947, 0.5536], [0.90, 0.776, -5.4689, 0.2406]];

/// 500 atoms are melted hot, cooled, brought to rest and then looked at.
fn script([temperature, density, ..]: [f64; 4], steps: u64) -> String {
    format!(
        "units lj\nlattice fcc {density}\nregion box block 0 5 0 5 0 5\ncreate_box 1 box\ncreate_atoms 1 box\nmass 1 1.0\n\
         velocity all create 3.0 4711\npair_style lj/cut 3.0\npair_coeff 1 1 1.0 1.0\npair_modify tail yes\nneighbor 0.3 bin\n\
         timestep 0.002\nthermo 1000000\nfix 1 all nvt temp 3.0 {temperature} 0.2\nrun 5000\n\
         fix 1 all nvt temp {temperature} {temperature} 0.2\nrun 5000\n\
         thermo_style custom step temp pe press\nthermo_modify format float %.10g\nthermo 20\nrun {steps}\n"
    )
}

/// Mean of a series and its standard error from means of 10 blocks.
fn mean(series: &[f64]) -> (f64, f64) {
    let mean = |some: &[f64]| some.iter().sum::<f64>() / some.len() as f64;
    let blocks: Vec<f64> = series.chunks_exact(series.len() / 10).map(mean).collect();
    let (middle, n) = (mean(&blocks), blocks.len() as f64);
    let square = blocks.iter().map(|b| (b - middle).powi(2)).sum::<f64>();
    (middle, (square / (n - 1.0) / n).sqrt())
}

#[test]
fn energies_and_pressures_are_those_of_nist() {
    let (points, steps) = if is_full() { (3, 200_000) } else { (1, 10_000) };
    let folder = Folder::new("nist");
    for point in &NIST[..points] {
        let [temperature, density, energy, pressure] = *point;
        folder.write("a.in", &script(*point, steps));
        let name = match (temperature, density) {
            (0.85, 0.776) => "NIST, Lennard-Jones, T 0.85, density 0.776, rc 3 with tail corrections",
            (0.85, _) => "NIST, Lennard-Jones, T 0.85, density 0.82, rc 3 with tail corrections",
            _ => "NIST, Lennard-Jones, T 0.90, density 0.776, rc 3 with tail corrections",
        };
        let case = Case::new(SECTION, name);
        for (variant, words) in told() {
            let said = folder.says(&format!("run a.in {words}"));
            let table = said.rsplit("Step ").next().unwrap();
            let rows = table.lines().skip(1).take_while(|line| !line.starts_with("Loop time"));
            let rows: Vec<Vec<f64>> =
                rows.map(|l| l.split_whitespace().map(|w| w.parse().unwrap()).collect()).collect();
            assert_eq!(rows.len() as u64, steps / 20 + 1, "{said}");
            let column = |k: usize| rows.iter().map(|row| row[k]).collect::<Vec<f64>>();
            // A timestep shifts what is sampled by (omega dt)^2 / 8 or so of T, omega^2 = 250; the last digits are NIST's.
            for (what, k, expected, other) in [("U", 2, energy, 1e-3), ("P", 3, pressure, 3e-3)] {
                let (found, error) = mean(&column(k));
                let measured = format!("{what} {found:.4} +- {error:.4}, NIST {expected}: difference");
                let reason = "4 standard errors, and a timestep's shift of the distribution with NIST's last digits";
                case.check(&variant, &measured, (found - expected).abs(), 4.0 * error + other, reason);
            }
        }
    }
}
