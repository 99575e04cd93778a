//! The expected texts are those of LAMMPS 22Jul2025 for the same three atoms.

use std::path::PathBuf;

use super::*;
use crate::engine::Sums;
use crate::script::testing::statement;
use crate::system::{Side, SimulationBox, State, Units};

/// Three atoms in LAMMPS's storage order, group 1 being those of type 2; one side of each kind.
pub(in crate::output) fn sample() -> (State, SimulationBox) {
    let mut state = State::default();
    state.push(1, 2, Vec3::new(0.5, -0.25, 1.125));
    state.push(3, 2, Vec3::new(1.0625, 0.125, 2.0));
    state.push(2, 1, Vec3::new(3.75, 2.5, 6.0625));
    state.v[0] = Vec3::new(0.125, -3.5, 1e-7);
    state.v[1] = Vec3::new(12345678.0, 0.0, -0.333333333333);
    let f = Vec3::new(-0.5693789357327963, -0.3795859571551975, -0.8857005666954608);
    (state.f[0], state.f[1]) = (f, -f);
    (state.image[0], state.image[1]) = ([2, 0, 0], [-1, 0, 0]);
    (state.mask[0], state.mask[1]) = (0b11, 0b11);
    let simulation_box = SimulationBox {
        lo: Vec3::new(-1.0, -2.0, 0.0),
        hi: Vec3::new(4.0, 3.0, 6.0632),
        sides: [[Side::Periodic; 2], [Side::Fixed; 2], [Side::Fixed, Side::Shrink]],
        margin: Vec3::zeros(),
    };
    (state, simulation_box)
}

/// Shows a dump the sample at a step.
pub(in crate::output) fn show(dump: &mut dyn DumpObserver, step: i64) -> Result<(), Error> {
    show_with(dump, step, sample().0)
}

/// Shows a dump these atoms in the sample's box.
pub(in crate::output) fn show_with(dump: &mut dyn DumpObserver, step: i64, state: State) -> Result<(), Error> {
    let ((_, simulation_box), sums) = (sample(), Sums::default());
    let snapshot = Snapshot {
        step,
        first_step: 0,
        last_step: 1000,
        timestep: 0.5,
        state: &state,
        simulation_box: &simulation_box,
        sums: &sums,
        neighbors: Default::default(),
        elapsed_seconds: 0.0,
    };
    dump.observe(&snapshot, &mut Console::discard())
}

/// A dump of the sample in metal units from `dump ID GROUP ...` and `dump_modify` lines; FILE becomes a path of its own.
pub(in crate::output) fn dump(name: &str, lines: &[&str]) -> (Box<dyn DumpObserver>, PathBuf) {
    let path = std::env::temp_dir().join(format!("octant-dump-{}-{name}", std::process::id()));
    let command =
        DumpCommand::parse(&mut statement(&lines[0].replace("FILE", &path.to_string_lossy())).args()).unwrap();
    let facts = Arc::new(SceneFacts::new(Units::named("metal").unwrap(), vec![26.98, 12.5]));
    let mask = if command.group.text == "all" { 1 } else { 2 };
    let mut dump = open_dump(&command, mask, facts).unwrap();
    for line in &lines[1..] {
        dump.modify(&DumpModifyCommand::parse(&mut statement(line).args()).unwrap()).unwrap();
    }
    (dump, path)
}

fn written(name: &str, lines: &[&str]) -> String {
    let (mut dump, path) = dump(name, lines);
    show(&mut *dump, 40).unwrap();
    dump.close().unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!((dump.report().bytes, dump.report().frames), (text.len() as u64, 1));
    std::fs::remove_file(path).unwrap();
    text
}

const BOX: &str = "\
ITEM: BOX BOUNDS pp ff fs
-1.0000000000000000e+00 4.0000000000000000e+00
-2.0000000000000000e+00 3.0000000000000000e+00
0.0000000000000000e+00 6.0632000000000001e+00
";

#[test]
fn atom() {
    let plain = written("atom", &["dump a all atom 20 FILE"]);
    let table = "\
ITEM: ATOMS id type xs ys zs
1 2 0.3 0.35 0.185546
3 2 0.4125 0.425 0.329859
2 1 0.95 0.9 0.999885
";
    assert_eq!(plain, format!("ITEM: TIMESTEP\n40\nITEM: NUMBER OF ATOMS\n3\n{BOX}{table}"));
    let settings = "dump_modify b scale no image yes units yes time yes sort id";
    let table = "\
ITEM: ATOMS id type x y z ix iy iz
1 2 0.5 -0.25 1.125 2 0 0
2 1 3.75 2.5 6.0625 0 0 0
3 2 1.0625 0.125 2 -1 0 0
";
    let head = "ITEM: UNITS\nmetal\nITEM: TIME\n20\nITEM: TIMESTEP\n40\nITEM: NUMBER OF ATOMS\n3\n";
    assert_eq!(written("image", &["dump b all atom 20 FILE", settings]), format!("{head}{BOX}{table}"));
}

