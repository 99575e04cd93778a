//! The command line: exit codes, options, the JSON report, what goes to the screen.

#[path = "common/cli.rs"]
mod common;

use std::io::Read;
use std::process::{Command, Stdio};

use common::{Folder, melt};
use serde_json::Value;

const RUN: &str = "thermo 10\ndump d all atom 10 melt.dump\nrun 20\nrun 20";

/// Steps of the thermo rows.
fn rows(text: &str) -> Vec<Vec<f64>> {
    let numbers = |line: &str| line.split_whitespace().map(|w| w.parse().ok()).collect::<Option<Vec<f64>>>();
    text.lines().filter_map(numbers).filter(|row| row.len() == 6).collect()
}

#[test]
fn a_wrong_command_line_ends_with_2() {
    let folder = Folder::new("usage");
    folder.write("a.in", &melt("run 0"));
    for args in [
        "fly a.in",
        "run",
        "run a.in --threads 0",
        "run a.in --threads many",
        "run a.in --search quick",
        "run a.in --search octant:1.9",
        "run a.in --search octant+fast",
        "neighbors a.in --search standard:0",
        "run a.in --search brute:2",
        "run a.in --precision half",
        "run a.in --backend tpu",
        "run a.in -v novalue",
        "run a.in -v =3",
        "run a.in b.in",
        "check",
        "neighbors a.in --cutoff -1",
        "neighbors a.in --cutoff nan",
        "neighbors a.in --cutoff inf",
        "--frob",
    ] {
        let said = folder.fails(2, args);
        assert!(said.to_lowercase().contains("usage") || said.contains("For more information"), "{args}: {said}");
    }
    let said = folder.fails(2, "neighbors a.in --search octant:1.9");
    assert!(
        said.contains("cells of the search 'octant' have an edge of at least 2 neighbor cutoffs, got 1.9: particles"),
        "{said}"
    );
    assert_eq!(folder.files().len(), 1, "a wrong command line wrote a file");
    assert_eq!(folder.octant("--version").assert().code(0).get_output().stderr.len(), 0);
}

#[test]
fn what_this_version_lacks_is_refused() {
    let folder = Folder::new("lacks");
    folder.write("a.in", &melt("run 0"));
    // Where there is a GPU, it is hidden.
    let hidden = |command: &str| folder.octant(command).env("CUDA_VISIBLE_DEVICES", "-1").assert();
    let stderr = |command: &str| String::from_utf8_lossy(&hidden(command).code(1).get_output().stderr).into_owned();
    let (cuda, device) = (stderr("run a.in --backend cuda"), stderr("run a.in --device 3"));
    if cfg!(feature = "cuda") {
        let reasons = ["there is no NVIDIA driver on this machine", "no CUDA device: the driver sees none"];
        assert!(reasons.iter().any(|r| cuda.starts_with(&format!("ERROR: --backend cuda: {r}"))), "{cuda}");
        assert!(reasons.iter().any(|r| device.starts_with(&format!("ERROR: {r}"))), "{device}");
    } else {
        assert_eq!(cuda, "ERROR: --backend cuda: this octant was built without CUDA (cargo feature `cuda`)\n");
        assert_eq!(device, "ERROR: --device 3: this octant was built without CUDA (cargo feature `cuda`)\n");
    }
    let said = stderr("run a.in --backend cpu --device 0");
    if cfg!(feature = "cuda") {
        assert_eq!(said, "ERROR: --device 0 names a GPU, but --backend cpu uses none\n");
    }
    assert_eq!(folder.files().len(), 1);
    let odd = folder.octant("run a.in --backend cpu").env("OCTANT_ISA", "mmx").assert().code(1);
    let said = String::from_utf8_lossy(&odd.get_output().stderr).into_owned();
    assert_eq!(said, "ERROR: OCTANT_ISA=mmx is no instruction set; known: portable, avx2, avx512\n");
    assert_eq!(folder.files().len(), 1);
    let auto = hidden("run a.in").code(0);
    let said = String::from_utf8_lossy(&auto.get_output().stdout).into_owned();
    assert_eq!(said.matches("Running on the CPU: ").count(), 1, "one line tells why:\n{said}");
}

