//! A number that records what is done with it: formulas over [`Real`] become CUDA C.
//!
//! Every operation is a node of a tape; an operation that was recorded before is found again, so common subexpressions stand
//! once. [`Recording`] owns the tape of one formula; numbers must not outlive it.

use std::cell::RefCell;
use std::collections::HashMap;
use std::fmt::Write as _;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Real, Whole};

/// A node of the tape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Expr(u32);

/// A truth value on the tape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Truth(u32);

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Node {
    /// A name of the generated code.
    Input(String),
    /// Bits of a double.
    Constant(u64),
    Unary(Unary, u32),
    Binary(Binary, u32, u32),
    MulAdd(u32, u32, u32),
    Less(u32, u32),
    Select(u32, u32, u32),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Unary {
    Neg,
    Sqrt,
    Rsqrt,
    Recip,
    Exp,
    Ln,
    Trunc,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Binary {
    Add,
    Sub,
    Mul,
    Div,
}

#[derive(Default)]
struct Tape {
    nodes: Vec<Node>,
    known: HashMap<Node, u32>,
}

thread_local! {
    static TAPE: RefCell<Tape> = RefCell::default();
}

fn record(node: Node) -> u32 {
    TAPE.with_borrow_mut(|tape| {
        if let Some(known) = tape.known.get(&node) {
            return *known;
        }
        let at = tape.nodes.len() as u32;
        tape.nodes.push(node.clone());
        tape.known.insert(node, at);
        at
    })
}

/// Arithmetic of the generated code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arithmetic {
    F32,
    F64,
    /// f64 in which every operation rounds by itself, as on the CPU: the compiler must not fuse any.
    F64Exact,
}

impl Arithmetic {
    /// Name of the type in CUDA C.
    pub fn name(self) -> &'static str {
        if self == Arithmetic::F32 { "float" } else { "double" }
    }

    fn constant(self, bits: u64) -> String {
        let value = f64::from_bits(bits);
        match self {
            Arithmetic::F32 => format!("{:e}f", value as f32),
            _ => format!("{value:e}"),
        }
    }
}

/// The tape of one formula.
pub struct Recording(());

impl Recording {
    /// Begins with an empty tape on this thread.
    pub fn start() -> Self {
        TAPE.with_borrow_mut(|tape| *tape = Tape::default());
        Self(())
    }

    /// A number that the generated code knows by this name.
    pub fn input(&self, name: impl Into<String>) -> Expr {
        Expr(record(Node::Input(name.into())))
    }

    /// Statements that assign the outputs to their names, without those that only repeat an input of the same name. Names of
    /// intermediate results begin with `prefix`.
    pub fn print(&self, outputs: &[(&str, Expr)], arithmetic: Arithmetic, prefix: &str) -> String {
        TAPE.with_borrow(|tape| {
            let outputs: Vec<_> = outputs.iter().filter(|(name, e)| !tape.is_input(e.0, name)).collect();
            let mut used = vec![false; tape.nodes.len()];
            for (_, output) in &outputs {
                used[output.0 as usize] = true;
            }
            for at in (0..tape.nodes.len()).rev() {
                if used[at] {
                    tape.nodes[at].operands(|k| used[k as usize] = true);
                }
            }
            let mut text = String::new();
            let name = |at: u32| match &tape.nodes[at as usize] {
                Node::Input(name) => name.clone(),
                Node::Constant(bits) => arithmetic.constant(*bits),
                _ => format!("{prefix}{at}"),
            };
            for (at, node) in tape.nodes.iter().enumerate().filter(|(at, _)| used[*at]) {
                if let Some(value) = node.print(arithmetic, &name) {
                    let kind = if matches!(node, Node::Less(..)) { "bool" } else { arithmetic.name() };
                    let _ = writeln!(text, "    const {kind} {prefix}{at} = {value};");
                }
            }
            // A name that is given away is read before it may be written.
            let copied = |k: usize, e: &Expr| match &tape.nodes[e.0 as usize] {
                Node::Input(_) => format!("{prefix}_{k}"),
                _ => name(e.0),
            };
            for (k, (_, output)) in outputs.iter().enumerate() {
                if let Node::Input(input) = &tape.nodes[output.0 as usize] {
                    let _ = writeln!(text, "    const {} {} = {input};", arithmetic.name(), copied(k, output));
                }
            }
            for (k, (to, output)) in outputs.iter().enumerate() {
                let _ = writeln!(text, "    {to} = {};", copied(k, output));
            }
            text
        })
    }

    /// Whether a number is the input of that name and nothing else.
    pub fn is_input(&self, e: Expr, name: &str) -> bool {
        TAPE.with_borrow(|tape| tape.is_input(e.0, name))
    }
}

impl Tape {
    fn is_input(&self, at: u32, name: &str) -> bool {
        matches!(&self.nodes[at as usize], Node::Input(input) if input == name)
    }
}

impl Node {
    fn operands(&self, mut look: impl FnMut(u32)) {
        match *self {
            Node::Input(_) | Node::Constant(_) => {}
            Node::Unary(_, a) => look(a),
            Node::Binary(_, a, b) | Node::Less(a, b) => [a, b].into_iter().for_each(look),
            Node::MulAdd(a, b, c) | Node::Select(a, b, c) => [a, b, c].into_iter().for_each(look),
        }
    }

