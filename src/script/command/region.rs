//! `region ID style args keyword values ...` (LAMMPS doc page `region`).

use crate::script::{Args, Complaint, Name};

/// One limit of a region along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// At a coordinate, in the region's units.
    At(f64),
    /// `INF`: no limit.
    Infinite,
    /// `EDGE`: at the side of the box.
    Edge,
}

/// The shape of a region, lengths in the region's units.
#[derive(Clone, Debug, PartialEq)]
pub enum RegionShape {
    /// `[axis][low, high]`.
    Block {
        limits: [[Limit; 2]; 3],
    },
    Sphere {
        center: [f64; 3],
        radius: f64,
    },
    /// `center` holds the coordinates on the other two axes, in the order x, y, z.
    Cylinder {
        axis: usize,
        center: [f64; 2],
        radius: f64,
        limits: [Limit; 2],
    },
    Union(Vec<Name>),
    Intersect(Vec<Name>),
}

/// A `region` command.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionCommand {
    pub name: Name,
    pub action: RegionAction,
}

/// What a `region` command does.
#[derive(Clone, Debug, PartialEq)]
pub enum RegionAction {
    Define {
        shape: RegionShape,
        /// `side in` (the default) against `side out`.
        inside: bool,
        /// `units lattice` (the default) against `units box`.
        lattice_units: bool,
    },
    /// `region ID delete`.
    Delete,
}

/// Word of a block's or cylinder's first argument.
pub const FIRST_ARGUMENT: usize = 3;

impl RegionCommand {
    /// Reads the arguments.
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let name = args.name("a region ID")?;
        let word = args.position();
        let shape = match args.text("a region style")? {
            "delete" => {
                args.done()?;
                return Ok(Self { name, action: RegionAction::Delete });
            }
            "block" => block(args)?,
            "sphere" => {
                let mut center = [0.0; 3];
                for c in &mut center {
                    *c = coordinate(args, "a coordinate of the center")?;
                }
                RegionShape::Sphere { center, radius: radius(args, "of at least 0", |r| r >= 0.0)? }
            }
            "cylinder" => {
                let axis = args.choice("the cylinder's axis", &["x", "y", "z"])?;
                let center = [coordinate(args, "a center coordinate")?, coordinate(args, "a center coordinate")?];
                let radius = radius(args, "above 0", |r| r > 0.0)?;
                RegionShape::Cylinder { axis, center, radius, limits: [limit(args)?, limit(args)?] }
            }
            "union" => RegionShape::Union(names(args)?),
            "intersect" => RegionShape::Intersect(names(args)?),
            other => {
                return Err(Complaint::new(
                    word,
                    format!(
                        "region style '{other}' is not part of octant; available: block, sphere, cylinder, union, intersect"
                    ),
                ));
            }
        };
        let (mut inside, mut lattice_units) = (true, true);
        while args.left() > 0 {
            let word = args.position();
            match args.text("a keyword")? {
                "side" => inside = args.choice("the side", &["in", "out"])? == 0,
                "units" => lattice_units = args.choice("units", &["lattice", "box"])? == 0,
                other @ ("move" | "rotate" | "open") => {
                    return Err(Complaint::new(word, format!("region keyword '{other}' is not part of octant")));
                }
                other => return Err(Complaint::new(word, format!("expected side or units, got '{other}'"))),
            }
        }
        Ok(Self { name, action: RegionAction::Define { shape, inside, lattice_units } })
    }
}

fn block(args: &mut Args<'_>) -> Result<RegionShape, Complaint> {
    let mut limits = [[Limit::Infinite; 2]; 3];
    for pair in &mut limits {
        let word = args.position();
        *pair = [limit(args)?, limit(args)?];
        if let [Limit::At(lo), Limit::At(hi)] = *pair
            && lo > hi
        {
            return Err(Complaint::new(word, format!("the low limit {lo} lies above the high limit {hi}")));
        }
    }
    Ok(RegionShape::Block { limits })
}

fn limit(args: &mut Args<'_>) -> Result<Limit, Complaint> {
    match args.peek() {
        Some("INF") => args.text("a limit").map(|_| Limit::Infinite),
        Some("EDGE") => args.text("a limit").map(|_| Limit::Edge),
        _ => coordinate(args, "a limit, INF or EDGE").map(Limit::At),
    }
}

fn coordinate(args: &mut Args<'_>, what: &str) -> Result<f64, Complaint> {
    no_variable(args)?;
    args.number(what)
}

fn radius(args: &mut Args<'_>, bound: &str, ok: impl Fn(f64) -> bool) -> Result<f64, Complaint> {
    no_variable(args)?;
    args.number_where("a radius", bound, ok)
}

fn no_variable(args: &Args<'_>) -> Result<(), Complaint> {
    match args.peek() {
        Some(text) if text.starts_with("v_") => Err(Complaint::new(
            args.position(),
            format!("a region that follows a variable ('{text}') is not part of octant"),
        )),
        _ => Ok(()),
    }
}

fn names(args: &mut Args<'_>) -> Result<Vec<Name>, Complaint> {
    let count = args.integer("the number of regions", 2)?;
    (0..count).map(|_| args.name("a region ID")).collect()
}
