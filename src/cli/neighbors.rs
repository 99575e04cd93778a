//! `octant neighbors`.

use std::fmt::Write as _;
use std::process::ExitCode;

use super::NeighborArgs;
use crate::Error;
use crate::session::{self, Settings};

/// Counts neighbors and prints their statistics; `--counts` writes them atom by atom, in order of id.
pub fn neighbors(args: NeighborArgs) -> Result<ExitCode, Error> {
    let settings = Settings {
        variables: args.script.variables,
        backend: args.backend.into(),
        threads: args.threads.unwrap_or(0).into(),
        search: args.search,
        ..Settings::default()
    };
    let found = session::neighbors(&args.script.script, &settings, args.cutoff)?;
    let counts = || found.counts.iter().map(|(_, n)| u64::from(*n));
    let total: u64 = counts().sum();
    let atoms = found.counts.len();
    say!("search        {} ({})", settings.search, found.grid);
    say!("cutoff        {}", found.radius);
    say!("atoms         {atoms}");
    say!("pairs         {}", total / 2);
    say!(
        "neighbors     mean {:.6}, least {}, most {}",
        total as f64 / atoms as f64,
        counts().min().unwrap_or(0),
        counts().max().unwrap_or(0)
    );
    if let Some(path) = args.counts {
        let mut text = String::from("# id neighbors\n");
        for (id, count) in &found.counts {
            let _ = writeln!(text, "{id} {count}");
        }
        std::fs::write(&path, text).map_err(|e| Error::file(&path, "cannot write", e))?;
        say!("counts        {}", path.display());
    }
    Ok(ExitCode::SUCCESS)
}
