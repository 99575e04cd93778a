//! `group ID style args` (LAMMPS doc page `group`).

use crate::script::{Args, Complaint, Name};

/// A comparison of `group ID type|id`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Comparison {
    Less,
    Greater,
    LessEqual,
    GreaterEqual,
    Equal,
    NotEqual,
}

const COMPARISONS: [(&str, Comparison); 6] = [
    ("<", Comparison::Less),
    (">", Comparison::Greater),
    ("<=", Comparison::LessEqual),
    (">=", Comparison::GreaterEqual),
    ("==", Comparison::Equal),
    ("!=", Comparison::NotEqual),
];

/// Which numbers (types or ids) a group takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Numbers {
    /// Any of these sequences `first, first + stride, ... <= last`.
    Sequences(Vec<Sequence>),
    /// Those that compare to a number so.
    Compared(Comparison, i64),
    /// `<> first last`: both ends belong to it.
    Between(i64, i64),
}

/// `first:last:stride`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sequence {
    pub first: i64,
    pub last: i64,
    pub stride: i64,
}

impl Numbers {
    /// Whether a number is among them.
    pub fn contains(&self, n: i64) -> bool {
        match self {
            Self::Sequences(list) => list.iter().any(|s| n >= s.first && n <= s.last && (n - s.first) % s.stride == 0),
            Self::Compared(comparison, to) => match comparison {
                Comparison::Less => n < *to,
                Comparison::Greater => n > *to,
                Comparison::LessEqual => n <= *to,
                Comparison::GreaterEqual => n >= *to,
                Comparison::Equal => n == *to,
                Comparison::NotEqual => n != *to,
            },
            Self::Between(first, last) => (*first..=*last).contains(&n),
        }
    }
}

/// What a `group` command does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GroupAction {
    Type(Numbers),
    Id(Numbers),
    Region(Name),
    /// All atoms of any of these groups.
    Union(Vec<Name>),
    /// The first group less all the others.
    Subtract(Vec<Name>),
    /// Atoms that are in each of these groups.
    Intersect(Vec<Name>),
    /// Defines the group and adds nothing.
    Empty,
    /// Takes all atoms out.
    Clear,
    /// Removes the group.
    Delete,
}

/// A `group` command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GroupCommand {
    pub name: Name,
    pub action: GroupAction,
}

impl GroupCommand {
    /// Reads the arguments.
    pub fn parse(args: &mut Args<'_>) -> Result<Self, Complaint> {
        let name = args.name("a group ID")?;
        let word = args.position();
        let action = match args.text("a group style")? {
            "type" => GroupAction::Type(numbers(args, "an atom type")?),
            "id" => GroupAction::Id(numbers(args, "an atom id")?),
            "region" => GroupAction::Region(args.name("a region ID")?),
            "union" => GroupAction::Union(names(args, 1)?),
            "subtract" => GroupAction::Subtract(names(args, 2)?),
            "intersect" => GroupAction::Intersect(names(args, 2)?),
            "empty" => GroupAction::Empty,
            "clear" => GroupAction::Clear,
            "delete" => GroupAction::Delete,
            other => {
                return Err(Complaint::new(
                    word,
                    format!(
                        "group style '{other}' is not part of octant; available: type, id, region, union, subtract, \
                         intersect, empty, clear, delete"
                    ),
                ));
            }
        };
        args.done()?;
        Ok(Self { name, action })
    }
}

fn names(args: &mut Args<'_>, least: usize) -> Result<Vec<Name>, Complaint> {
    let mut names = Vec::new();
    while names.len() < least || args.left() > 0 {
        names.push(args.name("a group ID")?);
    }
    Ok(names)
}

fn numbers(args: &mut Args<'_>, what: &str) -> Result<Numbers, Complaint> {
    if args.peek() == Some("<>") {
        args.text(what)?;
        return Ok(Numbers::Between(number(args, what)?, number(args, what)?));
    }
    if let Some(&(_, comparison)) = COMPARISONS.iter().find(|(sign, _)| args.peek() == Some(sign)) {
        args.text(what)?;
        return Ok(Numbers::Compared(comparison, number(args, what)?));
    }
    let mut list = Vec::new();
    while list.is_empty() || args.left() > 0 {
        list.push(sequence(args, what)?);
    }
    Ok(Numbers::Sequences(list))
}

fn number(args: &mut Args<'_>, what: &str) -> Result<i64, Complaint> {
    // Ids and types are 32-bit numbers; the bound keeps sums of them from overflowing.
    args.integer(what, -i64::from(i32::MAX))
}

fn sequence(args: &mut Args<'_>, what: &str) -> Result<Sequence, Complaint> {
    let word = args.position();
    let text = args.text(&format!("{what} or a range first:last:stride"))?;
    let parts: Option<Vec<i64>> = text.split(':').map(|p| p.parse::<i32>().ok().map(i64::from)).collect();
    match parts.as_deref() {
        Some(&[n]) => Ok(Sequence { first: n, last: n, stride: 1 }),
        Some(&[first, last]) => Ok(Sequence { first, last, stride: 1 }),
        Some(&[first, last, stride]) if stride > 0 => Ok(Sequence { first, last, stride }),
        Some(&[_, _, stride]) => Err(Complaint::new(word, format!("expected a stride of at least 1, got {stride}"))),
        _ => Err(Complaint::new(word, format!("expected {what} or a range first:last:stride, got '{text}'"))),
    }
}
