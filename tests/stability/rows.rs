//! Rows of the table of stability: with OCTANT_STABILITY_ROWS set, each check adds a line of JSON to that file, and it is for
//! the reader of the file to say that one has failed; without, a check that fails ends its test.

use std::fs::OpenOptions;
use std::io::Write;

use octant::engine::Precision;
use serde_json::json;

use crate::common::{Engine, Variant};

/// Whether the long form was asked for (OCTANT_STABILITY=full).
pub fn is_full() -> bool {
    std::env::var("OCTANT_STABILITY").is_ok_and(|form| form == "full")
}

/// A row's first two columns.
#[derive(Clone, Copy)]
pub struct Case {
    pub section: &'static str,
    pub name: &'static str,
}

impl Case {
    pub const fn new(section: &'static str, name: &'static str) -> Self {
        Self { section, name }
    }

    /// Something measured that must not be above a bound; `reason` says where the bound comes from.
    pub fn check(&self, variant: &Variant, measured: &str, value: f64, bound: f64, reason: &str) {
        let Self { section, name } = self;
        let holds = value <= bound;
        if let Ok(path) = std::env::var("OCTANT_STABILITY_ROWS") {
            // Numbers that are none have no JSON of their own.
            let number = |x: f64| if x.is_finite() { json!(x) } else { json!(x.to_string()) };
            let (backend, precision) = (backend(variant), variant.precision.name());
            let (value, bound) = (number(value), number(bound));
            let row = json!({
                "section": section, "case": name, "backend": backend, "precision": precision, "variant": variant.name,
                "measured": measured, "value": value, "bound": bound, "holds": holds, "reason": reason,
            });
            let mut file = OpenOptions::new().create(true).append(true).open(&path).unwrap();
            // In one piece: tests run side by side.
            file.write_all(format!("{row}\n").as_bytes()).unwrap();
        } else {
            assert!(holds, "{section}, {name}, {}: {measured} {value:e}, at most {bound:e} ({reason})", variant.name);
        }
    }

    /// Something that holds or does not.
    pub fn holds(&self, variant: &Variant, what: &str, holds: bool) {
        self.check(variant, &format!("not: {what}"), if holds { 0.0 } else { 1.0 }, 0.0, "holds or does not");
    }
}

fn backend(variant: &Variant) -> &'static str {
    match variant.engine {
        Engine::Cpu(_) => "cpu",
        #[cfg(feature = "cuda")]
        Engine::Cuda(_) => "cuda",
    }
}

/// One rounding of a position relative to its size, and of a force: what a step's arithmetic errs by.
pub fn rounding(precision: Precision) -> (f64, f64) {
    let (f64s, f32s) = (f64::EPSILON, f64::from(f32::EPSILON));
    match precision {
        Precision::Double => (f64s, f64s),
        // Pairs read positions in quanta of 1e-8 of a cell or so, which is finer than f32.
        Precision::Mixed => (f64s, f32s),
        Precision::Single => (f32s, f32s),
    }
}
