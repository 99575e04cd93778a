//! The `octant` program.

fn main() -> std::process::ExitCode {
    octant::cli::main()
}
