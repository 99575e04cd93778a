//! Which settings broke the scene, in few words: settings that differ in precision and skin alone make one row.

use super::content::{named, short};
use super::front::Found;

/// Points with the same potential, integrator, time step and rebuild policy, at least one of which broke.
struct Group<'a> {
    broken: Vec<&'a Found>,
    /// How many of these settings were measured.
    measured: usize,
}

/// Heads of the table.
pub const HEADS: [&str; 7] =
    ["potential", "integrator", "precision", "dt", "neigh_modify", "broke", "what happened first"];

/// A row for each group with a point that broke.
pub fn rows(points: &[Found]) -> Vec<Vec<String>> {
    let mut groups: Vec<Group> = Vec::new();
    for point in points.iter().filter(|p| !p.fault.is_empty()) {
        match groups.iter_mut().find(|group| key(group.broken[0]) == key(point)) {
            Some(group) => group.broken.push(point),
            None => {
                let measured = points.iter().filter(|p| key(p) == key(point)).count();
                groups.push(Group { broken: vec![point], measured });
            }
        }
    }
    groups.iter().map(Group::row).collect()
}

fn key(point: &Found) -> (&str, &str, u64, &str) {
    (&point.potential, &point.integrator, point.dt.to_bits(), &point.rebuild)
}

impl Group<'_> {
    fn row(&self) -> Vec<String> {
        let first = self.broken.iter().min_by_key(|p| step(&p.fault).unwrap_or(u64::MAX)).expect("one broke");
        let mut precisions: Vec<&str> = Vec::new();
        for point in &self.broken {
            if !precisions.contains(&point.precision.as_str()) {
                precisions.push(&point.precision);
            }
        }
        vec![
            named(&first.potential),
            named(&first.integrator),
            precisions.join(", "),
            first.dt.to_string(),
            first.rebuild.clone(),
            format!("{} of {}", self.broken.len(), self.measured),
            rounded(&first.fault),
        ]
    }
}

/// The step that a fault is of.
fn step(fault: &str) -> Option<u64> {
    fault.strip_prefix("step ")?.split(':').next()?.parse().ok()
}

/// A message with four digits of its numbers; whole numbers stay as they are.
fn rounded(message: &str) -> String {
    let word = |word: &str| -> String {
        let bare = word.trim_matches(|c: char| "(),;:".contains(c));
        match bare.parse::<f64>() {
            Ok(x) if bare.contains('.') => word.replacen(bare, &short(x), 1),
            _ => word.to_string(),
        }
    };
    message.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_in_precision_and_skin_is_one_row() {
        let point = |precision: &str, skin: f64, dt: f64, fault: &str| Found {
            potential: "own".into(),
            integrator: "nve/euler2".into(),
            precision: precision.into(),
            dt,
            skin,
            rebuild: "every 1 delay 0 check yes".into(),
            fault: fault.into(),
            ..Found::default()
        };
        let late = "step 30: lost atom 7 at (1.23456789, -2.0, 1e-3); at step 29 it was at (0.5, 100.123456, 2.5)";
        let early = "step 4: lost atom 9 at (12.3456789, 5.25, -0.001)";
        let points = [
            point("mixed", 0.3, 0.1, late),
            point("mixed", 0.6, 0.1, early),
            point("double", 0.3, 0.1, late),
            point("double", 0.6, 0.1, ""),
            point("mixed", 0.3, 0.2, late),
            point("mixed", 0.3, 0.05, ""),
        ];
        let rows = rows(&points);
        assert_eq!(rows.len(), 2);
        let cells = ["script's", "nve/euler2", "mixed, double", "0.1", "every 1 delay 0 check yes", "3 of 4"];
        assert_eq!(rows[0][..6], cells);
        assert_eq!(rows[0][6], "step 4: lost atom 9 at (12.35, 5.25, -0.001)");
        assert_eq!(
            rows[1][5..],
            ["1 of 1", "step 30: lost atom 7 at (1.235, -2, 1e-3); at step 29 it was at (0.5, 100.1, 2.5)"]
        );
    }
}
