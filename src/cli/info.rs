//! `octant info`.

use std::process::ExitCode;

use crate::Error;
use crate::engine::Precision;
use crate::neighbor::Search;
use crate::real::Isa;

/// Prints version, devices, styles and formats.
pub fn info() -> Result<ExitCode, Error> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    say!("octant {}", env!("CARGO_PKG_VERSION"));
    let sets: Vec<_> = Isa::ALL.into_iter().filter(|isa| isa.is_available()).map(Isa::name).collect();
    say!("backends      cpu ({cores} cores; {})", sets.join(", "));
    #[cfg(feature = "cuda")]
    match crate::engine::cuda::devices() {
        Ok(devices) => {
            for device in devices {
                say!("              cuda device {device}");
            }
            match crate::engine::cuda::inspect::compiler() {
                Ok(version) => {
                    say!("              NVRTC {version}");
                }
                Err(reason) => {
                    say!("              no NVRTC: {reason}");
                }
            }
        }
        Err(reason) => {
            say!("              no cuda: {reason}");
        }
    }
    say!("precisions    {} (default mixed)", Precision::ALL.map(Precision::name).join(", "));
    say!("searches      {}", Search::NAMES.join(", "));
    say!("pair styles");
    for style in crate::pair::styles() {
        say!("  {:<12}  {}", style.name, style.formula);
        say!("  {:<12}  {}", "", style.usage());
    }
    say!("fixes");
    for (name, syntax) in crate::dynamics::fixes() {
        say!("  {name:<12}  {syntax}");
    }
    let formats = crate::output::trajectory_formats();
    if formats.is_empty() {
        say!("trajectories  LAMMPS atom, custom, xyz (this build has no chemfiles)");
    } else {
        say!("trajectories  LAMMPS atom, custom, xyz; with chemfiles:");
        for format in formats {
            let velocities = if format.velocities { ", velocities" } else { "" };
            say!("  {:<20}  {}{velocities}", format.name, format.extension.as_deref().unwrap_or("(by name)"));
        }
    }
    Ok(ExitCode::SUCCESS)
}