#[test]
fn custom() {
    let command = "dump c g custom 20 FILE id type element mass xu zsu vx vy vz ix fy proc procp1 xs y";
    let sorted = written("custom", &[command, "dump_modify c sort -1 element Al C colname 2 kind"]);
    let table = "\
ITEM: ATOMS id kind element mass xu zsu vx vy vz ix fy proc procp1 xs y
3 2 C 12.5 -3.9375 0.329859 1.23457e+07 0 -0.333333 -1 0.379586 0 1 0.4125 0.125
1 2 C 12.5 10.5 0.185546 0.125 -3.5 1e-07 2 -0.379586 0 1 0.3 -0.25
";
    assert_eq!(sorted, format!("ITEM: TIMESTEP\n40\nITEM: NUMBER OF ATOMS\n2\n{BOX}{table}"));
    let formats = "dump_modify d format float %10.3e format int %04d format 2 '<%.2f>' sort 2";
    let table = "ITEM: ATOMS id x vy ix\n0001 <0.50> -3.500e+00 0002\n0003 <1.06>  0.000e+00 -001\n";
    assert!(written("formats", &["dump d g custom 20 FILE id x vy ix", formats]).ends_with(table));
}

#[test]
fn xyz() {
    let named = written("xyz", &["dump e all xyz 20 FILE", "dump_modify e element Al C time yes"]);
    let expected = "3\n Atoms. Timestep: 40 Time: 20.000000\nC 0.5 -0.25 1.125\nAl 3.75 2.5 6.0625\nC 1.0625 0.125 2\n";
    assert_eq!(named, expected);
    let sorted = written("xyz4", &["dump f all xyz 20 FILE", "dump_modify f sort 4"]);
    assert_eq!(sorted, "3\n Atoms. Timestep: 40\n2 0.5 -0.25 1.125\n2 1.0625 0.125 2\n1 3.75 2.5 6.0625\n");
}

/// Steps at which runs (first, last) of LAMMPS write.
fn steps(name: &str, lines: &[&str], runs: &[(i64, i64)]) -> Vec<i64> {
    let (mut dump, path) = dump(name, lines);
    let mut steps = Vec::new();
    for (first, last) in runs {
        dump.begin_run(*first).unwrap();
        let mut after = first - 1;
        while let Some(step) = dump.next(after, *last) {
            show(&mut *dump, step).unwrap();
            steps.push(step);
            after = step;
        }
    }
    drop(dump);
    let _ = std::fs::remove_file(path);
    steps
}

#[test]
fn snapshots_are_at_multiples_and_never_twice() {
    let runs = [(0, 100), (100, 200), (200, 250)];
    let of = |name: &str, lines: &[&str], runs: &[(i64, i64)]| steps(name, lines, runs);
    assert_eq!(of("s1", &["dump a all atom 40 FILE"], &runs), [0, 40, 80, 120, 160, 200, 240]);
    assert_eq!(of("s2", &["dump a all atom 40 FILE"], &runs[1..]), [120, 160, 200, 240]);
    let first = ["dump d all xyz 40 FILE", "dump_modify d first yes"];
    assert_eq!(of("s3", &first, &runs[1..]), [100, 120, 160, 200, 240]);
    assert_eq!(of("s4", &["dump a all atom 100 FILE"], &runs), [0, 100, 200]);
    assert_eq!(of("s5", &["dump a all atom 10 FILE", "dump_modify a every 90 delay 95"], &runs), [180]);
    let both = ["dump a all atom 7 FILE", "dump_modify a first yes delay 20"];
    assert_eq!(of("s7", &both, &[(15, 35)]), [21, 28, 35]);
    assert!(of("s6", &["dump a all atom 9223372036854775807 FILE"], &[(5, 9)]).is_empty());
}

#[test]
fn several_files_padded_and_the_oldest_removed() {
    let lines = ["dump i all atom 5 FILE.*.txt", "dump_modify i pad 5 maxfiles 2"];
    let (mut dump, path) = dump("many", &lines);
    for step in [5, 10, 15] {
        show(&mut *dump, step).unwrap();
    }
    let file = |step: &str| PathBuf::from(format!("{}.{step}.txt", path.display()));
    assert!(!file("00005").exists());
    for step in ["00010", "00015"] {
        assert!(std::fs::read_to_string(file(step)).unwrap().starts_with("ITEM: TIMESTEP\n1"));
        std::fs::remove_file(file(step)).unwrap();
    }
}

