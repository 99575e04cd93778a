//! Number formats of C's `printf`, in which LAMMPS writes and lets users choose its output: digit for digit what glibc prints.

/// Widths and precisions beyond this are refused: no table needs them, and they would only fill memory.
const WIDEST: usize = 1000;

/// One `%` conversion, possibly with text around it: `%-15.8g`, `%d`, `P = %12.4f bar`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Printf {
    before: String,
    flags: Flags,
    width: usize,
    precision: Option<usize>,
    conversion: Conversion,
    after: String,
}

/// What a `%` conversion turns into text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Conversion {
    /// `%d`, `%i`, `%u`, with any length modifier.
    Integer,
    /// `%f`: so many digits after the point.
    Fixed,
    /// `%e`: one digit before the point and an exponent.
    Exponent,
    /// `%g`: the shorter of both, trailing zeros left out.
    General,
    /// `%s`.
    Text,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Flags {
    left: bool,
    plus: bool,
    blank: bool,
    alternate: bool,
    zero: bool,
    upper: bool,
}

impl Printf {
    /// Reads a format with exactly one conversion; `%%` stands for a percent sign. The error says what is wrong with it.
    pub fn parse(format: &str) -> Result<Self, String> {
        let mut found: Option<Self> = None;
        let (mut text, mut after) = (String::new(), String::new());
        let mut rest = format.chars().peekable();
        while let Some(c) = rest.next() {
            let text = if found.is_some() { &mut after } else { &mut text };
            if c != '%' {
                text.push(c);
            } else if rest.next_if_eq(&'%').is_some() {
                text.push('%');
            } else if found.is_some() {
                return Err(format!("expected a format for one value, got '{format}'"));
            } else {
                found = Some(Self::conversion_from(&mut rest, std::mem::take(text), format)?);
            }
        }
        let mut printf =
            found.ok_or_else(|| format!("expected a number format such as %g or %12.4f, got '{format}'"))?;
        printf.after = after;
        Ok(printf)
    }

    fn conversion_from(
        rest: &mut std::iter::Peekable<std::str::Chars<'_>>,
        before: String,
        format: &str,
    ) -> Result<Self, String> {
        let mut flags = Flags::default();
        while let Some(c) = rest.next_if(|c| "-+ #0".contains(*c)) {
            match c {
                '-' => flags.left = true,
                '+' => flags.plus = true,
                ' ' => flags.blank = true,
                '#' => flags.alternate = true,
                _ => flags.zero = true,
            }
        }
        let width = count(rest, format)?;
        let precision = match rest.next_if_eq(&'.') {
            Some(_) => Some(count(rest, format)?),
            None => None,
        };
        while rest.next_if(|c| "hlLqjzt".contains(*c)).is_some() {}
        let conversion = match rest.next() {
            Some('d' | 'i' | 'u') => Conversion::Integer,
            Some('f') => Conversion::Fixed,
            Some('e') => Conversion::Exponent,
            Some('g') => Conversion::General,
            Some('s') => Conversion::Text,
            Some(c @ ('F' | 'E' | 'G')) => {
                flags.upper = true;
                match c {
                    'F' => Conversion::Fixed,
                    'E' => Conversion::Exponent,
                    _ => Conversion::General,
                }
            }
            Some(c) => return Err(format!("expected one of %d %i %u %f %e %g %s, got '%{c}' in '{format}'")),
            None => return Err(format!("expected one of %d %i %u %f %e %g %s, got the end of '{format}'")),
        };
        Ok(Self { before, flags, width, precision, conversion, after: String::new() })
    }

    /// What kind of value the format is made for.
    pub fn conversion(&self) -> Conversion {
        self.conversion
    }

    /// A floating-point value; an integer format prints it truncated towards zero, as a C cast does.
    pub fn float(&self, value: f64) -> String {
        let body = match self.conversion {
            Conversion::Integer => return self.integer(value as i64),
            Conversion::Fixed => fixed(value.abs(), self.precision.unwrap_or(6), self.flags.alternate),
            Conversion::Exponent => exponent(value.abs(), self.precision.unwrap_or(6), self.flags.alternate),
            Conversion::General => general(value.abs(), self.precision.unwrap_or(6), self.flags.alternate),
            Conversion::Text => return self.text(&format_g(value, 0, 6, false)),
        };
        let body = if self.flags.upper { body.to_uppercase() } else { body };
        self.finish(value.is_sign_negative(), &body, value.is_finite())
    }

