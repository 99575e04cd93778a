//! Intermediate code as text (NVIDIA: PTX ISA): its entry points, the parts that the stages mark, and what is in them.

/// Comments that the stages put around a part of their code.
type Marks = (&'static str, &'static str);

/// Around the loop over a particle's row.
const PAIR_LOOP: Marks = ("// pair loop", "// end of pair loop");

/// Before the number of entries that one pass of it works on.
const ENTRIES: &str = "// pair loop, entries: ";

/// Around what is done for a particle as it moves.
const MOVE: Marks = ("// move", "// end of move");

/// What is in some code, every instruction counted once: one pass of straight-line code, with both sides of its branches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Content {
    pub instructions: usize,
    /// Arithmetic on f64, as [`double_instructions`] counts it.
    pub doubles: usize,
    /// Bytes read from and written to global memory.
    pub bytes: usize,
}

/// What an atom costs in a step. Code that is there more than once counts as its longest copy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepContent {
    /// Entries of a row that one pass of the pair loop works on.
    pub entries: usize,
    /// The second half of a step and the first half of the next one, without reading the force.
    pub moving: Content,
    /// So many entries of its row, on a step without energy and virial.
    pub force: Content,
    /// The same on a step with them.
    pub sums: Content,
}

/// Content of some code.
pub fn content(ptx: &str) -> Content {
    Content { instructions: opcodes(ptx).count(), doubles: double_instructions(ptx), bytes: bytes(ptx) }
}

/// Content of the stages of a step; zeros where marks are missing.
pub fn step_content(ptx: &str) -> StepContent {
    let all = |parts: Vec<String>| -> Vec<Content> { parts.iter().map(|part| content(part)).collect() };
    let (moves, loops) = (all(moves(ptx)), all(pair_loops(ptx)));
    let longest = |all: &[Content]| all.iter().copied().max_by_key(|c| c.instructions).unwrap_or_default();
    let shortest = loops.iter().copied().min_by_key(|c| c.instructions).unwrap_or_default();
    let entries = ptx.split_once(ENTRIES).and_then(|(_, rest)| rest.split_whitespace().next()?.parse().ok());
    StepContent {
        entries: entries.unwrap_or_default(),
        moving: longest(&moves),
        force: shortest,
        sums: longest(&loops),
    }
}

/// Opcodes with their modifiers, such as "fma.rn.f64", in the order of the text.
pub fn opcodes(ptx: &str) -> impl Iterator<Item = &str> {
    ptx.lines().filter_map(|line| {
        let line = line.trim();
        let line = line.strip_prefix('@').and_then(|l| l.split_once(' ')).map_or(line, |(_, rest)| rest.trim_start());
        // A call goes on over several lines, which hold no opcodes.
        let ends = line.ends_with(';') || line.starts_with("call");
        let opcode = line.split([' ', '\t', ';']).next().unwrap_or("");
        (ends && opcode.starts_with(|c: char| c.is_ascii_lowercase())).then_some(opcode)
    })
}

/// Arithmetic instructions on f64: conversions, comparisons, additions and so on, but no moves.
pub fn double_instructions(ptx: &str) -> usize {
    let moves = ["ld.", "st.", "mov.", "selp.", "shfl.", "cvta"];
    opcodes(ptx).filter(|opcode| opcode.contains(".f64") && !moves.iter().any(|m| opcode.starts_with(m))).count()
}

/// Bytes that loads and stores of global memory move.
pub fn bytes(ptx: &str) -> usize {
    const ELSEWHERE: [&str; 4] = [".param", ".shared", ".local", ".const"];
    let moves = |opcode: &&str| opcode.starts_with("ld.") || opcode.starts_with("st.");
    opcodes(ptx).filter(moves).filter(|opcode| !ELSEWHERE.iter().any(|e| opcode.contains(e))).map(bytes_of).sum()
}

