//! Every mistake in `tests/bad/` ends in the words its fixture begins with, and nothing is written.
//!
//! A fixture is a script whose first lines, `#! ...`, are what octant prints about it. `UPDATE_BAD=1 cargo test --test
//! wrong_input` writes these lines anew; read the difference before it is committed.

#[path = "common/cli.rs"]
mod common;

use std::fs;
use std::path::PathBuf;

use assert_cmd::Command;
use common::Folder;

const MARK: &str = "#!";

fn fixtures() -> Vec<PathBuf> {
    let folder = common::root().join("tests/bad");
    let mut paths: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

/// Runs a script; what octant printed about it. Asserts that it failed, said nothing else and wrote nothing.
fn complaint(folder: &Folder, script: &str) -> String {
    let before = folder.files();
    let mut octant = Command::cargo_bin("octant").unwrap();
    octant.current_dir(&folder.0).args(["run", script, "--log", "log"]);
    let done = octant.timeout(std::time::Duration::from_secs(60)).output().unwrap();
    let said = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(1), "{script}: {said}");
    assert_eq!(String::from_utf8_lossy(&done.stdout), "", "{script} was begun");
    let after = folder.files();
    assert_eq!(before.keys().collect::<Vec<_>>(), after.keys().collect::<Vec<_>>(), "{script}: a file was written");
    assert!(before == after, "{script}: a file was changed");
    said
}

/// `file:line:column: ` at the start of an error, as numbers.
fn place(first_line: &str) -> (String, usize, usize) {
    let mut parts = first_line.strip_prefix("ERROR: ").unwrap().splitn(4, ':');
    let mut next = || parts.next().unwrap_or_default().to_string();
    let (file, line, column) = (next(), next(), next());
    (file, line.parse().unwrap_or(0), column.parse().unwrap_or(0))
}

/// The picture shows the line that the message names, with carets from the column that it names.
fn check_picture(folder: &Folder, said: &str) {
    let mut lines = said.lines();
    let first = lines.next().unwrap();
    let (file, line, column) = place(first);
    assert!(line > 0 && column > 0, "no place: {first}");
    let text = String::from_utf8(fs::read(folder.0.join(&file)).unwrap()).unwrap();
    let Some(source) = text.lines().nth(line - 1) else {
        assert!(text.is_empty(), "{first}: there is no such line");
        return;
    };
    let shown = format!(" {line} | {source}");
    lines.find(|l| l.trim_end() == shown.trim_end()).unwrap_or_else(|| panic!("'{shown}' is not in\n{said}"));
    let carets = lines.next().unwrap();
    let begins = carets.find('^').unwrap_or_else(|| panic!("no carets in\n{said}"));
    assert_eq!(begins, shown.len() - source.len() + column - 1, "column of the carets in\n{said}");
}