#[test]
fn append_keeps_what_was_there_and_nothing_is_touched_before_the_first_snapshot() {
    let (fresh, path) = dump("append", &["dump a all xyz 1 FILE"]);
    assert!(!path.exists());
    drop(fresh);
    assert!(!path.exists());
    std::fs::write(&path, "old\n").unwrap();
    let (mut appending, _) = dump("append", &["dump a g xyz 1 FILE", "dump_modify a append yes"]);
    show(&mut *appending, 1).unwrap();
    appending.close().unwrap();
    show(&mut *appending, 2).unwrap();
    drop(appending);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("old\n2\n Atoms. Timestep: 1\n2 0.5") && text.contains("Timestep: 2"), "{text}");
    std::fs::remove_file(path).unwrap();
}

#[test]
fn wrapped_into_the_box_on_request() {
    let (mut state, simulation_box) = sample();
    state.x[0].x = 4.5;
    let (facts, sums) = (SceneFacts::new(Units::named("lj").unwrap(), vec![1.0; 2]), Sums::default());
    let snapshot = Snapshot {
        step: 0,
        first_step: 0,
        last_step: 0,
        timestep: 1.0,
        state: &state,
        simulation_box: &simulation_box,
        sums: &sums,
        neighbors: Default::default(),
        elapsed_seconds: 0.0,
    };
    let frame =
        |wraps| Frame { snapshot: &snapshot, facts: &facts, atoms: vec![], inverse: Vec3::zeros(), wraps, every: 1 };
    assert_eq!(frame(true).place(0), (Vec3::new(-0.5, -0.25, 1.125), [3, 0, 0]));
    assert_eq!(frame(false).place(0), (Vec3::new(4.5, -0.25, 1.125), [2, 0, 0]));
    assert_eq!(frame(true).unwrapped(0), frame(false).unwrapped(0));
}

#[test]
fn what_cannot_be_is_refused_at_its_word() {
    for (line, word, part) in [
        ("dump a all atom 0 f", 4, "at least 1"),
        ("dump a all atom 10 f id", 6, "end of the line"),
        ("dump a all custom 10 f", 5, "a column"),
        ("dump a all custom 10 f id c_1", 7, "computes"),
        ("dump a all custom 10 f id mol", 7, "atom_style atomic"),
        ("dump a all custom 10 f id what", 7, "unknown column 'what'"),
        ("dump a all local 10 f", 3, "not part of octant"),
        ("dump a all wrong 10 f", 3, "unknown dump style"),
        ("dump a all atom 10 f.gz", 5, "compressed"),
        ("dump a all atom 10 f.%", 5, "one file a process"),
        ("dump a all dcd 10 f.*", 5, "one file"),
    ] {
        let error = DumpCommand::parse(&mut statement(line).args()).unwrap_err();
        assert_eq!((error.word, error.message.contains(part)), (word, true), "{line}: {error:?}");
    }
    for (line, word) in [
        ("dump_modify a", 1),
        ("dump_modify a thresh x > 4", 2),
        ("dump_modify a what", 2),
        ("dump_modify a every v_x", 3),
        ("dump_modify a sort 0", 3),
        ("dump_modify a sort xs", 3),
        ("dump_modify a format float %q", 4),
    ] {
        assert_eq!(DumpModifyCommand::parse(&mut statement(line).args()).unwrap_err().word, word, "{line}");
    }
    let (mut dump, _) = dump("refused", &["dump a all custom 10 FILE id x element"]);
    for (line, word) in [
        ("dump_modify a first yes scale no", 4),
        ("dump_modify a element Al", 2),
        ("dump_modify a precision 100", 2),
        ("dump_modify a sort 4", 2),
        ("dump_modify a format 4 %g", 3),
        ("dump_modify a format line '%d %g'", 2),
        ("dump_modify a format 3 %g", 2),
    ] {
        let command = DumpModifyCommand::parse(&mut statement(line).args()).unwrap();
        assert_eq!(dump.modify(&command).unwrap_err().word, word, "{line}");
    }
}

#[test]
fn elements_end_at_the_next_keyword() {
    let command = DumpModifyCommand::parse(&mut statement("dump_modify a element Al C sort id").args()).unwrap();
    let changes: Vec<DumpChange> = command.settings.into_iter().map(|setting| setting.change).collect();
    assert_eq!(changes, [DumpChange::Element(vec!["Al".into(), "C".into()]), DumpChange::Sort(SortBy::Id)]);
}

#[test]
fn equal_elements_come_in_the_order_lammps_leaves_them() {
    // 150 equal elements: runs 0..64, 64..128, 128..150; of two runs that are merged the later comes first.
    let mut all: Vec<usize> = (0..150).collect();
    super::merge_sort(&mut all, |_, _| false);
    let expected: Vec<usize> = (128..150).chain(64..128).chain(0..64).collect();
    assert_eq!(all, expected);
    let mut mixed: Vec<(u32, usize)> = (0..200).map(|k| ((7 * k % 5) as u32, k)).collect();
    super::merge_sort(&mut mixed, |a, b| a.0 < b.0);
    assert!(mixed.is_sorted_by_key(|pair| pair.0));
}
