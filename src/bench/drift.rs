//! Drift of the total energy.

/// Slope of a straight line through points in even steps, least squares, and its standard error, in which neighbors that scatter to
/// the same side count as less than two points; `None` for fewer than three points.
pub fn slope(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = points.len();
    if n < 3 {
        return None;
    }
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let xx: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let xy: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let slope = xy / xx;
    let off: Vec<f64> = points.iter().map(|p| p.1 - y - slope * (p.0 - x)).collect();
    let squares: f64 = off.iter().map(|d| d * d).sum();
    let lagged: f64 = off.windows(2).map(|two| two[0] * two[1]).sum();
    // Correlation from point to point, as of a process whose memory fades by this factor a step.
    let r = if squares > 0.0 { (lagged / squares).clamp(0.0, 0.95) } else { 0.0 };
    Some((slope, (squares / (n - 2) as f64 / xx * (1.0 + r) / (1.0 - r)).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::slope;

    #[test]
    fn a_line_and_a_line_with_scatter() {
        let line: Vec<(f64, f64)> = (0..5).map(|k| (f64::from(k), 3.0 - 0.5 * f64::from(k))).collect();
        let (b, error) = slope(&line).unwrap();
        assert!((b + 0.5).abs() < 1e-15 && error < 1e-15);
        // By hand: slope 0.4, residuals 0.2, -0.6, 0.6, -0.2 about the line 1.1 + 0.4 x; 0.8 / 2 / 5.
        let (b, error) = slope(&[(0.0, 1.3), (1.0, 0.9), (2.0, 2.5), (3.0, 2.1)]).unwrap();
        assert!((b - 0.4).abs() < 1e-12 && (error - 0.08f64.sqrt()).abs() < 1e-12);
        assert_eq!(slope(&line[..2]), None);
        // A slow wave has a memory, a fast one has none.
        let slow: Vec<(f64, f64)> = (0..100).map(|k| (f64::from(k), (f64::from(k) / 10.0).sin())).collect();
        let fast: Vec<(f64, f64)> = (0..100).map(|k| (f64::from(k), (f64::from(k * k) / 10.0).sin())).collect();
        assert!(slope(&slow).unwrap().1 > 3.0 * slope(&fast).unwrap().1);
    }
}
