//! What formulas may ask of the simulation.

/// A number a formula got from the simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    pub value: f64,
    /// False while the script is only judged and the value depends on dynamics that has not run: `value` is then a stand-in.
    pub known: bool,
}

impl Quantity {
    pub fn known(value: f64) -> Self {
        Self { value, known: true }
    }
}

/// The simulation as seen from the script. Errors are plain words; the script gives them their place.
pub trait Environment {
    /// A thermo keyword such as `temp`; `Ok(None)` where there is no such keyword.
    fn thermo(&mut self, keyword: &str) -> Result<Option<Quantity>, String>;
    /// A group function of equal-style formulas: `count(all)`, `mass(g)`, `xcm(g,x)`, `vcm(g,x)`, `ke(g)`, `bound(g,xmin)`;
    /// `Ok(None)` where there is no such function.
    fn group(&mut self, function: &str, args: &[&str]) -> Result<Option<Quantity>, String>;
    /// First and last step that `ramp`, `vdisplace` and the like count from: those of the run in progress (or its `start` and
    /// `stop`), both 0 between runs.
    fn run_range(&mut self) -> (i64, i64) {
        (0, 0)
    }
}

/// An environment with no simulation in it.
pub struct NoSimulation;

impl Environment for NoSimulation {
    fn thermo(&mut self, _: &str) -> Result<Option<Quantity>, String> {
        Ok(None)
    }
    fn group(&mut self, _: &str, _: &[&str]) -> Result<Option<Quantity>, String> {
        Ok(None)
    }
}
