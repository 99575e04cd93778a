//! Ctrl-C ends a run cleanly.
#![cfg(unix)]

#[path = "common/cli.rs"]
mod common;

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use common::{Folder, melt};

fn start(folder: &Folder) -> Child {
    Command::new(assert_cmd::cargo::cargo_bin("octant"))
        .current_dir(&folder.0)
        .args(["run", "a.in", "--json", "report.json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits until the run is under way: its log has a row beyond step 0.
fn wait_for_steps(folder: &Folder) {
    let begun = Instant::now();
    while !(folder.has("log.octant") && folder.read("log.octant").lines().any(|l| l.trim_start().starts_with("50 "))) {
        assert!(begun.elapsed() < Duration::from_secs(60), "no steps after a minute");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([name, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

#[test]
fn ctrl_c_finishes_the_step_and_the_files() {
    let folder = Folder::new("interrupt");
    let trajectory = if cfg!(feature = "chemfiles") { "dump t all dcd 50 melt.dcd" } else { "" };
    let run = format!(
        "thermo 50\nthermo_modify flush yes\ndump d all custom 50 melt.dump id x y z\n{trajectory}\nrun 100000000\n\
         print 'never reached'\nwrite_data never.data"
    );
    folder.write("a.in", &melt(&run));
    for name in ["-INT", "-TERM", "-INT"] {
        // Later rounds overwrite what the first one left.
        let _ = std::fs::remove_file(folder.0.join("log.octant"));
        let child = start(&folder);
        wait_for_steps(&folder);
        signal(&child, name);
        let asked = Instant::now();
        let done = child.wait_with_output().unwrap();
        assert!(asked.elapsed() < Duration::from_secs(5), "took {:?} to stop", asked.elapsed());
        let said = String::from_utf8(done.stdout).unwrap();
        assert_eq!((done.status.code(), done.stderr.as_slice()), (Some(130), &b""[..]), "{said}");

        let log = folder.read("log.octant");
        for text in [&said, &log] {
            let lines: Vec<&str> = text.lines().collect();
            let end = lines.iter().position(|l| l.starts_with("Loop time of")).expect("no end of the table");
            let last: i64 = lines[end - 1].split_whitespace().next().unwrap().parse().unwrap();
            assert!(lines[end].contains(&format!("for {last} steps with 256 atoms")), "{}", lines[end]);
            assert!(lines.iter().any(|l| l.starts_with("Total wall time:")));
            assert!(lines.iter().any(|l| l.starts_with("Interrupted: ")));
            assert!(!text.contains("never reached\n") || text == &log && !text.contains("\nnever reached\n"));
        }
        assert!(said.lines().any(|l| l.starts_with("Wrote melt.dump: ")));
        assert_eq!(said.lines().last(), Some("Wrote log.octant: log"));
        assert!(!folder.has("never.data"));

        // Whole frames only, each with all its atoms.
        let dump = folder.read("melt.dump");
        let frames: Vec<&str> = dump.split("ITEM: TIMESTEP\n").skip(1).collect();
        assert!(frames.len() >= 2 && dump.ends_with('\n'));
        assert!(frames.iter().all(|f| f.lines().count() == 8 + 256));
        let report: serde_json::Value = serde_json::from_str(&folder.read("report.json")).unwrap();
        let written = report["files"].as_array().unwrap().iter().find(|f| f["path"] == "melt.dump").unwrap();
        assert_eq!(written["frames"], frames.len());
        if cfg!(feature = "chemfiles") {
            // A DCD file tells how many frames it has, and each has the same length.
            let bytes = std::fs::read(folder.0.join("melt.dcd")).unwrap();
            let count = u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize;
            assert_eq!(count, frames.len());
        }
    }
}
