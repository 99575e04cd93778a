//! Text that knows where each of its bytes came from.

use std::ops::Range;

use super::source::Span;

/// Text put together from parts of a source file and from substituted values, with the place of every byte in the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mapped {
    text: String,
    pieces: Vec<Piece>,
}

/// A run of bytes from `at` to the next piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Piece {
    at: usize,
    origin: Origin,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    /// Copied from the file, the first byte from this offset.
    Copied(usize),
    /// Stands for this place in the file, a `$` expression.
    Stands(Span),
}

impl Mapped {
    /// Text that stands in the file at `offset`.
    pub fn copied(text: &str, offset: usize) -> Self {
        let mut mapped = Self::default();
        mapped.push_copied(text, offset);
        mapped
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    /// Appends text that stands in the file at `offset`.
    pub fn push_copied(&mut self, text: &str, offset: usize) {
        self.push(text, Origin::Copied(offset));
    }

    /// Appends text that stands for a place in the file.
    pub fn push_standing_for(&mut self, text: &str, span: Span) {
        self.push(text, Origin::Stands(span));
    }

    fn push(&mut self, text: &str, origin: Origin) {
        // An empty piece is kept only where there is no other to tell the place.
        if !text.is_empty() || self.pieces.is_empty() {
            self.drop_empty_piece();
            self.pieces.push(Piece { at: self.text.len(), origin });
            self.text.push_str(text);
        }
    }

    fn drop_empty_piece(&mut self) {
        if self.pieces.last().is_some_and(|p| p.at >= self.text.len()) {
            self.pieces.pop();
        }
    }

    /// A part of the text; `range` is cut to the text and to whole characters.
    pub fn slice(&self, range: Range<usize>) -> Self {
        let end = floor_boundary(&self.text, range.end);
        let start = floor_boundary(&self.text, range.start).min(end);
        let mut part = Self { text: self.text[start..end].to_string(), pieces: Vec::new() };
        for (k, piece) in self.pieces.iter().enumerate() {
            let next = self.pieces.get(k + 1).map_or(usize::MAX, |p| p.at);
            let last_before_end = piece.at < end || (start == end && piece.at <= start);
            if next > start && last_before_end {
                let skipped = start.saturating_sub(piece.at);
                let origin = match piece.origin {
                    Origin::Copied(offset) => Origin::Copied(offset + skipped),
                    stands => stands,
                };
                part.pieces.push(Piece { at: piece.at.saturating_sub(start), origin });
            }
        }
        part
    }

    /// Appends another text with its places.
    pub fn append(&mut self, other: &Self) {
        let base = self.text.len();
        self.drop_empty_piece();
        self.pieces.extend(other.pieces.iter().map(|p| Piece { at: base + p.at, origin: p.origin }));
        self.text.push_str(&other.text);
    }

    /// Place in the file of a range of the text.
    pub fn span(&self, range: Range<usize>) -> Span {
        let first = self.place(range.start);
        if range.end <= range.start {
            return Span::new(first.start, first.start);
        }
        first.join(self.place(range.end.min(self.text.len()).saturating_sub(1).max(range.start)))
    }

    /// Place of the whole text.
    pub fn whole(&self) -> Span {
        self.span(0..self.text.len())
    }

    /// Place of one byte; past the end, the end of the last piece.
    fn place(&self, offset: usize) -> Span {
        let index = self.pieces.partition_point(|p| p.at <= offset);
        match self.pieces.get(index.saturating_sub(1)) {
            None => Span::default(),
            Some(Piece { origin: Origin::Stands(span), .. }) if offset >= self.text.len() => {
                Span::new(span.end, span.end)
            }
            Some(Piece { origin: Origin::Stands(span), .. }) => *span,
            Some(Piece { at, origin: Origin::Copied(start) }) => {
                let place = start + offset.min(self.text.len()).saturating_sub(*at);
                Span::new(place, place + usize::from(offset < self.text.len()))
            }
        }
    }
}

fn floor_boundary(text: &str, offset: usize) -> usize {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    offset
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_knows_its_place() {
        let mut line = Mapped::copied("run ", 10);
        line.push_standing_for("1000", Span::new(14, 18));
        line.push_copied(" pre no", 18);
        assert_eq!(line.text(), "run 1000 pre no");
        assert_eq!(line.span(0..3), Span::new(10, 13));
        assert_eq!(line.span(5..6), Span::new(14, 18));
        assert_eq!(line.span(4..12), Span::new(14, 22));
        let part = line.slice(6..12);
        assert_eq!(part.text(), "00 pre");
        assert_eq!((part.span(0..1), part.span(3..6)), (Span::new(14, 18), Span::new(19, 22)));
        assert_eq!(line.slice(15..15).whole(), Span::new(25, 25));
        let mut both = part.clone();
        both.append(&Mapped::copied("x", 40));
        assert_eq!(both.span(6..7), Span::new(40, 41));
    }
}