#[test]
fn every_fixture_gets_its_message() {
    let update = std::env::var_os("UPDATE_BAD").is_some();
    let (scripts, data): (Vec<PathBuf>, Vec<PathBuf>) =
        fixtures().into_iter().partition(|p| p.extension().is_some_and(|e| e == "in"));
    assert!(scripts.len() > 200);
    let folder = Folder::new("fixtures");
    for path in &data {
        fs::copy(path, folder.0.join(path.file_name().unwrap())).unwrap();
    }
    let mut wrong = Vec::new();
    for path in &scripts {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if !cfg!(feature = "chemfiles") && name.starts_with("trajectory_") {
            continue;
        }
        let text = fs::read_to_string(path).unwrap();
        let expected: String = text.lines().take_while(|l| l.starts_with(MARK)).map(|l| format!("{l}\n")).collect();
        let judge = |text: &str| {
            fs::write(folder.0.join(&name), text).unwrap();
            let said = complaint(&folder, &name);
            check_picture(&folder, &said);
            fs::remove_file(folder.0.join(&name)).unwrap();
            said.lines().map(|l| format!("{MARK} {l}").trim_end().to_string() + "\n").collect::<String>()
        };
        let mut said = judge(&text);
        if said != expected && update {
            let script = &text[expected.len()..];
            // The lines written above the script move it, once.
            said = judge(&(said + script));
            fs::write(path, said + script).unwrap();
        } else if said != expected {
            wrong.push(format!("{name}: expected\n{expected}got\n{said}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Scripts that a fixture cannot hold, and the first line of what is said of them.
#[test]
fn odd_files_get_their_message() {
    let deep = format!("print $({}1{})\n", "(".repeat(300), ")".repeat(300));
    let cases: [(&str, &[u8], &str); 10] = [
        (
            "ampersand.in",
            b"run 5 &",
            "ampersand.in:1:7: run: expected a keyword, one of upto, start, stop, pre, post, every, got '&'",
        ),
        (
            "ampersands.in",
            b"units &\n&\n&\n",
            "ampersands.in:3:1: units: unknown unit style '&'; available: lj, real, metal, si",
        ),
        ("triple.in", b"print \"\"\"a\nb\n", "triple.in:1:7: expected a closing \"\"\", got the end of the line"),
        ("deep.in", deep.as_bytes(), "deep.in:1:209: formula: the formula is nested more than 200 deep"),
        (
            "crlf.in",
            b"units lj\r\nunits imperial\r\n",
            "crlf.in:2:7: units: unknown unit style 'imperial'; available: lj, real, metal, si",
        ),
        (
            "latin1.in",
            b"units lj\nprint caf\xe9 x\n",
            "latin1.in:2:12: print: expected a keyword, one of file, append, screen, universe, got 'x'",
        ),
        ("nul.in", b"units lj\nru\0n 5\n", "nul.in:2:1: ru\0n: unknown command 'ru\0n'"),
        (
            "binary.in",
            &[0xff, 0xfe, 0x80, 0x0a, 0x00],
            "binary.in:1:1: \u{fffd}\u{fffd}\u{fffd}: unknown command '\u{fffd}\u{fffd}\u{fffd}'",
        ),
        (
            "nothing.in",
            b"pair_coeff",
            "nothing.in:1:1: pair_coeff: expected an atom type or a range of types, got the end of the line",
        ),
        (
            "wide.in",
            "print \"größe\" grün\n".as_bytes(),
            "wide.in:1:15: print: expected a keyword, one of file, append, screen, universe, got 'grün'",
        ),
    ];
    let folder = Folder::new("odd");
    let mut wrong = String::new();
    for (name, text, expected) in cases {
        fs::write(folder.0.join(name), text).unwrap();
        let said = complaint(&folder, name);
        wrong += &if said.lines().next() == Some(&format!("ERROR: {expected}")) {
            String::new()
        } else {
            format!("expected {expected}\ngot {said}")
        };
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn a_script_that_is_no_file_is_named() {
    let folder = Folder::new("absent");
    fs::create_dir(folder.0.join("folder")).unwrap();
    for (script, why) in [("absent.in", "No such file or directory"), ("folder", "Is a directory")] {
        let mut octant = Command::cargo_bin("octant").unwrap();
        let done = octant.current_dir(&folder.0).args(["run", script]).output().unwrap();
        assert_eq!(done.status.code(), Some(1));
        let said = String::from_utf8(done.stderr).unwrap();
        assert!(said.starts_with(&format!("ERROR: {script}: cannot read: {why}")), "{said}");
        assert_eq!(fs::read_dir(&folder.0).unwrap().count(), 1);
    }
}

/// An empty script, and one that ends its lines as other systems do, are fine.
#[test]
fn harmless_files_are_fine() {
    let folder = Folder::new("harmless");
    for (name, text) in
        [("empty.in", ""), ("crlf.in", "units lj\r\nprint 'a b'\r\n"), ("mark.in", "\u{feff}units lj\n")]
    {
        fs::write(folder.0.join(name), text).unwrap();
        let mut octant = Command::cargo_bin("octant").unwrap();
        octant.current_dir(&folder.0).args(["run", name, "--quiet"]).assert().code(0).stdout("").stderr("");
    }
}

/// Files that cannot be written are refused whichever way they are named.
#[test]
fn unwritable_files_of_the_command_line_are_named() {
    let folder = Folder::new("unwritable");
    fs::write(folder.0.join("a.in"), "print hello\n").unwrap();
    for (option, said) in [
        ("--log", "ERROR: no/x: cannot write: the folder 'no': No such file or directory (os error 2)\n"),
        (
            "--json",
            "ERROR: --json no/x: cannot write 'no/x': the folder 'no': No such file or directory (os error 2)\n",
        ),
    ] {
        let mut octant = Command::cargo_bin("octant").unwrap();
        octant.current_dir(&folder.0).args(["run", "a.in", option, "no/x"]).assert().code(1).stdout("").stderr(said);
        assert_eq!(folder.files().len(), 1);
    }
}