/// Back ends, searches and threads: the same bits.
#[test]
fn engines_and_threads_give_the_same_table() {
    let folder = Folder::new("same");
    folder.write("a.in", &melt(RUN));
    for (precision, tolerance) in [("double", 1e-6), ("mixed", 1e-5), ("single", 1e-4)] {
        let expected = rows(&folder.says(&format!("run a.in --backend cpu --threads 1 --precision {precision}")));
        assert_eq!(expected.iter().map(|r| r[0]).collect::<Vec<_>>(), [0.0, 10.0, 20.0, 20.0, 30.0, 40.0]);
        let dump = folder.read("melt.dump");
        let searches =
            ["octant", "standard:0.5", "brute", "trimmed", "trimmed:2.3", "midplane", "octant+zorder", "trimmed+radix"];
        let searches = searches.map(|search| format!("--search {search}"));
        for options in ["--threads 1", "--threads 3"].into_iter().chain(searches.iter().map(String::as_str)) {
            let said = folder.says(&format!("run a.in --backend cpu {options} --precision {precision}"));
            let same_order =
                !options.contains("--search") || options.ends_with("trimmed") || options.ends_with("trimmed+radix");
            if same_order {
                assert_eq!(rows(&said), expected, "{options} {precision}");
                assert_eq!(folder.read("melt.dump"), dump, "{options} {precision}");
            }
            for (row, want) in rows(&said).iter().zip(&expected) {
                for (value, want) in row.iter().zip(want) {
                    let error = (value - want).abs();
                    assert!(error <= tolerance * want.abs().max(1.0), "{options} {precision}: {row:?}");
                }
            }
        }
    }
    // Mixed precision is what runs where none is named.
    let named = rows(&folder.says("run a.in --precision mixed"));
    assert_eq!(rows(&folder.says("run a.in")), named);
}

#[test]
fn the_report_says_what_the_log_says() {
    let folder = Folder::new("json");
    folder.write("a.in", &melt(RUN));
    let said = folder.says("run a.in --backend cpu --json report.json --log my.log --threads 2 --search octant");
    assert!(folder.has("my.log") && !folder.has("log.octant"));
    let report: Value = serde_json::from_str(&folder.read("report.json")).unwrap();
    let keys: Vec<&String> = report.as_object().unwrap().keys().collect();
    let mut expected =
        ["version", "settings", "atoms", "thermo", "neighbors", "timing", "memory", "files", "warnings", "error"];
    let mut found: Vec<&str> = keys.iter().map(|k| k.as_str()).collect();
    found.sort_unstable();
    expected.sort_unstable();
    assert_eq!(found, expected);
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(report["atoms"], 256);
    let settings = &report["settings"];
    assert_eq!((&settings["threads"], &settings["search"]), (&Value::from(2), &Value::from("octant")));
    assert_eq!((&settings["script"], &settings["precision"]), (&Value::from("a.in"), &Value::from("mixed")));
    assert!(["portable", "avx2", "avx512"].contains(&settings["isa"].as_str().unwrap()));

    // Every row of the log, in full precision.
    let log = folder.read("my.log");
    let table = rows(&log);
    let thermo = report["thermo"].as_array().unwrap();
    assert_eq!(thermo.len(), table.len());
    for (row, printed) in thermo.iter().zip(&table) {
        for (name, printed) in ["Step", "Temp", "E_pair", "E_mol", "TotEng", "Press"].iter().zip(printed) {
            let value = row[*name].as_f64().unwrap_or_else(|| panic!("no {name} in {row}"));
            assert!((value - printed).abs() <= 1e-7 * value.abs().max(1e-3), "{name}: {value} and {printed}");
        }
    }
    let number_after = |text: &str| {
        let line = log.lines().rev().find(|l| l.starts_with(text)).unwrap();
        line.rsplit(' ').next().unwrap().parse::<f64>().unwrap()
    };
    let neighbors = &report["neighbors"];
    assert_eq!(neighbors["total"].as_f64().unwrap(), number_after("Total # of neighbors"));
    assert!((neighbors["per_atom"].as_f64().unwrap() - number_after("Ave neighs/atom")).abs() < 1e-4);
    assert_eq!(neighbors["builds"].as_f64().unwrap(), number_after("Neighbor list builds"));
    assert_eq!(neighbors["dangerous"].as_f64().unwrap(), number_after("Dangerous builds"));

    let loops: f64 = log
        .lines()
        .filter_map(|l| l.strip_prefix("Loop time of "))
        .map(|l| l.split(' ').next().unwrap().parse::<f64>().unwrap())
        .sum();
    let timing = &report["timing"];
    assert!((timing["loop_s"].as_f64().unwrap() - loops).abs() <= 1e-4 * loops);
    assert!((timing["steps_per_s"].as_f64().unwrap() * loops - 40.0).abs() < 0.1);
    let stage = |name: &str| timing["stages"][name].as_f64().unwrap();
    let stages: f64 = ["pair", "neighbor", "modify", "output", "other"].map(stage).iter().sum();
    assert!((["check", "sort", "list"].map(stage).iter().sum::<f64>() - stage("neighbor")).abs() < 1e-9);
    assert!(stages <= loops * 1.01 && stages > 0.5 * loops, "stages of {stages} s, loop of {loops} s");

    let files = report["files"].as_array().unwrap();
    assert!(files.iter().any(|f| f["path"] == "melt.dump" && f["frames"] == 5), "{files:?}");
    // The screen has all of the log but the echoed script; below the log's last line it sums up.
    let (table, summary) = said.split_once("Total wall time").unwrap();
    for line in table.lines() {
        assert!(log.contains(line), "not in the log: {line}");
    }
    for part in ["Ran 40 steps of 256 atoms: ", "Wrote melt.dump: ", "Wrote my.log: log"] {
        assert!(summary.contains(part), "no '{part}' in {summary}");
    }
}