    fn print(&self, arithmetic: Arithmetic, name: &impl Fn(u32) -> String) -> Option<String> {
        let single = arithmetic == Arithmetic::F32;
        let exact = arithmetic == Arithmetic::F64Exact;
        let suffix = if single { "f" } else { "" };
        Some(match *self {
            Node::Input(_) | Node::Constant(_) => return None,
            Node::Unary(op, a) => {
                let a = name(a);
                match op {
                    Unary::Neg => format!("-({a})"),
                    Unary::Sqrt => format!("sqrt{suffix}({a})"),
                    Unary::Rsqrt => format!("rsqrt{suffix}({a})"),
                    Unary::Recip if exact && !single => format!("__drcp_rn({a})"),
                    Unary::Recip => format!("reciprocal({a})"),
                    Unary::Exp => format!("exp{suffix}({a})"),
                    Unary::Ln => format!("log{suffix}({a})"),
                    Unary::Trunc => format!("trunc{suffix}({a})"),
                }
            }
            Node::Binary(op, a, b) => {
                let (a, b) = (name(a), name(b));
                match (op, exact) {
                    (Binary::Add, false) => format!("{a} + {b}"),
                    (Binary::Sub, false) => format!("{a} - {b}"),
                    (Binary::Mul, false) => format!("{a} * {b}"),
                    (Binary::Div, false) => format!("{a} / {b}"),
                    (Binary::Add, true) => format!("__dadd_rn({a}, {b})"),
                    (Binary::Sub, true) => format!("__dsub_rn({a}, {b})"),
                    (Binary::Mul, true) => format!("__dmul_rn({a}, {b})"),
                    (Binary::Div, true) => format!("__ddiv_rn({a}, {b})"),
                }
            }
            Node::MulAdd(a, b, c) if exact => format!("__dadd_rn(__dmul_rn({}, {}), {})", name(a), name(b), name(c)),
            Node::MulAdd(a, b, c) => format!("fma{suffix}({}, {}, {})", name(a), name(b), name(c)),
            Node::Less(a, b) => format!("{} < {}", name(a), name(b)),
            Node::Select(mask, a, b) => format!("{} ? {} : {}", name(mask), name(a), name(b)),
        })
    }
}

macro_rules! binary {
    ($trait:ident, $method:ident) => {
        impl $trait for Expr {
            type Output = Expr;
            fn $method(self, other: Expr) -> Expr {
                Expr(record(Node::Binary(Binary::$trait, self.0, other.0)))
            }
        }
    };
}
binary!(Add, add);
binary!(Sub, sub);
binary!(Mul, mul);
binary!(Div, div);

impl Neg for Expr {
    type Output = Expr;
    fn neg(self) -> Expr {
        self.unary(Unary::Neg)
    }
}

impl Expr {
    fn unary(self, op: Unary) -> Expr {
        Expr(record(Node::Unary(op, self.0)))
    }
}

impl Real for Expr {
    type Mask = Truth;
    fn constant(value: f64) -> Self {
        Expr(record(Node::Constant(value.to_bits())))
    }
    fn sqrt(self) -> Self {
        self.unary(Unary::Sqrt)
    }
    fn exp(self) -> Self {
        self.unary(Unary::Exp)
    }
    fn ln(self) -> Self {
        self.unary(Unary::Ln)
    }
    fn less(self, other: Self) -> Truth {
        Truth(record(Node::Less(self.0, other.0)))
    }
    fn select(mask: Truth, yes: Self, no: Self) -> Self {
        if yes == no { yes } else { Expr(record(Node::Select(mask.0, yes.0, no.0))) }
    }
    fn recip(self) -> Self {
        self.unary(Unary::Recip)
    }
    fn rsqrt(self) -> Self {
        self.unary(Unary::Rsqrt)
    }
    fn mul_add(self, a: Self, b: Self) -> Self {
        Expr(record(Node::MulAdd(self.0, a.0, b.0)))
    }
}

impl Whole for Expr {
    fn trunc(self) -> Self {
        self.unary(Unary::Trunc)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn common_subexpressions_stand_once_and_unused_ones_nowhere() {
        let tape = Recording::start();
        let (x, y) = (tape.input("x"), tape.input("y"));
        let unused = x.exp();
        let sum = (x + y) * (x + y) - Expr::constant(0.5);
        assert_ne!(unused, sum);
        let text = tape.print(&[("out", sum)], Arithmetic::F32, "t");
        assert_eq!(text.matches("x + y").count(), 1, "{text}");
        assert!(!text.contains("exp") && text.contains("5e-1f"), "{text}");
    }

    #[test]
    fn exact_arithmetic_fuses_nothing() {
        let tape = Recording::start();
        let (x, y) = (tape.input("x"), tape.input("y"));
        let text = tape.print(&[("out", x.mul_add(y, x))], Arithmetic::F64Exact, "t");
        assert!(text.contains("__dadd_rn(__dmul_rn(x, y), x)"), "{text}");
        assert!(tape.print(&[("x", x)], Arithmetic::F64, "t").is_empty());
    }
}
