//! What stands below the thermo table at the end of a run: times, performance, neighbor statistics, in LAMMPS's layout
//! (doc page `Run_output`), which readers of logs know.

use super::printf::{format_f, format_g};
use crate::engine::NeighborStatistics;
use crate::system::Units;

/// Wall seconds of a run's loop by stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct StageTimes {
    /// Pair forces.
    pub pair: f64,
    /// List builds and the checks before them: the sum of the next three.
    pub neighbor: f64,
    /// Whether particles have moved too far.
    pub check: f64,
    /// Wrapping, and sorting into cells.
    pub sort: f64,
    /// Searching and listing neighbors.
    pub list: f64,
    /// Thermo rows and dumps.
    pub output: f64,
    /// Fixes: time integration and the like.
    pub modify: f64,
    /// The rest of the loop.
    pub other: f64,
}

impl StageTimes {
    /// Adds another run's times.
    pub fn add(&mut self, other: &Self) {
        self.pair += other.pair;
        self.neighbor += other.neighbor;
        self.check += other.check;
        self.sort += other.sort;
        self.list += other.list;
        self.output += other.output;
        self.modify += other.modify;
        self.other += other.other;
    }
}

/// A finished run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunSummary {
    pub units: &'static Units,
    /// Wall seconds of the loop.
    pub loop_seconds: f64,
    /// Processor seconds that the loop took over all threads; `None` where the system does not tell.
    pub cpu_seconds: Option<f64>,
    pub steps: i64,
    /// Timestep length, time units.
    pub timestep: f64,
    pub atoms: usize,
    pub threads: usize,
    pub stages: StageTimes,
    pub neighbors: NeighborStatistics,
}

impl RunSummary {
    /// The line that ends the thermo table.
    pub fn loop_line(&self) -> String {
        let seconds = format_g(self.loop_seconds, 0, 6, false);
        format!("Loop time of {seconds} on 1 procs for {} steps with {} atoms", self.steps, self.atoms)
    }

    /// The whole block, without the loop line if not `post` (`run ... post no`).
    pub fn lines(&self, post: bool) -> Vec<String> {
        let mut lines = vec![self.loop_line(), String::new()];
        if !post {
            return lines;
        }
        lines.extend(self.performance());
        lines.extend(self.processor_use());
        lines.push(String::new());
        lines.extend(self.breakdown());
        lines.push(String::new());
        lines.extend(self.histograms());
        lines.push(String::new());
        lines.extend(self.neighbor_lines());
        lines
    }

    /// Steps a second.
    pub fn steps_per_second(&self) -> f64 {
        if self.loop_seconds > 0.0 { self.steps as f64 / self.loop_seconds } else { 0.0 }
    }

    /// Simulated time a day, its inverse where that is usual, steps and atom steps a second. LAMMPS leaves the line
    /// out where no step was done, and in si units.
    fn performance(&self) -> Option<String> {
        const SECONDS_A_DAY: f64 = 86_400.0;
        const SECONDS_AN_HOUR: f64 = 3_600.0;
        const FEMTOSECONDS_A_NANOSECOND: f64 = 1e6;
        if self.steps <= 0 || self.loop_seconds <= 0.0 {
            return None;
        }
        let three = |x: f64| format_f(x, 0, 3, false);
        let rate = self.steps_per_second();
        let simulated = match self.units.name {
            "si" => return None,
            "lj" => format!("{} tau/day", three(rate * self.timestep * SECONDS_A_DAY)),
            _ => {
                let nanoseconds = rate * self.timestep / self.units.femtosecond / FEMTOSECONDS_A_NANOSECOND;
                let hours = 1.0 / (nanoseconds * SECONDS_AN_HOUR);
                format!("{} ns/day, {} hours/ns", three(nanoseconds * SECONDS_A_DAY), three(hours))
            }
        };
        let atom_steps = rate * self.atoms as f64;
        let (scaled, prefix) = match atom_steps {
            x if x >= 1e9 => (x / 1e9, "G"),
            x if x >= 1e6 => (x / 1e6, "M"),
            x if x >= 1e3 => (x / 1e3, "k"),
            x => (x, ""),
        };
        Some(format!("Performance: {simulated}, {} timesteps/s, {} {prefix}atom-step/s", three(rate), three(scaled)))
    }

