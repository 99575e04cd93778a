//! `octant info`.

use std::process::ExitCode;

use crate::Error;
use crate::neighbor::Search;

/// Prints version, devices, styles and formats.
pub fn info() -> Result<ExitCode, Error> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    println!("octant {}", env!("CARGO_PKG_VERSION"));
    println!("backends      cpu ({cores} cores)");
    println!("precisions    double");
    println!("searches      {}", Search::NAMES.join(", "));
    println!("pair styles");
    for style in crate::pair::styles() {
        let coefficients: Vec<_> = style.coefficients.iter().map(|c| c.name).collect();
        println!("  {:<12}  {}; pair_coeff I J {} [cutoff]", style.name, style.formula, coefficients.join(" "));
    }
    println!("fixes");
    for (name, syntax) in crate::dynamics::fixes() {
        println!("  {name:<12}  {syntax}");
    }
    let formats = crate::output::trajectory_formats();
    if formats.is_empty() {
        println!("trajectories  LAMMPS atom, custom, xyz (this build has no chemfiles)");
    } else {
        println!("trajectories  LAMMPS atom, custom, xyz; with chemfiles:");
        for format in formats {
            let velocities = if format.velocities { ", velocities" } else { "" };
            println!("  {:<20}  {}{velocities}", format.name, format.extension.as_deref().unwrap_or("(by name)"));
        }
    }
    Ok(ExitCode::SUCCESS)
}