    /// An integer value; a floating-point format prints it as one.
    pub fn integer(&self, value: i64) -> String {
        match self.conversion {
            Conversion::Integer => {
                let mut body = value.unsigned_abs().to_string();
                match self.precision {
                    Some(0) if value == 0 => body.clear(),
                    Some(p) => body = format!("{body:0>p$}"),
                    None => (),
                }
                self.finish(value < 0, &body, self.precision.is_none())
            }
            Conversion::Text => self.text(&value.to_string()),
            _ => self.float(value as f64),
        }
    }

    /// A string (`%s`, cut to the precision if there is one), padded to the width.
    pub fn text(&self, value: &str) -> String {
        let cut: String = match (self.conversion, self.precision) {
            (Conversion::Text, Some(p)) => value.chars().take(p).collect(),
            _ => value.to_string(),
        };
        format!("{}{}{}", self.before, pad(&cut, self.width, self.flags.left), self.after)
    }

    /// Sign, padding and the text around.
    fn finish(&self, negative: bool, body: &str, zeros_allowed: bool) -> String {
        let sign = match (negative, self.flags.plus, self.flags.blank) {
            (true, ..) => "-",
            (false, true, _) => "+",
            (false, false, true) => " ",
            _ => "",
        };
        let padded = if self.flags.zero && !self.flags.left && zeros_allowed {
            let width = self.width.saturating_sub(sign.len());
            format!("{sign}{body:0>width$}")
        } else {
            pad(&format!("{sign}{body}"), self.width, self.flags.left)
        };
        format!("{}{padded}{}", self.before, self.after)
    }
}

/// Reads decimal digits; none count as 0.
fn count(rest: &mut std::iter::Peekable<std::str::Chars<'_>>, format: &str) -> Result<usize, String> {
    let mut n = 0;
    while let Some(digit) = rest.peek().and_then(|c| c.to_digit(10)) {
        rest.next();
        n = n * 10 + digit as usize;
        if n > WIDEST {
            return Err(format!("widths and precisions go up to {WIDEST}, got '{format}'"));
        }
    }
    Ok(n)
}

/// C's `%<width>.<precision>g`, left-justified if `left`. Precision is clamped to 1000.
pub fn format_g(value: f64, width: usize, precision: usize, left: bool) -> String {
    pad(&signed(value, general(value.abs(), precision.min(WIDEST), false)), width, left)
}

/// C's `%<width>.<precision>f`, left-justified if `left`. Precision is clamped to 1000.
pub fn format_f(value: f64, width: usize, precision: usize, left: bool) -> String {
    pad(&signed(value, fixed(value.abs(), precision.min(WIDEST), false)), width, left)
}

/// C's `%<width>.<precision>e`, left-justified if `left`. Precision is clamped to 1000.
pub fn format_e(value: f64, width: usize, precision: usize, left: bool) -> String {
    pad(&signed(value, exponent(value.abs(), precision.min(WIDEST), false)), width, left)
}

/// Blanks up to `width` characters, after the text if `left`.
pub fn pad(text: &str, width: usize, left: bool) -> String {
    if left { format!("{text:<width$}") } else { format!("{text:>width$}") }
}

fn signed(value: f64, body: String) -> String {
    if value.is_sign_negative() { format!("-{body}") } else { body }
}

/// `inf` and `nan`, which no precision changes.
fn not_finite(value: f64) -> Option<String> {
    (!value.is_finite()).then(|| if value.is_nan() { "nan" } else { "inf" }.to_string())
}

/// Digits of a value at least 0, `precision` of them after the point. Rust rounds the exact decimal expansion, as glibc does.
fn fixed(value: f64, precision: usize, alternate: bool) -> String {
    not_finite(value).unwrap_or_else(|| {
        let point = if alternate && precision == 0 { "." } else { "" };
        format!("{value:.precision$}{point}")
    })
}