#[test]
fn quiet_runs_say_nothing_and_write_everything() {
    let folder = Folder::new("quiet");
    folder.write("a.in", &melt(RUN));
    folder.says("run a.in");
    let (log, dump) = (folder.read("log.octant"), folder.read("melt.dump"));
    assert_eq!(folder.says("run a.in --quiet"), "");
    assert_eq!(rows(&folder.read("log.octant")), rows(&log));
    assert_eq!(folder.read("melt.dump"), dump);
}

#[test]
fn explain_names_what_is_left_out() {
    let folder = Folder::new("explain");
    folder.write("a.in", &melt("run 0"));
    let plain = folder.says("run a.in --backend cpu");
    let explained = folder.says("run a.in --backend cpu --explain");
    let more: Vec<&str> = explained.lines().filter(|l| !plain.contains(l)).collect();
    assert!(more.iter().any(|l| l.contains("lj/cut")), "{more:?}");
    for said in
        ["one type: its constants stay in registers", "look-up of groups", "added as tiles are copied", "An atom: "]
    {
        assert!(more.iter().any(|l| l.contains(said)), "{said}: {more:?}");
    }
    // What a scene has is not left out.
    let free = melt("").replace("units lj\n", "units lj\nboundary f f f\n").replace("create_box 1", "create_box 2");
    let free = free.replace("mass 1 1.0", "mass 1 1.0\nmass 2 2.0").replace("pair_coeff 1 1", "pair_coeff * *");
    let free = free.replace("fix 1 all nve", "group some id 1:9\nfix 1 some nve");
    folder.write("b.in", &(free + "run 0\n"));
    let explained = folder.says("run b.in --backend cpu --explain");
    assert!(explained.contains("2 types: constants are picked within registers"), "{explained}");
    assert!(explained.contains("Periodic shifts: none in"), "{explained}");
    assert!(!explained.contains("look-up of groups") && !explained.contains("look-up of masses"), "{explained}");
}

#[test]
fn check_judges_and_writes_nothing() {
    let folder = Folder::new("check");
    folder.write("a.in", &melt(RUN));
    assert_eq!(folder.says("check a.in"), "a.in: fine: 14 commands, 2 runs, 256 atoms\n");
    assert_eq!(folder.files().len(), 1);
    folder.write("b.in", &melt("run 10\nrun ten"));
    let said = folder.fails(1, "check b.in");
    assert!(said.starts_with("ERROR: b.in:12:5: run: expected a number of steps"), "{said}");
    folder.write("c.in", "variable n index 3\nprint \"$n\"\nlog ${name}\n");
    folder.says("check c.in -v name=log.c -v n=7");
    assert_eq!(folder.files().len(), 3);
}

#[test]
fn variables_of_the_command_line_win() {
    let folder = Folder::new("variables");
    folder.write("a.in", "variable n index 3\nvariable m index 4\nprint \"n is $n, m is $m\"\n");
    assert!(folder.says("run a.in -v n=7").contains("n is 7, m is 4\n"));
    assert!(folder.says("run a.in").contains("n is 3, m is 4\n"));
}

#[test]
fn neighbors_are_counted_atom_by_atom() {
    let folder = Folder::new("neighbors");
    folder.write("a.in", &melt("run 10"));
    for search in ["trimmed", "octant", "standard", "brute", "octant:2.52", "midplane", "midplane:4", "standard:0.5"] {
        let said = folder.says(&format!("neighbors a.in --search {search} --cutoff 1.2 --counts counts"));
        // The twelve nearest neighbors of the fcc lattice.
        assert!(said.contains("pairs         1536\n"), "{said}");
        let counts = folder.read("counts");
        let lines: Vec<&str> = counts.lines().collect();
        assert_eq!((lines[0], lines[1], lines[256], lines.len()), ("# id neighbors", "1 12", "256 12", 257));
    }
    // Without --cutoff: cutoff and skin, the list that LAMMPS reports as 39 neighbors an atom (half of them).
    let said = folder.says("neighbors a.in");
    assert!(said.contains("cutoff        2.8\n") && said.contains("mean 78.000000"), "{said}");
    // The engine that builds the list is of no account: a GPU's where there is one.
    assert_eq!(folder.says("neighbors a.in --backend auto"), said);
    assert!(!folder.has("log.octant"));
    assert!(folder.fails(1, "neighbors a.in --counts no/x").starts_with("ERROR: no/x: cannot write"));
    assert!(folder.fails(1, "neighbors a.in --cutoff 1e300").contains("does not fit in memory"));
}

