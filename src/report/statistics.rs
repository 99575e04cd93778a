//! Numbers from series: error bars of correlated values, orders of convergence, random walks.

use crate::bench::drift;

/// Fewest blocks of which a scatter is taken.
const LEAST_BLOCKS: usize = 10;

/// Mean of a series and its standard error: neighbors are averaged pair by pair, again and again, until blocks no longer know of each
/// other (H. Flyvbjerg and H. G. Petersen 1989, doi:10.1063/1.457480); the largest error of the levels that have ten blocks or more.
/// `None` for fewer than ten values.
pub fn blocked(values: &[f64]) -> Option<(f64, f64)> {
    if values.len() < LEAST_BLOCKS {
        return None;
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let (mut blocks, mut error) = (values.to_vec(), 0.0f64);
    while blocks.len() >= LEAST_BLOCKS {
        let n = blocks.len() as f64;
        let middle = blocks.iter().sum::<f64>() / n;
        let squares: f64 = blocks.iter().map(|x| (x - middle).powi(2)).sum();
        error = error.max((squares / (n * (n - 1.0))).sqrt());
        blocks = blocks.chunks_exact(2).map(|two| 0.5 * (two[0] + two[1])).collect();
    }
    Some((mean, error))
}

/// Order of convergence: slope of log(error) over log(step), least squares, and its standard error from the scatter about the line (0 for
/// two points). `None` for fewer than two points.
pub fn order(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let logs: Vec<(f64, f64)> = points.iter().map(|(h, e)| (h.ln(), e.ln())).collect();
    let n = logs.len() as f64;
    let (x, y) = (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let xx: f64 = logs.iter().map(|p| (p.0 - x).powi(2)).sum();
    if logs.len() < 2 || xx == 0.0 {
        return None;
    }
    let slope = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / xx;
    let squares: f64 = logs.iter().map(|p| (p.1 - y - slope * (p.0 - x)).powi(2)).sum();
    let error = if logs.len() > 2 { (squares / (n - 2.0) / xx).sqrt() } else { 0.0 };
    slope.is_finite().then_some((slope, error))
}

/// Root mean square distance of points from the straight line through them; 0 for fewer than three.
pub fn about_line(points: &[(f64, f64)]) -> f64 {
    let Some((slope, _)) = drift::slope(points) else { return 0.0 };
    let n = points.len() as f64;
    let (x, y) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    (points.iter().map(|p| (p.1 - y - slope * (p.0 - x)).powi(2)).sum::<f64>() / n).sqrt()
}

/// How fast the variance of a series of points in even steps grows with the distance of two points, and the standard error: what a
/// random walk adds in a unit of time. The longer distance is an eighth of the series, the shorter one a fortieth: noise that is bounded
/// and forgotten within `memory` adds the same to both. An estimate from overlapping distances of m steps in n scatters by
/// sqrt(4 m / 3 n) of itself. `None` for fewer than eighty points, and where a fortieth of the series is shorter than the memory.
pub fn walk(points: &[(f64, f64)], memory: f64) -> Option<(f64, f64)> {
    let (near, far) = (points.len() / 40, points.len() / 8);
    if far < 10 || points[near].0 - points[0].0 < memory {
        return None;
    }
    let variance = |lag: usize| {
        let steps = points.windows(lag + 1).map(|w| (w[lag].1 - w[0].1).powi(2));
        steps.sum::<f64>() / (points.len() - lag) as f64
    };
    let time = points[far].0 - points[near].0;
    let scatter = (4.0 * far as f64 / (3.0 * (points.len() - far) as f64)).sqrt();
    Some(((variance(far) - variance(near)) / time, variance(far) * scatter / time))
}

/// Standard deviation of the slope of a straight line through a random walk whose variance grows by `rate` in a unit of time, after a time:
/// (6 D / 5 T)^(1/2), as a weighted sum of its steps has it.
pub fn slope_of_walk(rate: f64, time: f64) -> f64 {
    if rate > 0.0 && time > 0.0 { (1.2 * rate / time).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::RanPark;

    #[test]
    fn slopes_of_walks_scatter_as_told() {
        let (walks, steps) = (400, 200);
        let noise = noise(walks * steps);
        let slopes = noise.chunks(steps).map(|chunk| {
            let mut place = 0.0;
            let points = chunk.iter().enumerate().map(|(k, step)| {
                place += step;
                (0.5 * k as f64, place)
            });
            let (slope, told) = drift::slope(&points.collect::<Vec<_>>()).unwrap();
            (slope * slope, told * told)
        });
        let (squares, told): (Vec<f64>, Vec<f64>) = slopes.unzip();
        let rms = |of: &[f64]| (of.iter().sum::<f64>() / walks as f64).sqrt();
        // A twelfth each step, two steps a unit of time; 400 squares scatter by sqrt(2 / 400), their root by half of that.
        let expected = slope_of_walk(1.0 / 6.0, 0.5 * steps as f64);
        assert!((rms(&squares) / expected - 1.0).abs() < 0.12, "{} {expected}", rms(&squares));
        // The residuals of one line do not tell.
        assert!(rms(&told) < 0.7 * expected);
        assert_eq!((slope_of_walk(0.0, 1.0), slope_of_walk(-1.0, 1.0)), (0.0, 0.0));
    }

    fn noise(count: usize) -> Vec<f64> {
        let mut random = RanPark::new(4711);
        (0..count).map(|_| random.uniform() - 0.5).collect()
    }

    #[test]
    fn error_bars_know_of_correlation() {
        let independent = noise(4096);
        let (mean, error) = blocked(&independent).unwrap();
        // The variance of a uniform number is 1/12; the largest of nine levels lies above it, the one of ten blocks by up to a half.
        let expected = (1.0 / 12.0 / 4096.0f64).sqrt();
        assert!(mean.abs() < 4.0 * expected && (0.95..1.8).contains(&(error / expected)), "{mean} {error}");
        // The same values sixteen times each are no more of them.
        let repeated: Vec<f64> = independent.iter().flat_map(|x| [*x; 16]).collect();
        let (same, longer) = blocked(&repeated).unwrap();
        assert!((same - mean).abs() < 1e-12 && (longer / error - 1.0).abs() < 0.05, "{longer} {error}");
        assert_eq!(blocked(&independent[..9]), None);
    }

    #[test]
    fn orders_are_slopes_of_logarithms() {
        let exact: Vec<(f64, f64)> = [0.1, 0.2, 0.4].map(|h: f64| (h, 3.0 * h.powf(2.0))).to_vec();
        let (slope, error) = order(&exact).unwrap();
        assert!((slope - 2.0).abs() < 1e-12 && error < 1e-12);
        // By hand, in powers of two: points (0, 0), (1, 2), (2, 2); slope 1, off the line by -1/3, 2/3, -1/3: (2/3 / 1 / 2)^1/2.
        let (slope, error) = order(&[(1.0, 1.0), (2.0, 4.0), (4.0, 4.0)]).unwrap();
        assert!((slope - 1.0).abs() < 1e-12 && (error - (1.0f64 / 3.0).sqrt()).abs() < 1e-12, "{slope} {error}");
        assert_eq!(order(&exact[..1]), None);
        assert_eq!(order(&[(0.1, 1.0), (0.1, 2.0)]), None);
    }

    #[test]
    fn a_walk_is_told_from_bounded_noise() {
        let (steps, jitter) = (noise(8000), noise(16000));
        let mut place = 0.0;
        let walked: Vec<(f64, f64)> = steps
            .iter()
            .enumerate()
            .map(|(k, step)| {
                place += step;
                (0.5 * k as f64, place + 3.0 * jitter[8000 + k])
            })
            .collect();
        // A twelfth each step, two steps a unit of time.
        let (rate, error) = walk(&walked, 100.0).unwrap();
        assert!((rate - 1.0 / 6.0).abs() < 3.0 * error && error < 0.2, "{rate} {error}");
        let bounded: Vec<(f64, f64)> = jitter[..8000].iter().enumerate().map(|(k, x)| (0.5 * k as f64, *x)).collect();
        let (rate, _) = walk(&bounded, 100.0).unwrap();
        assert!(rate.abs() < 1e-4, "{rate}");
        // A fortieth of 8000 points, half a unit of time apart.
        assert_eq!((walk(&bounded[..79], 0.0), walk(&bounded, 100.1)), (None, None));
        let line: Vec<(f64, f64)> = (0..9).map(|k| (f64::from(k), 2.0 * f64::from(k) + f64::from(k % 2))).collect();
        assert!((about_line(&line) - (20.0f64 / 81.0).sqrt()).abs() < 1e-12);
    }
}
