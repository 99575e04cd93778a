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
    /// Heads and rows; numbers are set to the right where a cell begins like one.
    Table(Vec<String>, Vec<Vec<String>>),
    /// Name of the file, the SVG itself, what it shows.
    Figure {
        name: String,
        svg: String,
        caption: String,
    },
}

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#222;background:#fff}\
h1{font-size:1.6rem}h2{font-size:1.25rem;margin-top:2.2rem;border-bottom:1px solid #ddd}\
.advice{font-size:1.1rem;padding:.8rem 1rem;background:#eef5fa;border-left:4px solid #0072b2}\
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.9rem;margin:.8rem 0}th,td{padding:.25rem .7rem;border-bottom:1px solid #ddd;\
text-align:left;white-space:nowrap}td.n{text-align:right;font-variant-numeric:tabular-nums}th{border-bottom:2px solid #999}\
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
    let mut table = String::from("<div class=\"wide\"><table>\n<tr>");
    heads.iter().for_each(|head| table += &format!("<th>{}</th>", escaped(head)));
    for row in rows {
        table += "</tr>\n<tr>";
        for cell in row {
            let class = if is_number(cell) { " class=\"n\"" } else { "" };
            table += &format!("<td{class}>{}</td>", escaped(cell));
        }
    }
    table + "</tr>\n</table></div>"
}

fn is_number(cell: &str) -> bool {
    cell.trim_start_matches('-').starts_with(|c: char| c.is_ascii_digit())
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
            Block::Table(vec!["x".into(), "y|z".into()], vec![vec!["-1.5".into(), "word".into()]]),
            Block::Figure { name: "one".into(), svg: "<svg></svg>".into(), caption: "what".into() },
        ];
        let page = html(&blocks);
        for part in ["<h1>a &lt; b</h1>", "do &amp; be", "<td class=\"n\">-1.5</td><td>word</td>", "<svg></svg>"] {
            assert!(page.contains(part), "{part} is not in {page}");
        }
        let page = markdown(&blocks);
        assert!(
            page.contains("# a < b\n\n**do & be**\n\n| x | y\\|z |\n|---|---|\n| -1.5 | word |\n\n![what](one.svg)")
        );
    }
}