    /// Left out where the system does not tell.
    fn processor_use(&self) -> Option<String> {
        let seconds = self.cpu_seconds?;
        let percent = if self.loop_seconds > 0.0 { seconds / self.loop_seconds * 100.0 } else { 0.0 };
        let percent = format_f(percent, 0, 1, false);
        Some(format!("{percent}% CPU use with 1 MPI tasks x {} OpenMP threads", self.threads))
    }

    fn breakdown(&self) -> Vec<String> {
        let percent = |seconds: f64| {
            let share = if self.loop_seconds > 0.0 { seconds / self.loop_seconds * 100.0 } else { 0.0 };
            format_f(share, 6, 2, false)
        };
        let row = |name: &str, seconds: f64| {
            let time = format_g(seconds, 10, 5, true);
            format!("{name:<8}| {time} | {time} | {time} |   0.0 |{}", percent(seconds))
        };
        let s = &self.stages;
        vec![
            "MPI task timing breakdown:".into(),
            "Section |  min time  |  avg time  |  max time  |%varavg| %total".into(),
            "---------------------------------------------------------------".into(),
            row("Pair", s.pair),
            row("Neigh", s.neighbor),
            // One process talks to nobody.
            row("Comm", 0.0),
            row("Output", s.output),
            row("Modify", s.modify),
            format!(
                "Other   |            | {} |            |       |{}",
                format_g(s.other, 10, 4, true),
                percent(s.other)
            ),
        ]
    }

    /// Spread over processes, of which there is one.
    fn histograms(&self) -> Vec<String> {
        let row = |name: &str, count: f64| {
            let n = format_g(count, 11, 6, false);
            [format!("{name:<11}{n} ave {n} max {n} min"), "Histogram: 1 0 0 0 0 0 0 0 0 0".into()]
        };
        let (atoms, pairs) = (self.atoms as f64, self.neighbors.pairs as f64);
        // No copies of atoms are made across periodic sides, hence no ghosts.
        [row("Nlocal:", atoms), row("Nghost:", 0.0), row("Neighs:", pairs)].into_iter().flatten().collect()
    }

    fn neighbor_lines(&self) -> Vec<String> {
        let n = &self.neighbors;
        let mut lines = vec![format!("Total # of neighbors = {}", n.pairs)];
        if self.atoms > 0 {
            let average = n.pairs as f64 / self.atoms as f64;
            lines.push(format!("Ave neighs/atom = {}", format_g(average, 0, 8, false)));
        }
        lines.push(format!("Neighbor list builds = {}", n.builds));
        lines.push(match n.dangerous {
            Some(dangerous) => format!("Dangerous builds = {dangerous}"),
            None => "Dangerous builds not checked".into(),
        });
        if n.redone > 0 {
            lines.push(format!("Arrays grown or grid moved, and steps redone, on the GPU = {}", n.redone));
        }
        lines
    }
}

