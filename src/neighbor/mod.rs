//! Neighbor search: octant cell grid, search variants, rebuild policy; shared by all backends.

pub mod axis;
pub mod cells;
pub mod estimate;
pub mod guard;
pub mod plan;
pub mod policy;
mod radix;
pub mod search;
pub mod ties;

pub use cells::{Cells, OCTANTS};
pub use plan::{CellOrder, Search, SearchPlan, Sort};
pub use policy::{Decision, LAMMPS_BIN, Policy};
pub use search::{Grid, Key, Run};
