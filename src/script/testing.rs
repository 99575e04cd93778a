//! Helpers of unit tests.

use super::{Source, Span, Statement, Word};

/// A statement of blank-separated words; `'` quotes.
pub(crate) fn statement(line: &str) -> Statement {
    let mut words = Vec::new();
    for (k, part) in line.split('\'').enumerate() {
        let texts: Vec<&str> = if k % 2 == 1 { vec![part] } else { part.split_whitespace().collect() };
        words.extend(texts.into_iter().map(|text| Word { text: text.to_string(), span: Span::default() }));
    }
    Statement { source: Source::new("test", line), words, echo: Vec::new(), tentative: false }
}
