//! A page as HTML that needs no other file, and as Markdown with its figures beside.

use std::fmt::Write as _;
use std::path::Path;

use crate::Error;
use crate::output::write_whole;

/// A piece of a page. Texts are plain.
#[derive(Clone, Debug)]
pub enum Block {
    Title(String),
    /// The one sentence to take away.
    Advice(String),
    Heading(String),
    Text(String),
    /// Heads and rows; columns of numbers are set to the right, long texts are broken.
    Table(Vec<String>, Vec<Vec<String>>),
    /// Name of the file, the SVG itself, what it shows.
    Figure {
        name: String,
        svg: String,
        caption: String,
    },
}

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:92rem;margin:2rem auto;padding:0 1rem;color:#222;background:#fff}\
p,figure{max-width:60rem}h1{font-size:1.6rem}h2{font-size:1.25rem;margin-top:2.2rem;border-bottom:1px solid #ddd}\
.advice{font-size:1.1rem;padding:.8rem 1rem;background:#eef5fa;border-left:4px solid #0072b2}\
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.85rem;margin:.8rem 0}th,td{padding:.2rem .55rem;border-bottom:1px solid #ddd;\
text-align:left;vertical-align:bottom}td{vertical-align:top}td.t{min-width:24rem}\
.many{font-size:.75rem}.many th,.many td{padding:.2rem .3rem}td.n{white-space:nowrap}.n{text-align:right;font-variant-numeric:tabular-nums}th{border-bottom:2px solid #999}\
figure{margin:1.2rem 0}figure svg{max-width:100%;height:auto}figcaption{font-size:.9rem;color:#555}";

/// Writes `report.html`, `report.md` and the figures.
pub fn write(folder: &Path, blocks: &[Block]) -> Result<(), Error> {
    let file = |name: &str, text: &str| {
        let path = folder.join(name);
        write_whole(&path, |out| out.write_all(text.as_bytes())).map_err(|e| Error::file(&path, "cannot write", e))
    };
    for block in blocks {
        if let Block::Figure { name, svg, .. } = block {
            file(&format!("{name}.svg"), svg)?;
        }
    }
    file("report.md", &markdown(blocks))?;
    file("report.html", &html(blocks))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn html(blocks: &[Block]) -> String {
    let title = blocks.iter().find_map(|block| if let Block::Title(text) = block { Some(text.as_str()) } else { None });
    let title = escaped(title.unwrap_or("octant report"));
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
    );
    for block in blocks {
        let _ = match block {
            Block::Title(text) => writeln!(page, "<h1>{}</h1>", escaped(text)),
            Block::Advice(text) => writeln!(page, "<p class=\"advice\">{}</p>", escaped(text)),
            Block::Heading(text) => writeln!(page, "<h2>{}</h2>", escaped(text)),
            Block::Text(text) => writeln!(page, "<p>{}</p>", escaped(text)),
            Block::Figure { svg, caption, .. } => {
                writeln!(page, "<figure>{svg}<figcaption>{}</figcaption></figure>", escaped(caption))
            }
            Block::Table(heads, rows) => writeln!(page, "{}", html_table(heads, rows)),
        };
    }
    page + "</body>\n</html>\n"
}

fn html_table(heads: &[String], rows: &[Vec<String>]) -> String {
    let cells = |column: usize| rows.iter().filter_map(move |row| row.get(column)).filter(|cell| !cell.is_empty());
    let numbers: Vec<bool> =
        (0..heads.len()).map(|column| cells(column).count() > 0 && cells(column).all(|cell| is_number(cell))).collect();
    let class = |column: usize, cell: &str| match numbers.get(column) {
        Some(true) => " class=\"n\"",
        _ if cell.chars().count() > LONG => " class=\"t\"",
        _ => "",
    };
    // Numbers stay on a line, but where there is little room ranges go below them; texts are broken where the page is narrow.
    let broken =
        |cell: &str| if heads.len() > MANY && is_number(cell) { cell.replace(" (", "<br>(") } else { cell.into() };
    let row = |tag: &str, cells: &[String]| {
        let cell = |(k, cell): (usize, &String)| format!("<{tag}{}>{}</{tag}>", class(k, cell), broken(&escaped(cell)));
        format!("<tr>{}</tr>\n", cells.iter().enumerate().map(cell).collect::<String>())
    };
    let many = if heads.len() > MANY { " class=\"many\"" } else { "" };
    let mut table = format!("<div class=\"wide\"><table{many}>\n");
    // Names and values need no heads.
    if heads.iter().any(|head| !head.is_empty()) {
        table += &row("th", heads);
    }
    rows.iter().for_each(|cells| table += &row("td", cells));
    table + "</table></div>"
}

/// Columns from which on a table is set small.
const MANY: usize = 9;

/// Letters of a text that is broken into lines.
const LONG: usize = 60;

/// Whether a cell has nothing but numbers, with their errors or ranges.
fn is_number(cell: &str) -> bool {
    let digits = cell.trim_start_matches('-').starts_with(|c: char| c.is_ascii_digit());
    digits && cell.replace(" to ", " ").chars().all(|c| c.is_ascii_digit() || "+-.e ±()".contains(c))
}

fn markdown(blocks: &[Block]) -> String {
    let bars = |cells: &[String]| {
        let cells = cells.iter().map(|cell| cell.replace('|', "\\|"));
        format!("| {} |\n", cells.collect::<Vec<_>>().join(" | "))
    };
    let mut page = String::new();
    for block in blocks {
        page += &match block {
            Block::Title(text) => format!("# {text}\n\n"),
            Block::Advice(text) => format!("**{text}**\n\n"),
            Block::Heading(text) => format!("## {text}\n\n"),
            Block::Text(text) => format!("{text}\n\n"),
            Block::Figure { name, caption, .. } => format!("![{caption}]({name}.svg)\n\n{caption}\n\n"),
            Block::Table(heads, rows) => {
                let line = format!("|{}\n", "---|".repeat(heads.len()));
                bars(heads) + &line + &rows.iter().map(|row| bars(row)).collect::<String>() + "\n"
            }
        };
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_holds_what_it_is_given() {
        let blocks = [
            Block::Title("a < b".into()),
            Block::Advice("do & be".into()),
            Block::Table(vec!["x".into(), "y|z".into()], vec![vec!["-1.5".into(), "2 words".into()]]),
            Block::Table(vec![String::new(), String::new()], vec![vec!["long".repeat(20), "3 (2.5 to 1e-3)".into()]]),
            Block::Table(
                (0..=MANY).map(|k| k.to_string()).collect(),
                vec![(0..=MANY).map(|k| if k % 2 == 0 { "words".into() } else { "3 (2.5 to 1e-3)".into() }).collect()],
            ),
            Block::Figure { name: "one".into(), svg: "<svg></svg>".into(), caption: "what".into() },
        ];
        let page = html(&blocks);
        for part in [
            "<h1>a &lt; b</h1>",
            "do &amp; be",
            "<th class=\"n\">x</th><th>y|z</th>",
            "<td class=\"n\">-1.5</td><td>2 words</td>",
            "<svg></svg>",
        ] {
            assert!(page.contains(part), "{part} is not in {page}");
        }
        assert!(
            page.contains("<table>\n<tr><td class=\"t\">longlong")
                && page.contains("<td class=\"n\">3 (2.5 to 1e-3)</td>")
                && page.contains("<td>words</td><td class=\"n\">3<br>(2.5 to 1e-3)</td>"),
            "{page}"
        );
        let page = markdown(&blocks);
        assert!(
            page.contains("# a < b\n\n**do & be**\n\n| x | y\\|z |\n|---|---|\n| -1.5 | 2 words |\n\n")
                && page.contains("\n\n![what](one.svg)")
        );
    }
}
