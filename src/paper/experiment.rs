//! An experiment's rows, as CSV columns and as a printed table.

use crate::output::printf::format_g;

/// Column names and cells of a row.
pub type Row = Vec<(&'static str, String)>;

/// What an experiment is called and how it is shown.
#[derive(Debug)]
pub struct Experiment {
    /// Of the CSV file, without `.csv`.
    pub name: &'static str,
    /// A line above the printed table.
    pub title: &'static str,
    /// Columns of the printed table; the CSV file has more.
    pub shown: &'static [&'static str],
}

impl Experiment {
    /// Heads of the printed table.
    pub fn heads(&self) -> String {
        self.line(|head| head.to_string())
    }

    /// A line of the printed table.
    pub fn table_line(&self, row: &Row) -> String {
        self.line(|wanted| row.iter().find(|(head, _)| *head == wanted).map_or(String::new(), |(_, cell)| cell.clone()))
    }

    fn line(&self, cell: impl Fn(&str) -> String) -> String {
        // As wide as "standard:2+zorder+radix", the longest cell, and numbers of six digits.
        let width = |head: &str| match head {
            "search" => 23,
            "integrator" => 10,
            _ => head.len().max(9),
        };
        let cells = self.shown.iter().map(|head| format!("{:>width$}", cell(head), width = width(head)));
        cells.collect::<Vec<_>>().join(" ")
    }
}

/// A number as the tables have it: six significant digits.
pub fn number(x: f64) -> String {
    format_g(x, 0, 6, false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_the_shown_columns_in_their_order() {
        let experiment = Experiment { name: "", title: "", shown: &["search", "particles", "b"] };
        let row = vec![("b", "1".into()), ("c", "2".into()), ("search", "standard:2.52".into())];
        assert_eq!(experiment.table_line(&row), "          standard:2.52                   1");
        assert_eq!(experiment.heads(), "                 search particles         b");
    }
}