/// Mantissa digits and exponent of a value at least 0, rounded to `precision` digits after the point.
fn mantissa_exponent(value: f64, precision: usize) -> (String, i32) {
    let text = format!("{value:.precision$e}");
    match text.split_once('e') {
        Some((mantissa, exponent)) => (mantissa.to_string(), exponent.parse().unwrap_or(0)),
        None => (text, 0),
    }
}

fn with_exponent(mantissa: &str, exponent: i32) -> String {
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{mantissa}e{sign}{:02}", exponent.unsigned_abs())
}

fn exponent(value: f64, precision: usize, alternate: bool) -> String {
    not_finite(value).unwrap_or_else(|| {
        let (mut mantissa, exponent) = mantissa_exponent(value, precision);
        if alternate && precision == 0 {
            mantissa.push('.');
        }
        with_exponent(&mantissa, exponent)
    })
}

fn general(value: f64, precision: usize, alternate: bool) -> String {
    not_finite(value).unwrap_or_else(|| {
        let precision = precision.max(1);
        let (mantissa, exponent) = mantissa_exponent(value, precision - 1);
        // C's rule: the exponent *after rounding* decides.
        let as_exponent = exponent < -4 || exponent as i64 >= precision as i64;
        let digits = if as_exponent {
            mantissa
        } else {
            let after_point = (precision as i64 - 1 - exponent as i64) as usize;
            format!("{value:.after_point$}")
        };
        let digits = match (digits.contains('.'), alternate) {
            (true, false) => digits.trim_end_matches('0').trim_end_matches('.').to_string(),
            (false, true) => digits + ".",
            _ => digits,
        };
        if as_exponent { with_exponent(&digits, exponent) } else { digits }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Format, value, answer of glibc's `snprintf`.
    #[rustfmt::skip]
    const GLIBC: &[(&str, f64, &str)] = &[
        ("%g", 0.125, "0.125"), ("%g", -1.5, "-1.5"), ("%g", -2.675, "-2.675"),
        ("%.15g", 1000000000000000.0, "1e+15"), ("%.15g", 0.5, "0.5"), ("%.15g", 0.0, "0"),
        ("%.15g", 123456.5, "123456.5"), ("%.20g", 1e-05, "1.0000000000000000818e-05"), ("%.20g", 6.02214076e+23, "6.0221407599999998702e+23"),
        ("%.20g", -0.0, "-0"), ("%-15.8g", 0.125, "0.125          "), ("%-15.8g", 1.2345678901234568e+17, "1.2345679e+17  "),
        ("%-15.8g", 0.00012345678, "0.00012345678  "), ("%12.4f", 1e-300, "      0.0000"), ("%12.4f", 2.5, "      2.5000"),
        ("%12.4f", -1.5, "     -1.5000"), ("%12.4f", 0.1, "      0.1000"), ("%.0f", 0.0, "0"),
        ("%.0f", -0.3333333333333333, "-0"), ("%.0f", 6.02214076e+23, "602214075999999987023872"), ("%#.0f", 0.1, "0."),
        ("%#.0f", 3.5, "4."), ("%#.0f", 2.5, "2."), ("%e", 1e-05, "1.000000e-05"),
        ("%e", 5e-324, "4.940656e-324"), ("%e", 0.00012345678, "1.234568e-04"), ("%e", 1.0, "1.000000e+00"),
        ("%.3e", 9.9999995e-05, "1.000e-04"), ("%.3e", 1.7976931348623157e+308, "1.798e+308"), ("%.3e", 1e+16, "1.000e+16"),
        ("%.0e", 0.125, "1e-01"), ("%.0e", 1000000000000000.0, "1e+15"), ("%.0e", 0.1, "1e-01"),
        ("%+g", -0.3333333333333333, "-0.333333"), ("%+g", 1.2345678901234568e+17, "+1.23457e+17"), ("%+g", 0.0, "+0"),
        ("%+g", 1e+22, "+1e+22"), ("% g", 1e-05, " 1e-05"), ("% g", 1e-300, " 1e-300"),
        ("% g", 3.5, " 3.5"), ("%08.3f", 1234567.0, "1234567.000"), ("%08.3f", 1e-05, "0000.000"),
        ("%08.3f", 999999.5, "999999.500"), ("%-8.2fx", 0.125, "0.12    x"), ("%-8.2fx", 1e-05, "0.00    x"),
        ("%-8.2fx", -0.3333333333333333, "-0.33   x"), ("%-8.2fx", 6.02214076e+23, "602214075999999987023872.00x"), ("%#g", 1.0, "1.00000"),
        ("%#g", 5e-324, "4.94066e-324"), ("%G", 1e+16, "1E+16"), ("%G", 1.2345678901234568e+17, "1.23457E+17"),
        ("%G", 1000000000000000.0, "1E+15"), ("%G", 0.30000000000000004, "0.3"), ("%10.1E", 0.5, "   5.0E-01"),
        ("%10.1E", 1.7976931348623157e+308, "  1.8E+308"), ("%10.1E", 1.0, "   1.0E+00"), ("%.8g", 1234567.0, "1234567"),
        ("%.8g", 5e-324, "4.9406565e-324"), ("%.8g", 999999.5, "999999.5"), ("%d", 2.5, "2"),
        ("%d", 0.00012345678, "0"), ("%d", -2.675, "-2"), ("%5d", 9.9999995e-05, "    0"),
        ("%5d", 3.5, "    3"), ("%5d", -1.5, "   -1"), ("%-5d|", -0.0, "0    |"),
        ("%-5d|", 0.30000000000000004, "0    |"), ("%-5d|", 0.1, "0    |"), ("%05d", 1e-300, "00000"),
        ("%05d", -1.5, "-0001"), ("%+d", 9.9999995e-05, "+0"), ("%+d", 1e-05, "+0"),
        ("%+d", 999999.5, "+999999"), ("a%%b%gc", -0.0, "a%b-0c"), ("a%%b%gc", 0.00012345678, "a%b0.000123457c"),
        ("a%%b%gc", 1.0, "a%b1c"), ("a%%b%gc", 1e-05, "a%b1e-05c"), ("%#.3g", 1.7976931348623157e+308, "1.80e+308"),
        ("%#.3g", 9.9999995e-05, "0.000100"), ("%#.3g", 1e-05, "1.00e-05"), ("%.17g", 9.9999995e-05, "9.9999994999999998e-05"),
        ("%.17g", 1e-300, "1e-300"), ("%.17g", 5e-324, "4.9406564584124654e-324"), ("%g", f64::INFINITY, "inf"),
        ("%g", f64::NEG_INFINITY, "-inf"), ("%010.3f", f64::INFINITY, "       inf"), ("%010.3f", f64::NEG_INFINITY, "      -inf"),
        ("%F", f64::INFINITY, "INF"), ("%F", f64::NEG_INFINITY, "-INF"), ("%-6e|", f64::INFINITY, "inf   |"),
        ("%-6e|", f64::NEG_INFINITY, "-inf  |"), ("%+g", f64::INFINITY, "+inf"), ("%+g", f64::NEG_INFINITY, "-inf"),
    ];

    #[test]
    fn prints_what_glibc_prints() {
        for (format, value, expected) in GLIBC {
            assert_eq!(Printf::parse(format).unwrap().float(*value), *expected, "{format} of {value:e}");
        }
    }

    #[test]
    fn integers_keep_all_digits() {
        let print = |format: &str, value| Printf::parse(format).unwrap().integer(value);
        assert_eq!(print("%ld", i64::MIN), "-9223372036854775808");
        assert_eq!(print("%-6lld|", 42), "42    |");
        assert_eq!(print("%+.3i", 7), "+007");
        assert_eq!(print("%08.3d", 7), "     007");
        assert_eq!(print("%5.1f", 7), "  7.0");
        assert_eq!(Printf::parse("%-6s|").unwrap().text("Ar"), "Ar    |");
    }

    #[test]
    fn wrong_formats_are_told() {
        for format in ["", "abc", "%", "%q", "%5.2", "%g %g", "%*d", "%n", "%99999d", "%.1001f", "%é"] {
            assert!(Printf::parse(format).is_err(), "{format}");
        }
    }
}
