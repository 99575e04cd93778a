//! The random walk of the energy that the step of the force at the cutoff makes: what `octant report` predicts, and what runs show.

#[path = "common/cli.rs"]
mod common;

use common::Folder;

const ATOMS: usize = 256;
const EDGE: f64 = 4.0;
const DENSITY: f64 = 0.8442;
/// Where the force is more than half of the most that it pulls with: the walk then stands out from the integrator's own noise.
const CUTOFF: f64 = 1.5;
const TEMPERATURES: [f64; 2] = [1.0, 1.5];
const STEPS: [f64; 2] = [0.002, 0.004];
const RUN: usize = 200_000;
/// Steps between looks at the energy, and at positions.
const LOOK: usize = 10;
const FRAME: usize = 500;
/// Distances of times between which the variance's growth is taken. The integrator's noise is forgotten at the shorter one, about
/// three times 1 / w, w being the Einstein frequency: from there on the variance is a straight line.
const LAGS: [f64; 2] = [0.2, 0.7];
/// Parts of a run that are looked at each by itself, for the error.
const PIECES: usize = 20;
/// Half the width of the shell in which pairs at the cutoff are counted, as a part of the cutoff.
const SHELL: f64 = 0.02;

/// A melted liquid, half of whose atoms have the last of the masses.
fn liquid(masses: &[f64]) -> String {
    let types = masses.len();
    let set: String = masses.iter().enumerate().map(|(k, mass)| format!("mass {} {mass}\n", k + 1)).collect();
    format!(
        "units lj\nlattice fcc {DENSITY}\nregion b block 0 {EDGE} 0 {EDGE} 0 {EDGE}\ncreate_box {types} b\n\
         create_atoms 1 box basis 3 {types} basis 4 {types}\n{set}velocity all create 2.4 87287 loop geom\n\
         pair_style lj/cut {CUTOFF}\npair_coeff * * 1.0 1.0\nneighbor 0.3 bin\nfix move all nve\ntimestep 0.004\nrun 2500\n"
    )
}

/// Growth of the variance of the energy, energy units squared a time unit, with so many pairs in the shell by how many of their atoms are
/// of the second type. Pairs that cross the cutoff at a radial velocity u, n <|u|> of them a time unit, n a length unit of distance, are
/// off by F u dt (1/2 - s) each, s being anywhere between 0 and 1.
fn walk_of(pairs: &[f64; 3], masses: &[f64], temperature: f64, dt: f64) -> f64 {
    // The force of LAMMPS's doc page pair_lj.
    let force = 24.0 * (2.0 * CUTOFF.powi(-13) - CUTOFF.powi(-7));
    let (first, last) = (masses[0], masses[masses.len() - 1]);
    let reduced = [0.5 * first, first * last / (first + last), 0.5 * last];
    let rate = |(pairs, reduced): (&f64, f64)| {
        let cubed = 2.0 * (2.0 / std::f64::consts::PI).sqrt() * (temperature / reduced).powf(1.5);
        pairs / (2.0 * SHELL * CUTOFF) * (force * dt).powi(2) / 12.0 * cubed
    };
    pairs.iter().zip(reduced).map(rate).sum()
}

/// What the study of a scene predicts: the growth, and the temperature it is for, by time step.
fn predict(folder: &Folder, script: &str) -> Vec<(f64, f64)> {
    folder.write("scene.in", script);
    folder.says("report scene.in --quick --backend cpu --threads 1 --python none --precision mixed --dt 0.002 --skin 0.3 --out out");
    let table = folder.read("out/energies.csv");
    let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let heads = lines.next().unwrap();
    let place = |name: &str| heads.iter().position(|head| *head == name).unwrap();
    let rows: Vec<Vec<&str>> = lines.collect();
    let walk = |dt: &f64| {
        let is = |row: &&Vec<&str>| {
            row[place("dt")] == dt.to_string() && row[place("potential")] == "own" && row[place("integrator")] == "own"
        };
        let row = rows.iter().find(is).unwrap_or_else(|| panic!("no row with {dt}: {table}"));
        let number = |name: &str| row[place(name)].parse::<f64>().unwrap();
        (number("walk_predicted") * (ATOMS as f64).powi(2), number("temperature"))
    };
    STEPS.iter().map(walk).collect()
}

/// What a run shows.
struct Measured {
    walk: f64,
    /// Standard error.
    error: f64,
    temperature: f64,
    /// Pairs in the shell, frame by frame, the first being the state that is studied.
    pairs: Vec<[f64; 3]>,
}