/// Bytes of an operand: "ld.global.v4.u32" has 16.
fn bytes_of(opcode: &str) -> usize {
    let parts = || opcode.split('.');
    let number = |prefix: char| move |part: &str| part.strip_prefix(prefix).and_then(|n| n.parse::<usize>().ok());
    let vector = parts().find_map(number('v')).unwrap_or(1);
    let kind = parts().next_back().unwrap_or("");
    let bits = ['b', 'u', 's', 'f'].into_iter().find_map(|prefix| number(prefix)(kind)).unwrap_or(0);
    vector * bits / 8
}

/// Names of the entry points, and bytes of each of their parameters.
pub fn entries(ptx: &str) -> Vec<(String, Vec<usize>)> {
    let entry = |text: &str| {
        let (name, rest) = text.split_once('(')?;
        let (parameters, _) = rest.split_once(')')?;
        Some((name.trim().to_string(), parameters.split(',').filter_map(parameter).collect()))
    };
    ptx.split(".entry ").skip(1).filter_map(entry).collect()
}

/// Bytes of a parameter, such as ".param .align 8 .b8 advance_param_0[64]".
fn parameter(text: &str) -> Option<usize> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let (name, kind) = (words.last()?, words.get(words.len().checked_sub(2)?)?);
    let count = name.split_once('[').map_or(Some(1), |(_, n)| n.trim_end_matches(']').parse().ok())?;
    Some(count * bytes_of(kind))
}

/// The loops over a particle's row, with and without energy and virial.
pub fn pair_loops(ptx: &str) -> Vec<String> {
    parts(ptx, PAIR_LOOP)
}

/// What is done for a particle as it moves: in a step, and in its second half alone.
pub fn moves(ptx: &str) -> Vec<String> {
    parts(ptx, MOVE)
}

/// The text between marks.
fn parts(ptx: &str, marks: Marks) -> Vec<String> {
    let mut parts = Vec::new();
    let mut inside: Option<String> = None;
    for line in ptx.lines() {
        match line.trim() {
            text if text == marks.0 => inside = Some(String::new()),
            text if text == marks.1 => parts.extend(inside.take()),
            _ => {
                if let Some(text) = &mut inside {
                    text.push_str(line);
                    text.push('\n');
                }
            }
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "\
.func (.param .b32 func_retval0) helper(
	.param .b64 helper_param_0
)
.visible .entry first(
	.param .align 8 .b8 first_param_0[24],
	.param .u64 first_param_1
)
.maxntid 256
{
	.reg .f64 %fd<3>;
$L__BB0_1:
	ld.param.u64 %rd1, [first_param_1];
	// begin inline asm
	// move
	// end inline asm
	ld.global.v4.u32 {%r1, %r2, %r3, %r4}, [%rd1];
	@%p1 bra $L__BB0_2;
	fma.rn.f64 %fd1, %fd2, %fd2, %fd1;
	@!%p2 st.f64 [%rd1], %fd1;
	mov.f64 %fd2, %fd1;
	// end of move
	// pair loop, entries: 8
	// pair loop
	call.uni (retval0),
	helper,
	(
	param0
	);
	// end of pair loop
	// pair loop
	ret;
	// end of pair loop
}
.entry second()
{
	ret;
}
";

    #[test]
    fn instructions_are_told_from_the_rest() {
        let opcodes: Vec<&str> = opcodes(TEXT).collect();
        let expected =
            ["ld.param.u64", "ld.global.v4.u32", "bra", "fma.rn.f64", "st.f64", "mov.f64", "call.uni", "ret"];
        assert_eq!(opcodes, [&expected[..], &["ret"]].concat());
    }

    #[test]
    fn marked_parts_are_counted() {
        let step = step_content(TEXT);
        assert_eq!(step.entries, 8);
        assert_eq!(step.moving, Content { instructions: 5, doubles: 1, bytes: 24 });
        assert_eq!(step.force, Content { instructions: 1, doubles: 0, bytes: 0 });
        assert_eq!(pair_loops(TEXT).len(), 2);
        assert_eq!(step_content("ret;"), StepContent::default());
    }

    #[test]
    fn entry_points_have_parameters_of_known_size() {
        assert_eq!(entries(TEXT), [("first".to_string(), vec![24, 8]), ("second".to_string(), vec![])]);
    }
}
