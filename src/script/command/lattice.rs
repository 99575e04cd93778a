//! `lattice style scale keyword values ...` (LAMMPS doc page `lattice`).

use crate::script::{Args, Complaint};

/// Which unit cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LatticeStyle {
    None,
    Sc,
    Bcc,
    Fcc,
    Hcp,
    Diamond,
    Custom,
}

const STYLES: [(&str, LatticeStyle); 7] = [
    ("none", LatticeStyle::None),
    ("sc", LatticeStyle::Sc),
    ("bcc", LatticeStyle::Bcc),
    ("fcc", LatticeStyle::Fcc),
    ("hcp", LatticeStyle::Hcp),
    ("diamond", LatticeStyle::Diamond),
    ("custom", LatticeStyle::Custom),
];

/// A `lattice` command.
#[derive(Clone, Debug, PartialEq)]
pub struct LatticeCommand {
    pub style: LatticeStyle,
    /// Reduced density in lj units, lattice constant otherwise; above 0.
    pub scale: f64,
    /// Shift in lattice spacings, each in [0, 1).
    pub origin: [f64; 3],
    /// Lattice directions along x, y and z of the box.
    pub orient: [[i64; 3]; 3],
    /// Spacings set by hand, before scaling.
    pub spacing: Option<[f64; 3]>,
    /// `custom`: primitive vectors a1, a2, a3 set by hand.
    pub primitive: [Option<[f64; 3]>; 3],
    /// `custom`: fractional coordinates of the basis atoms, each in [0, 1).
    pub basis: Vec<[f64; 3]>,
}

impl LatticeCommand {
    /// Reads the arguments.
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let word = args.position();
        let name = args.text("a lattice style")?;
        let Some(&(_, style)) = STYLES.iter().find(|(n, _)| *n == name) else {
            let known: Vec<&str> = STYLES.iter().map(|(n, _)| *n).collect();
            let what = if matches!(name, "sq" | "sq2" | "hex") { "is two-dimensional and" } else { "is" };
            return Err(Complaint::new(
                word,
                format!("lattice style '{name}' {what} not part of octant; available: {}", known.join(", ")),
            ));
        };
        let scale = args.number_where("the lattice scale", "above 0", |x| x > 0.0)?;
        let mut command = Self {
            style,
            scale,
            origin: [0.0; 3],
            orient: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
            spacing: None,
            primitive: [None; 3],
            basis: Vec::new(),
        };
        if style == LatticeStyle::None {
            args.done()?;
        }
        while args.left() > 0 {
            command.keyword(args)?;
        }
        Ok(command)
    }

    fn keyword(&mut self, args: &mut Args<'_>) -> Result<(), Complaint> {
        let word = args.position();
        let keyword = args.text("a keyword")?;
        if matches!(keyword, "a1" | "a2" | "a3" | "basis") && self.style != LatticeStyle::Custom {
            return Err(Complaint::new(word, format!("'{keyword}' belongs to lattice style custom only")));
        }
        match keyword {
            "origin" => self.origin = triple(args, "an origin coordinate", "from 0 to below 1", fraction)?,
            "spacing" => self.spacing = Some(triple(args, "a lattice spacing", "above 0", |x| x > 0.0)?),
            "orient" => {
                let axis = args.choice("an axis", &["x", "y", "z"])?;
                for component in &mut self.orient[axis] {
                    let word = args.position();
                    *component = args.integer("a lattice direction", -MAX_INDEX)?;
                    if *component > MAX_INDEX {
                        return Err(Complaint::new(word, format!("expected a lattice direction, at most {MAX_INDEX}")));
                    }
                }
            }
            "a1" => self.primitive[0] = Some(triple(args, "a component of a1", "", |_| true)?),
            "a2" => self.primitive[1] = Some(triple(args, "a component of a2", "", |_| true)?),
            "a3" => self.primitive[2] = Some(triple(args, "a component of a3", "", |_| true)?),
            "basis" => self.basis.push(triple(args, "a basis coordinate", "from 0 to below 1", fraction)?),
            "triclinic/general" => {
                return Err(Complaint::new(word, "keyword triclinic/general is not part of octant"));
            }
            other => {
                return Err(Complaint::new(
                    word,
                    format!("expected origin, orient, spacing, a1, a2, a3 or basis, got '{other}'"),
                ));
            }
        }
        Ok(())
    }
}

/// Directions beyond this make no sense and keep the integer products below from overflowing.
const MAX_INDEX: i64 = 10_000;

fn fraction(x: f64) -> bool {
    (0.0..1.0).contains(&x)
}

fn triple(args: &mut Args<'_>, what: &str, bound: &str, ok: impl Fn(f64) -> bool) -> Result<[f64; 3], Complaint> {
    let mut values = [0.0; 3];
    for value in &mut values {
        *value = args.number_where(what, bound, &ok)?;
    }
    Ok(values)
}
