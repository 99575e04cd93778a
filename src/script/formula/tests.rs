//! Formulas against LAMMPS 22Jul2025 (`print "$(...)"`).

use crate::script::{Environment, Interpreter, NoSimulation, Quantity, Source};

/// What `print` shows of a text after these lines.
fn print(lines: &str, text: &str, environment: &mut dyn Environment) -> Result<(String, bool), String> {
    let source = Source::new("in", format!("{lines}\nprint '{text}'"));
    let mut script = Interpreter::new(source, &[]).map_err(|e| e.to_string())?;
    let statement = script.next(environment).map_err(|e| e.to_string())?.ok_or("no command")?;
    Ok((statement.words[1].text.clone(), statement.tentative))
}

fn value(formula: &str) -> Result<String, String> {
    print("", &format!("$({formula})"), &mut NoSimulation).map(|p| p.0)
}

#[test]
fn arithmetic_is_that_of_lammps() {
    let cases = [
        ("1/3/3", "0.11111111111111110494"),
        ("-10%4", "-2"),
        ("5.5%2", "1.5"),
        ("-2^2", "4"),
        ("2^3^2", "64"),
        ("2--3^2", "-7"),
        ("2^-2", "0.25"),
        ("-2^-2", "0.25"),
        ("2*3%4", "2"),
        ("7%4*2", "6"),
        ("1||0&&0", "1"),
        ("1||1|^1", "0"),
        ("2|^3", "0"),
        ("1<2==1", "1"),
        ("!1==0", "1"),
        ("!0+1", "2"),
        ("-!0", "-1"),
        ("1 - -1", "2"),
        ("0*-1", "0"),
        ("atan2(0*-1,-1)", "-3.141592653589793116"),
        ("1.e3+.5+5.", "1005.5"),
        ("1e+3+2.5E-2", "1000.0249999999999773"),
        ("PI", "3.141592653589793116"),
        ("version", "20250722"),
        ("yes+true+on+no+false+off", "3"),
        ("round(2.5)", "3"),
        ("round(-2.5)", "-2"),
        ("sign(0)", "1"),
        ("ternary(2>1,2,1/0)", "2"),
        ("2^53", "9007199254740992"),
        ("(-8)^(1/3)", "-nan"),
        ("exp(1000)", "inf"),
        ("stride(0,100,10)", "10"),
    ];
    for (formula, expected) in cases {
        assert_eq!(value(formula).as_deref(), Ok(expected), "{formula}");
    }
}

#[test]
fn errors_point_into_the_formula() {
    let cases = [
        ("1+2*(3/0)", "in:2:14: formula: division by zero"),
        ("5%0", "in:2:10: formula: remainder of a division by zero"),
        ("2+ln(0)", "in:2:12: formula: ln: logarithm of zero or a negative number"),
        ("sqrt(-1)", "in:2:10: formula: sqrt: square root of a negative number"),
        ("0^-1", "in:2:10: formula: zero to a negative power"),
        ("v_foo", "in:2:10: formula: undefined variable 'foo'"),
        ("1 2", "in:2:12: formula: expected an operator in the formula, got '2'"),
        ("+2", "in:2:10: formula: expected a number, a function or a variable in the formula, got '+'"),
        ("sin(1,2)", "in:2:10: formula: sin takes 1 argument, got 2"),
        ("c_temp", "in:2:10: formula: computes (c_temp) are not part of octant's formulas"),
        ("x[1]", "in:2:10: formula: values in brackets (x[...]) are not part of octant's formulas"),
        ("gyration(all)", "in:2:10: formula: gyration() is a LAMMPS function that octant does not have here"),
        ("1e400", "in:2:10: formula: the number 1e400 is too large"),
        ("random(0,1,0)", "in:2:10: formula: random: expected a seed of 1 to 900000000"),
    ];
    for (formula, expected) in cases {
        assert_eq!(value(formula).unwrap_err(), expected);
    }
}

#[test]
fn a_variable_shows_fifteen_digits_to_other_formulas() {
    let lines = "variable a equal 1/3\nvariable r equal random(0,1,12345)";
    let text = "${a} $(v_a) $(v_r) $(normal(2,3,7))";
    let (shown, _) = print(lines, text, &mut NoSimulation).unwrap();
    assert!(shown.starts_with("0.333333333333333 0.33333333333333298176 0.8699530959129330"), "{shown}");
}

#[test]
fn variables_that_need_themselves_are_told() {
    let circle = print("variable x equal v_y\nvariable y equal 1+v_x", "${x}", &mut NoSimulation);
    assert_eq!(circle.unwrap_err(), "in:2:20: variable y: variable x is defined through itself");
    let far = print("variable x equal 3+1/0\nvariable y equal v_x", "${y}", &mut NoSimulation);
    assert_eq!(far.unwrap_err(), "in:1:20: variable x: division by zero");
}

#[test]
fn depth_is_bounded() {
    for formula in ["(".repeat(100_000), "-".repeat(100_000), "sin(".repeat(100_000), "1+".repeat(100_000) + "1"] {
        assert!(value(&formula).is_err());
    }
    let chain: String = (0..5000).map(|k| format!("variable x{k} equal v_x{}\n", k + 1)).collect();
    assert!(print(&(chain + "variable x5000 equal 1"), "${x0}", &mut NoSimulation).unwrap_err().contains("nested"));
    assert_eq!(value(&("1+".repeat(500) + "1")).as_deref(), Ok("501"));
}

/// Knows the keyword `temp`, but only as a stand-in.
struct Judging;

impl Environment for Judging {
    fn thermo(&mut self, keyword: &str) -> Result<Option<Quantity>, String> {
        Ok((keyword == "temp").then_some(Quantity { value: 0.0, known: false }))
    }
    fn group(&mut self, function: &str, args: &[&str]) -> Result<Option<Quantity>, String> {
        Ok((function == "count" && args == ["all"]).then_some(Quantity::known(32.0)))
    }
}

#[test]
fn what_is_not_known_is_not_judged() {
    assert_eq!(print("", "$(count( all )/2)", &mut Judging), Ok(("16".to_string(), false)));
    let lines = "variable t equal 1/temp\nvariable s index $(v_t)\nvariable u equal ln(-v_s)";
    for text in ["${t}", "${s}", "${u}", "$(ternary(temp,1,2))", "$(count(all)+temp)"] {
        assert!(print(lines, text, &mut Judging).unwrap().1, "{text}");
    }
}