#[test]
fn info_lists_what_there_is() {
    let said = Folder::new("info").says("info");
    for word in [env!("CARGO_PKG_VERSION"), "cpu", "trimmed, octant, midplane, standard, brute", "lj/cut", "nve"] {
        assert!(said.contains(word), "{word} is missing in\n{said}");
    }
    assert_eq!(said.contains("NetCDF"), cfg!(feature = "chemfiles"));
}

/// A report may go to a pipe or a device, which stay what they are, and a full disk is told.
#[cfg(target_os = "linux")]
#[test]
fn reports_go_to_devices_too() {
    let folder = Folder::new("device");
    folder.write("a.in", &melt("run 0"));
    // Through a link, so that no mistake of ours can replace the device itself.
    std::os::unix::fs::symlink("/dev/full", folder.0.join("full")).unwrap();
    for args in ["run a.in --json full", "run a.in --log full"] {
        assert_eq!(
            folder.fails(1, args),
            "ERROR: full: cannot write: No space left on device (os error 28)\n",
            "{args}"
        );
    }
    folder.write("b.in", &melt("write_data full"));
    assert!(folder.fails(1, "run b.in").contains("cannot write 'full': No space left on device"));
    folder.write("c.in", &melt("dump d all atom 1 full\nrun 50"));
    assert!(folder.fails(1, "run c.in").contains("full: cannot write: No space left on device"));
    assert!(std::fs::symlink_metadata(folder.0.join("full")).unwrap().is_symlink());
    let said = folder.says("run a.in --quiet --json /dev/stdout");
    assert!(serde_json::from_str::<Value>(&said).is_ok(), "{said}");
}

/// Neither escape sequences nor carriage returns reach a pipe, on either stream.
#[test]
fn a_pipe_gets_no_progress_bar() {
    let folder = Folder::new("pipe");
    folder.write("a.in", &melt("thermo 100\nrun 400"));
    let done = folder.octant("run a.in").output().unwrap();
    assert!(done.status.success());
    assert!(!done.stdout.contains(&0x1b) && !done.stdout.contains(&b'\r'));
    assert_eq!(done.stderr, b"");
}

/// `octant run x | head -1`: the reader leaves, the run goes on for its files.
#[test]
fn a_reader_that_leaves_does_not_end_the_run() {
    let folder = Folder::new("head");
    folder.write("a.in", &melt("thermo 1\ndump d all atom 200 melt.dump\nrun 400"));
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("octant"))
        .current_dir(&folder.0)
        .args(["run", "a.in"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = [0];
    let mut stdout = child.stdout.take().unwrap();
    stdout.read_exact(&mut first).unwrap();
    drop(stdout);
    let done = child.wait_with_output().unwrap();
    assert_eq!((done.status.code(), done.stderr.as_slice()), (Some(0), &b""[..]));
    assert_eq!(rows(&folder.read("log.octant")).len(), 401);
    assert!(folder.read("log.octant").contains("Total wall time"));
    assert_eq!(folder.read("melt.dump").matches("ITEM: TIMESTEP").count(), 3);
}

/// The other commands print to a closed standard output, too.
#[test]
fn no_command_panics_on_a_closed_output() {
    let folder = Folder::new("closed");
    folder.write("a.in", &melt("run 0"));
    for args in [&["info"][..], &["check", "a.in"], &["neighbors", "a.in"], &["run", "a.in"]] {
        let mut child = Command::new(assert_cmd::cargo::cargo_bin("octant"))
            .current_dir(&folder.0)
            .args(args)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let done = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(!said.contains("panicked"), "{args:?}: {said}");
        assert_eq!(done.status.code(), Some(0), "{args:?}: {said}");
    }
}

/// Files are written once, in the order of the script, whether a run comes after them, before them or not at all.
#[test]
fn print_writes_its_files_wherever_it_stands() {
    let folder = Folder::new("print");
    let write = "print 'one' file said.txt\nprint 'two' append said.txt screen no\n";
    let after = "print 'three' append said.txt\n";
    for run in ["", "run 2\n"] {
        folder.write("a.in", &melt(&format!("{write}{run}{after}")));
        let said = folder.says("run a.in");
        assert_eq!(folder.read("said.txt"), "one\ntwo\nthree\n");
        for (word, times) in [("one", 1), ("two", 0), ("three", 1)] {
            assert_eq!(said.lines().filter(|line| *line == word).count(), times, "{word}");
        }
    }
    folder.write("b.in", &melt("print 'one' file never.txt\nrun ten"));
    folder.fails(1, "run b.in");
    assert!(!folder.has("never.txt"));
}