/// The last line of a log.
pub fn wall_time_line(seconds: f64) -> String {
    let seconds = seconds.max(0.0) as u64;
    format!("Total wall time: {}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}

/// Processor seconds of this process so far, over all threads; `None` where the system does not tell.
pub fn cpu_seconds() -> Option<f64> {
    // Linux: fields 14 and 15 of /proc/self/stat, in ticks of 1/100 s (`man 5 proc`). The name in parentheses may hold blanks.
    const TICKS_A_SECOND: f64 = 100.0;
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let user: f64 = fields.next()?.parse().ok()?;
    let system: f64 = fields.next()?.parse().ok()?;
    Some((user + system) / TICKS_A_SECOND)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> RunSummary {
        RunSummary {
            units: Units::named("lj").unwrap(),
            loop_seconds: 0.0177972,
            cpu_seconds: Some(0.995 * 0.0177972),
            steps: 100,
            timestep: 0.005,
            atoms: 256,
            threads: 2,
            stages: StageTimes {
                pair: 0.0091109,
                neighbor: 0.0040378,
                check: 0.0000378,
                sort: 0.001,
                list: 0.003,
                output: 0.0035258,
                modify: 0.00034309,
                other: 0.000174,
            },
            neighbors: NeighborStatistics { builds: 9, dangerous: Some(0), pairs: 9621, redone: 0 },
        }
    }

    /// Numbers of a run of LAMMPS 22Jul2025, and its text but for threads, communication and ghosts.
    #[test]
    fn layout() {
        let expected = "\
Loop time of 0.0177972 on 1 procs for 100 steps with 256 atoms

Performance: 2427348.122 tau/day, 5618.861 timesteps/s, 1.438 Matom-step/s
99.5% CPU use with 1 MPI tasks x 2 OpenMP threads

MPI task timing breakdown:
Section |  min time  |  avg time  |  max time  |%varavg| %total
---------------------------------------------------------------
Pair    | 0.0091109  | 0.0091109  | 0.0091109  |   0.0 | 51.19
Neigh   | 0.0040378  | 0.0040378  | 0.0040378  |   0.0 | 22.69
Comm    | 0          | 0          | 0          |   0.0 |  0.00
Output  | 0.0035258  | 0.0035258  | 0.0035258  |   0.0 | 19.81
Modify  | 0.00034309 | 0.00034309 | 0.00034309 |   0.0 |  1.93
Other   |            | 0.000174   |            |       |  0.98

Nlocal:            256 ave         256 max         256 min
Histogram: 1 0 0 0 0 0 0 0 0 0
Nghost:              0 ave           0 max           0 min
Histogram: 1 0 0 0 0 0 0 0 0 0
Neighs:           9621 ave        9621 max        9621 min
Histogram: 1 0 0 0 0 0 0 0 0 0

Total # of neighbors = 9621
Ave neighs/atom = 37.582031
Neighbor list builds = 9
Dangerous builds = 0";
        assert_eq!(sample().lines(true).join("\n"), expected);
        assert_eq!(sample().lines(false), [sample().loop_line(), String::new()]);
    }

    #[test]
    fn performance_by_unit_system() {
        let of = |units: &str, timestep, atoms, loop_seconds| {
            let units = Units::named(units).unwrap();
            RunSummary { units, timestep, steps: 50, atoms, loop_seconds, ..sample() }.performance()
        };
        // Loop times of LAMMPS are rounded in its log, so the last digits of the rates differ.
        let metal = of("metal", 0.001, 2, 0.000101959).unwrap();
        assert_eq!(
            metal,
            "Performance: 42369.972 ns/day, 0.001 hours/ns, 490393.197 timesteps/s, 980.786 katom-step/s"
        );
        let real = of("real", 2.0, 2, 6.8425e-05).unwrap();
        assert_eq!(real, "Performance: 126269.638 ns/day, 0.000 hours/ns, 730727.073 timesteps/s, 1.461 Matom-step/s");
        assert!(of("lj", 1.0, 0, 1.0).unwrap().ends_with(" 50.000 timesteps/s, 0.000 atom-step/s"));
        assert!(of("lj", 1.0, 30_000_000, 1.0).unwrap().ends_with(" 1.500 Gatom-step/s"));
        assert_eq!(of("si", 1e-8, 2, 1.0), None);
        assert_eq!(RunSummary { steps: 0, ..sample() }.performance(), None);
    }

    #[test]
    fn lines_that_scenes_lack() {
        let empty = RunSummary { atoms: 0, neighbors: NeighborStatistics::default(), ..sample() };
        let expected = ["Total # of neighbors = 0", "Neighbor list builds = 0", "Dangerous builds not checked"];
        assert_eq!(empty.neighbor_lines(), expected);
        // A GPU that did not have to stop says nothing of it.
        let redone = |redone| RunSummary { neighbors: NeighborStatistics { redone, ..sample().neighbors }, ..sample() };
        let (without, with) = (redone(0).lines(true), redone(2).lines(true));
        assert_eq!(with[..without.len()], without);
        assert_eq!(with[without.len()..], ["Arrays grown or grid moved, and steps redone, on the GPU = 2"]);
        assert_eq!(redone(2).lines(false).len(), 2);
    }

    #[test]
    fn wall_time() {
        assert_eq!(wall_time_line(0.9), "Total wall time: 0:00:00");
        assert_eq!(wall_time_line(36_000.0 + 125.5), "Total wall time: 10:02:05");
    }
}
