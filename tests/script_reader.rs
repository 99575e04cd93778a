//! No text makes the script reader panic, and every error it gives has a place in the text.

use octant::script::{Command, InputError, Interpreter, NoSimulation, Source};
use proptest::prelude::*;

/// Statements read before a script that jumps in circles is given up.
const ENOUGH: usize = 200;

/// A script with most of what the language has.
const VALID: &str = r#"# melt & more
variable        x index 1
variable	n loop 3 12 pad
variable xx equal 20*$x   # comment's end
variable s string "a ${xx} b"
variable r equal "random(0,1,123)^2 + ternary(v_x > 1, 2, 3) - (-2)^2 % 5 && !0 |^ stride2(0,100,10,5,50,5)"

units           lj
boundary p fs s
neighbor 0.3 bin
neigh_modify delay 0 every 20 &
   check no
label top
pair_style lj/cut $(2.5*v_x:%.3f)
pair_coeff * * 1.0 $(ln(v_n)/(1+2)) 2.5
print """x is ${x} 'and' $s
in two lines"""
if "${x} > 0 && abc == abc" then "print 'yes ${r}'" elif (1<2) "jump SELF top" else 'run 0'
next n
jump SELF top
fix 1 all nve
log none
run 100 upto pre no
"#;

/// Reads a script to its end or its first error.
fn read(text: &str) -> Result<usize, InputError> {
    let presets = [("x".to_string(), "1".to_string())];
    let mut script = Interpreter::new(Source::new("in", text), &presets)?;
    let mut count = 0;
    while let Some(statement) = script.next(&mut NoSimulation)? {
        Command::parse(&statement).map_err(|complaint| statement.complain(complaint))?;
        count += 1;
        if count == ENOUGH {
            break;
        }
    }
    Ok(count)
}

fn check(text: &str) {
    if let Err(error) = read(text) {
        let length = error.source.text.len();
        assert!(error.span.start <= error.span.end && error.span.end <= length, "{error} at {:?}", error.span);
        assert!(error.source.text.is_char_boundary(error.span.start), "{error}");
        let report = format!("{:?}", miette::Report::new(error));
        assert!(!report.is_empty());
    }
}

#[test]
fn the_valid_script_is_read() {
    assert_eq!(read(VALID).map_err(|e| e.to_string()), Ok(47));
}

#[test]
fn long_and_deep_texts_end_in_words() {
    for piece in [
        "(",
        ")",
        "$(",
        "${",
        "$",
        "-",
        "!",
        "'",
        "\"",
        "\"\"\"",
        "&\n",
        "#",
        "\n",
        "v_x+",
        "1e",
        "9",
        "é",
        "if 1 then '",
    ] {
        let many = piece.repeat(20_000);
        check(&many);
        check(&format!("variable a equal {many}\nprint ${{a}}"));
        check(&format!("print \"$({many})\""));
        check(&format!("if \"{many}\" then \"print {many}\""));
        check(&format!("run {many}"));
    }
    for number in
        ["1e999999999", "-1e-999999999", "9223372036854775808", "-9223372036854775808", "1e308*1e308", "nan", "inf"]
    {
        for line in [
            "run NUMBER",
            "timestep NUMBER",
            "variable i loop NUMBER pad\nnext i",
            "variable i loop 1 NUMBER\nprint $i\nnext i",
            "print $(stride(NUMBER,NUMBER,NUMBER))",
            "print $(logfreq2(NUMBER,2,NUMBER))",
            "print $(1:%NUMBER.3f)",
            "print $(random(0,1,NUMBER))",
            "if \"NUMBER > NUMBER\" then \"print a\"",
            "reset_timestep NUMBER",
            "print $(logfreq(1,1,NUMBER))",
        ] {
            check(&line.replace("NUMBER", number));
        }
    }
}

/// Pieces of the language, to be put together at random.
fn piece() -> impl Strategy<Value = String> {
    let words = [
        "variable ",
        "x ",
        "y ",
        "index ",
        "equal ",
        "loop ",
        "string ",
        "delete",
        "next ",
        "label ",
        "jump SELF ",
        "if ",
        "then ",
        "else ",
        "elif ",
        "print ",
        "run ",
        "fix 1 all nve",
        "units lj",
        "$x",
        "${x}",
        "$(",
        "v_x",
        "v_y",
        ")",
        "(",
        "+",
        "-",
        "*",
        "/",
        "%",
        "^",
        "==",
        "&&",
        "|^",
        "!",
        "1",
        "0",
        "2.5e3",
        ":%8.3f",
        "\"",
        "'",
        "\"\"\"",
        "&\n",
        "#",
        "\n",
        " ",
        "\t",
        "\r\n",
        "é",
        "sqrt(",
        "ternary(",
        "random(0,1,5)",
        ",",
        "temp",
        "count(all)",
        "\0",
        "none",
        "yes",
    ];
    prop_oneof![
        8 => proptest::sample::select(words.to_vec()).prop_map(str::to_string),
        1 => any::<char>().prop_map(String::from),
        1 => any::<f64>().prop_map(|x| x.to_string()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_do_no_harm(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        check(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn random_pieces_do_no_harm(pieces in proptest::collection::vec(piece(), 0..60)) {
        check(&pieces.concat());
    }

    #[test]
    fn mutations_of_a_valid_script_do_no_harm(
        edits in proptest::collection::vec((0..VALID.len(), 0..12usize, piece()), 1..6),
    ) {
        let mut text = VALID.to_string();
        for (at, cut, insert) in edits {
            let boundary = |k: usize| (0..=k.min(text.len())).rev().find(|k| text.is_char_boundary(*k)).unwrap_or(0);
            let (start, end) = (boundary(at), boundary(at + cut));
            text.replace_range(start..end, &insert);
        }
        check(&text);
    }
}