fn measure(folder: &Folder, script: &str, dt: f64) -> Measured {
    let run = format!(
        "{script}pair_modify shift yes\nthermo_style custom step etotal temp\nthermo_modify norm no format float %.15g\nthermo {LOOK}\n\
         dump frames all custom {FRAME} frames type x y z\ndump_modify frames format float %.17g\ntimestep {dt}\nrun {RUN}\n"
    );
    folder.write("run.in", &run);
    folder.says("run run.in --backend cpu --threads 1 --precision mixed --log log");
    let log = folder.read("log");
    let table = log.rsplit("TotEng").next().unwrap();
    let rows: Vec<[f64; 2]> = table
        .lines()
        .skip(1)
        .map_while(|line| {
            let words: Vec<f64> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
            <[f64; 3]>::try_from(words).ok().map(|[_, energy, temperature]| [energy, temperature])
        })
        .collect();
    assert_eq!(rows.len(), RUN / LOOK + 1);
    let growth = |rows: &[[f64; 2]]| {
        let [near, far] = LAGS.map(|lag| {
            let lag = (lag / (dt * LOOK as f64)).round() as usize;
            let squares = rows.windows(lag + 1).map(|w| (w[lag][0] - w[0][0]).powi(2));
            squares.sum::<f64>() / (rows.len() - lag) as f64
        });
        (far - near) / (LAGS[1] - LAGS[0])
    };
    // Pieces are long against the lags, and so independent of each other.
    let pieces: Vec<f64> = rows.chunks_exact(rows.len() / PIECES).map(growth).collect();
    let (walk, error) = mean_and_error(&pieces);
    let temperature = rows.iter().map(|row| row[1]).sum::<f64>() / rows.len() as f64;
    Measured { walk, error, temperature, pairs: pairs_at_cutoff(&folder.read("frames")) }
}

/// Of independent values; the error is the standard error.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / n / (n - 1.0)).sqrt())
}

/// Pairs near the cutoff by how many of their atoms are of the second type, in each frame.
fn pairs_at_cutoff(dump: &str) -> Vec<[f64; 3]> {
    let edge = EDGE * (4.0 / DENSITY).cbrt();
    let count = |frame: &str| {
        let lines = frame.lines().skip(1).take_while(|line| !line.starts_with("ITEM"));
        let x: Vec<Vec<f64>> = lines.map(|l| l.split_whitespace().map(|w| w.parse().unwrap()).collect()).collect();
        assert_eq!(x.len(), ATOMS);
        let near = |d: f64| d - edge * (d / edge).round();
        let mut counts = [0.0; 3];
        for (i, j) in (0..ATOMS).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let distance = (1..4).map(|a| near(x[i][a] - x[j][a]).powi(2)).sum::<f64>().sqrt();
            if (distance - CUTOFF).abs() < SHELL * CUTOFF {
                counts[(x[i][0] + x[j][0]) as usize - 2] += 1.0;
            }
        }
        counts
    };
    dump.split("ITEM: ATOMS type x y z").skip(1).map(count).collect()
}

#[test]
fn the_energy_walks_as_predicted() {
    // Alike, and of two masses: pairs of types then differ in their reduced masses.
    for masses in [&[1.0][..], &[1.0, 4.0]] {
        let folder = Folder::new(&format!("walk-{}", masses.len()));
        let script = liquid(masses);
        let mut ratios = Vec::new();
        for (dt, (predicted, at)) in STEPS.iter().zip(predict(&folder, &script)) {
            let found = measure(&folder, &script, *dt);
            assert!((TEMPERATURES[0]..TEMPERATURES[1]).contains(&found.temperature), "{}", found.temperature);
            // Eight digits stand in the table.
            let same = walk_of(&found.pairs[0], masses, at, *dt);
            assert!((predicted / same - 1.0).abs() < 1e-6, "{predicted} {same}");
            // At the run's own temperature, as many pairs as its frames have.
            let each: Vec<f64> =
                found.pairs.iter().map(|pairs| walk_of(pairs, masses, found.temperature, *dt)).collect();
            let (expected, scatter) = mean_and_error(&each);
            let ratio = found.walk / expected;
            let error = (found.error / expected).hypot(ratio * scatter / expected);
            println!("masses {masses:?}, dt {dt}: {ratio:.3} +- {error:.3} of what is expected");
            ratios.push((ratio, error));
        }
        let weight: f64 = ratios.iter().map(|(_, error)| error.powi(-2)).sum();
        let mean = ratios.iter().map(|(ratio, error)| ratio * error.powi(-2)).sum::<f64>() / weight;
        let error = weight.powf(-0.5);
        println!("masses {masses:?}: {mean:.3} +- {error:.3}");
        // Three standard errors and a half (an error from twenty pieces is known to a sixth of itself); runs long enough that a quarter
        // too much or too little would show. Growth with the square of the time step: each of both by itself.
        assert!(error < 0.07 && (mean - 1.0).abs() < 3.5 * error, "{mean} +- {error}");
        assert!(ratios.iter().all(|(ratio, error)| (ratio - 1.0).abs() < 3.5 * error), "{ratios:?}");
    }
}
