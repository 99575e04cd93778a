//! Input text, places in it, and the one error type that points at them.

use std::fmt;
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, SourceCode};

/// A text file the user handed us (a script or a data file) and the name it is called by in messages.
#[derive(Debug, PartialEq, Eq)]
pub struct Source {
    /// Path as the user wrote it.
    pub name: String,
    /// Whole text.
    pub text: String,
}

impl Source {
    /// A file's text under the name that messages shall show. Bytes that are no UTF-8 become replacement characters; a byte
    /// order mark, which some editors write, is dropped.
    pub fn from_bytes(name: impl Into<String>, bytes: &[u8]) -> Arc<Self> {
        let text = String::from_utf8_lossy(bytes);
        Self::new(name, text.strip_prefix('\u{feff}').unwrap_or(&text))
    }

    /// Wraps text under the name that messages shall show.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Arc<Self> {
        Arc::new(Self { name: name.into(), text: text.into() })
    }

    /// Line and column (both from 1, columns in characters) of a byte offset.
    pub fn line_column(&self, offset: usize) -> (usize, usize) {
        let mut offset = offset.min(self.text.len());
        while !self.text.is_char_boundary(offset) {
            offset -= 1;
        }
        let before = &self.text[..offset];
        let line = before.bytes().filter(|b| *b == b'\n').count() + 1;
        let start = before.rfind('\n').map_or(0, |k| k + 1);
        (line, before[start..].chars().count() + 1)
    }
}

/// A byte range `start..end` of a [`Source`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    pub start: usize,
    pub end: usize,
}

impl Span {
    pub fn new(start: usize, end: usize) -> Self {
        Self { start, end: end.max(start) }
    }

    /// Smallest span that covers both.
    pub fn join(self, other: Self) -> Self {
        Self { start: self.start.min(other.start), end: self.end.max(other.end) }
    }
}

/// What is wrong with the user's input, and where: prints as `file:line:column: message`;
/// its miette report adds the source line with a caret.
#[derive(Clone, Debug)]
pub struct InputError {
    pub source: Arc<Source>,
    pub span: Span,
    /// `command: what was expected, what came`.
    pub message: String,
    /// What the user can do about it, where that is known.
    pub help: Option<String>,
}

impl InputError {
    /// The span is cut to the text and to whole characters, so that it can always be shown.
    pub fn new(source: &Arc<Source>, span: Span, message: impl Into<String>) -> Self {
        let whole =
            |offset: usize| (0..=offset.min(source.text.len())).rev().find(|k| source.text.is_char_boundary(*k));
        let span = Span::new(whole(span.start).unwrap_or(0), whole(span.end).unwrap_or(0));
        Self { source: source.clone(), span, message: message.into(), help: None }
    }

    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (line, column) = self.source.line_column(self.span.start);
        write!(f, "{}:{line}:{column}: {}", self.source.name, self.message)
    }
}

impl std::error::Error for InputError {}

impl Diagnostic for InputError {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|h| Box::new(h) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(self)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let length = self.span.end - self.span.start;
        let label = LabeledSpan::underline(self.span.start..self.span.start + length.max(1));
        Some(Box::new(std::iter::once(label)))
    }
}

impl SourceCode for InputError {
    fn read_span<'a>(
        &'a self,
        span: &miette::SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn miette::SpanContents<'a> + 'a>, miette::MietteError> {
        // Whole lines, however little of them is asked for.
        let text = &self.source.text;
        let start = text[..span.offset().min(text.len())].rfind('\n').map_or(0, |k| k + 1);
        let end = (span.offset() + span.len()).min(text.len());
        let end = text[end..].find('\n').map_or(text.len(), |k| end + k);
        let contents = text.read_span(&(start..end).into(), before, after)?;
        Ok(Box::new(miette::MietteSpanContents::new_named(
            self.source.name.clone(),
            contents.data(),
            *contents.span(),
            contents.line(),
            contents.column(),
            contents.line_count(),
        )))
    }
}
