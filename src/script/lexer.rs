//! From text to lines to words, as LAMMPS reads its input (doc page `Commands_parse`).

use std::sync::Arc;

use super::mapped::Mapped;
use super::source::{InputError, Source, Span};

/// A word of a line: its text without quotes, and its place with them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Token {
    pub text: Mapped,
    pub span: Span,
}

/// Blanks between words.
fn is_blank(c: char) -> bool {
    matches!(c, ' ' | '\t' | '\n' | '\r' | '\x0c')
}

/// Splits a script into logical lines: a line whose last printable character is `&` goes on in the next one, and so does a line
/// with an open `"""`. Both hold in comments too, as in LAMMPS. Trailing blanks are cut.
pub fn logical_lines(source: &Source) -> Vec<Mapped> {
    let mut lines = Vec::new();
    let mut line = Mapped::default();
    let mut triple_quotes = 0;
    let mut start = 0;
    for piece in source.text.split_inclusive('\n') {
        let last = start + piece.len() == source.text.len();
        let printable = piece.trim_end_matches(is_blank);
        match printable.strip_suffix('&') {
            Some(continued) if !last => {
                line.push_copied(continued, start);
                triple_quotes += continued.matches("\"\"\"").count();
            }
            _ => {
                triple_quotes += piece.matches("\"\"\"").count();
                if triple_quotes % 2 == 1 && !last {
                    line.push_copied(piece, start);
                } else {
                    line.push_copied(printable, start);
                    lines.push(std::mem::take(&mut line));
                    triple_quotes = 0;
                }
            }
        }
        start += piece.len();
    }
    lines
}

/// The quote that is open while one walks along a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct QuoteTracker {
    open: Option<(&'static str, usize)>,
}

impl QuoteTracker {
    /// Takes in the text from byte `at` of a line on; returns the length of what stands there: a quote mark or one character.
    pub fn advance(&mut self, line: &str, at: usize) -> usize {
        let rest = &line[at..];
        let mark = ["\"\"\"", "\"", "'"].into_iter().find(|mark| rest.starts_with(mark));
        match (self.open, mark) {
            (None, Some(mark)) => {
                self.open = Some((mark, at));
                mark.len()
            }
            (Some((open, _)), _) if rest.starts_with(open) => {
                self.open = None;
                open.len()
            }
            _ => rest.chars().next().map_or(1, char::len_utf8),
        }
    }

    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// An error if a quote is still open at the end of `line`.
    pub fn finish(&self, source: &Arc<Source>, line: &Mapped) -> Result<(), InputError> {
        match self.open {
            None => Ok(()),
            Some((mark, at)) => Err(InputError::new(
                source,
                line.span(at..at + mark.len()),
                format!("expected a closing {mark}, got the end of the line"),
            )),
        }
    }
}

/// The line without its comment: `#` outside quotes and what follows.
pub fn strip_comment(source: &Arc<Source>, line: &Mapped) -> Result<Mapped, InputError> {
    let text = line.text();
    let mut quotes = QuoteTracker::default();
    let mut at = 0;
    while at < text.len() {
        if !quotes.is_open() && text[at..].starts_with('#') {
            return Ok(line.slice(0..at));
        }
        at += quotes.advance(text, at);
    }
    quotes.finish(source, line)?;
    Ok(line.clone())
}

/// Splits a line into words. A word that starts with a quote reaches to the closing one, which a blank must follow.
pub fn split_words(source: &Arc<Source>, line: &Mapped) -> Result<Vec<Token>, InputError> {
    let text = line.text();
    let mut words = Vec::new();
    let mut at = 0;
    loop {
        at += text[at..].len() - text[at..].trim_start_matches(is_blank).len();
        let rest = &text[at..];
        if rest.is_empty() {
            return Ok(words);
        }
        if let Some(mark) = ["\"\"\"", "\"", "'"].into_iter().find(|mark| rest.starts_with(mark)) {
            let start = at + mark.len();
            let Some(length) = text[start..].find(mark) else {
                return Err(InputError::new(
                    source,
                    line.span(at..start),
                    format!("expected a closing {mark}, got the end of the line"),
                ));
            };
            let (open, end) = (at, start + length);
            at = end + mark.len();
            if let Some(c) = text[at..].chars().next().filter(|c| !is_blank(*c)) {
                return Err(InputError::new(
                    source,
                    line.span(at..at + c.len_utf8()),
                    format!("expected a blank after the closing {mark}, got '{c}'"),
                ));
            }
            words.push(Token { text: line.slice(start..end), span: line.span(open..at) });
        } else {
            let end = at + rest.find(is_blank).unwrap_or(rest.len());
            words.push(Token { text: line.slice(at..end), span: line.span(at..end) });
            at = end;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<String> {
        logical_lines(&Source::new("t", text)).iter().map(|l| l.text().to_string()).collect()
    }

    fn words(text: &str) -> Result<Vec<String>, InputError> {
        let source = Source::new("t", text);
        let line = strip_comment(&source, &logical_lines(&source)[0])?;
        Ok(split_words(&source, &line)?.iter().map(|t| t.text.text().to_string()).collect())
    }

    #[test]
    fn lines_are_those_lammps_echoes() {
        assert_eq!(lines("print &\n  \"hello\"\n"), ["print   \"hello\""]);
        assert_eq!(lines("# comment &  \r\nrun 1\r\nrun 2"), ["# comment run 1", "run 2"]);
        assert_eq!(lines("# a \"\"\" b\nrun 1\nx # \"\"\" c\nrun 2"), ["# a \"\"\" b\nrun 1\nx # \"\"\" c", "run 2"]);
        assert_eq!(lines("print \"\"\"a &\nb\"\"\"  \n\n \t\n"), ["print \"\"\"a b\"\"\"", "", ""]);
        assert_eq!(lines("print \"end\" &\n"), ["print \"end\" &"]);
        assert!(lines("").is_empty());
    }

    #[test]
    fn words_keep_their_quotes_closed() {
        assert_eq!(words("a\t'b \"c\"' # d").unwrap(), ["a", "b \"c\""]);
        assert_eq!(words("print \"\"\"a\n'b\"\"\" \"\" x#y").unwrap(), ["print", "a\n'b", "", "x"]);
        assert_eq!(words("a b\"c d\" e").unwrap(), ["a", "b\"c", "d\"", "e"]);
        for wrong in ["print \"a", "it's", "print \"a\"b", "print \"\"\"a\"\"", "x 'é'é"] {
            assert!(words(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn words_keep_their_place() {
        let source = Source::new("t", "run &\n  100 &\n upto");
        let line = &logical_lines(&source)[0];
        let words = split_words(&source, line).unwrap();
        let places: Vec<&str> = words.iter().map(|w| w.text.whole()).map(|s| &source.text[s.start..s.end]).collect();
        assert_eq!(places, ["run", "100", "upto"]);
    }
}
