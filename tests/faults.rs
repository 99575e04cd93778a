//! Dynamics that go wrong: the message, the last good state, the files so far.

#[path = "common/cli.rs"]
mod common;

use common::Folder;

/// Atoms by hand in a box of edge 10; `{}` is what differs.
fn scene(boundary: &str, atoms: &[[f64; 3]], more: &str) -> String {
    let mut text = format!("units lj\nboundary {boundary}\nregion b block 0 10 0 10 0 10 units box\ncreate_box 1 b\n");
    for [x, y, z] in atoms {
        text += &format!("create_atoms 1 single {x} {y} {z}\n");
    }
    text + "mass 1 1\npair_style lj/cut 2.5\npair_coeff 1 1 1 1\nfix 1 all nve\nthermo 10\n" + more
}

fn first_line(said: &str) -> &str {
    said.lines().next().unwrap()
}

const DUMP: &str = "dump d all custom 10 out.dump id x y z vx vy vz\n";

#[test]
fn coincident_atoms_have_no_force() {
    let folder = Folder::new("coincident");
    let atoms = [[2.0, 3.0, 4.0], [5.0, 6.0, 7.0], [5.0, 6.0, 7.0]];
    folder.write("a.in", &scene("p p p", &atoms, &format!("{DUMP}run 100\n")));
    let said = folder.fails(1, "run a.in");
    assert_eq!(
        first_line(&said),
        "ERROR: step 0: non-finite force on atom 2 at (5, 6, 7); nearest is atom 3 at distance 0; 2 atoms are at fault"
    );
    assert!(!folder.has("out.dump"), "a dump of nothing");
    assert!(folder.read("log.octant").contains(&said.trim_end().lines().next().unwrap()["ERROR: ".len()..]));
}

#[test]
fn atoms_that_are_too_close_are_thrown_out() {
    let folder = Folder::new("close");
    let atoms = [[2.0, 3.0, 4.0], [5.0, 6.0, 7.0], [5.0, 6.0, 7.0078125]];
    folder.write("a.in", &scene("p p p", &atoms, &format!("{DUMP}run 100\n")));
    let said = folder.fails(1, "run a.in");
    assert!(first_line(&said).starts_with("ERROR: step 1: lost atom 2 at (5, 6, -"), "{said}");
    assert!(
        said.contains(
            "; at step 0 it was at (5, 6, 7); nearest was atom 3 at distance 0.0078125; 2 atoms are at fault"
        ),
        "{said}"
    );
    assert!(said.contains("\n  the state of step 0 is in last-good.data (read_data takes it)"), "{said}");
    let dump = folder.read("out.dump");
    assert_eq!((dump.lines().count(), dump.matches("TIMESTEP").count()), (12, 1));
}

#[test]
fn a_velocity_that_overflows_is_no_position() {
    let folder = Folder::new("overflow");
    let atoms = [[2.0, 3.0, 4.0], [5.0, 6.0, 7.0]];
    folder.write("a.in", &scene("p p p", &atoms, "velocity all set 1e150 0 0\ntimestep 1e300\nrun 5\n"));
    let said = folder.fails(1, "run a.in");
    assert_eq!(
        first_line(&said),
        "ERROR: step 1: non-finite position or velocity of atom 1 at (inf, 3, 4); at step 0 it was at (2, 3, 4); \
         nearest was atom 2 at distance 5.196152422706632; 2 atoms are at fault"
    );
}

/// Lost through a free side after a while; the run goes on from the last good state.
#[test]
fn the_last_good_state_is_taken_by_read_data() {
    let folder = Folder::new("lost");
    std::fs::create_dir(folder.0.join("logs")).unwrap();
    let atoms = [[5.0, 5.0, 5.0], [9.0, 5.5, 5.0], [3.0, 4.0, 9.5]];
    let start = scene("f p p", &atoms, &format!("velocity all set 1 0.5 0.25\n{DUMP}run 1000\n"));
    folder.write("a.in", &start);
    let said = folder.fails(1, "run a.in --log logs/log.a");
    let line = first_line(&said);
    assert!(line.starts_with("ERROR: step ") && line.contains(": lost atom 2 at (10."), "{line}");
    assert!(line.contains("; nearest is atom 1 at distance 4.03112887414"), "{line}");
    let good: i64 = said.split("the state of step ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!(said.contains(&format!("{} (read_data takes it)", "logs/last-good.data")), "{said}");
    assert!(!folder.has("last-good.data"));

    // What was written so far is whole.
    let stop: i64 = line["ERROR: step ".len()..].split(':').next().unwrap().parse().unwrap();
    let frames = folder.read("out.dump").matches("ITEM: TIMESTEP").count();
    assert_eq!(frames as i64, (stop - 1) / 10 + 1);
    assert_eq!(folder.read("out.dump").lines().count(), frames * 12);
    assert!(folder.read("logs/log.a").contains(&line["ERROR: ".len()..]));

    // One run from the beginning to a step after the last good state, and one from that state: the same positions.
    let middle = good + 3;
    assert!(middle < stop);
    let ahead = start.replace("run 1000", &format!("run {good}\nrun {}", middle - good));
    let fine = "dump e all custom 1 NAME id x y z vx vy vz\ndump_modify e sort id format float %.15g\n";
    folder.write("b.in", &ahead.replace(DUMP, &fine.replace("NAME", "b.dump")));
    folder.says("run b.in");
    let again = format!(
        "units lj\nboundary f p p\npair_style lj/cut 2.5\nread_data logs/last-good.data\nfix 1 all nve\n\
         reset_timestep {good}\n{}run 3\n",
        fine.replace("NAME", "c.dump")
    );
    folder.write("c.in", &again);
    folder.says("run c.in");
    let (from_start, from_good) = (folder.read("b.dump"), folder.read("c.dump"));
    let last = |text: &str| -> Vec<Vec<f64>> {
        let frame = text.rsplit("ITEM: ATOMS").next().unwrap();
        let rows = frame.lines().skip(1);
        rows.map(|l| l.split_whitespace().map(|w| w.parse().unwrap()).collect()).collect()
    };
    for (a, b) in last(&from_start).iter().flatten().zip(last(&from_good).iter().flatten()) {
        assert!((a - b).abs() < 1e-12, "{a} and {b}");
    }
}

/// A formula of the thermo table that fails only at some step ends the run with its words.
#[test]
fn a_formula_may_fail_on_the_way() {
    let folder = Folder::new("formula");
    let more = format!("variable v equal 1/(20-step)\nthermo_style custom step v_v\n{DUMP}run 50\n");
    folder.write("a.in", &scene("p p p", &[[2.0, 3.0, 4.0], [5.0, 6.0, 7.0]], &more));
    let said = folder.fails(1, "run a.in");
    assert!(first_line(&said).contains("division by zero"), "{said}");
    let log = folder.read("log.octant");
    assert!(log.contains("division by zero"), "{log}");
    assert_eq!(folder.read("out.dump").matches("ITEM: TIMESTEP").count(), 2);
}

/// `count` atoms in a box of edge 10, at random in a sphere of some radius around its middle.
fn crowd(count: u32, radius: f64) -> String {
    format!(
        "units lj\nboundary f f f\nregion box block 0 10 0 10 0 10\ncreate_box 1 box\nregion spot sphere 5 5 5 {radius}\n\
         create_atoms 1 random {count} 4711 spot\nmass 1 1.0\npair_style harmonic/cut\npair_coeff 1 1 1.0 2.5\n\
         neighbor 0.0 bin\nfix 1 all nve\nrun 10\n"
    )
}

#[test]
fn a_crowd_in_one_cell_is_counted_and_moved() {
    let folder = Folder::new("crowd");
    folder.write("a.in", &crowd(900, 1.0));
    for search in ["trimmed", "octant:4", "midplane:2.52", "standard:0.5", "standard:4", "brute"] {
        let said = folder.says(&format!("neighbors a.in --search {search}"));
        assert!(said.contains("neighbors     mean 899.000000, least 899, most 899\n"), "{search}: {said}");
        assert!(folder.says(&format!("run a.in --search {search}")).contains("Loop time of"));
    }
}

#[test]
fn atoms_in_one_point_are_counted_and_not_moved() {
    let folder = Folder::new("point");
    // Ids from 1: the middle of a box of one lattice point, over and over.
    let create = "create_atoms 1 single 5 5 5\n".repeat(40);
    let script = crowd(40, 1.0);
    let (before, after) = script.split_once("create_atoms 1 random 40 4711 spot\n").unwrap();
    folder.write("a.in", &format!("{before}{create}{after}"));
    for search in ["trimmed", "octant", "midplane", "standard:0.5", "brute"] {
        let said = folder.says(&format!("neighbors a.in --search {search}"));
        assert!(said.contains("neighbors     mean 39.000000, least 39, most 39\n"), "{search}: {said}");
        let said = folder.fails(1, &format!("run a.in --search {search}"));
        let expected =
            "step 0: non-finite force on atom 1 at (5, 5, 5); nearest is atom 2 at distance 0; 40 atoms are at fault";
        assert!(said.contains(expected), "{search}: {said}");
    }
}

#[test]
fn a_crowd_whose_list_no_memory_holds_is_refused_at_once() {
    let folder = Folder::new("refused");
    folder.write("a.in", &crowd(3_000_000, 1e-3));
    for command in ["run", "neighbors"] {
        let said = folder.fails(1, &format!("{command} a.in"));
        assert!(said.contains("does not fit in memory"), "{said}");
    }
}

#[test]
fn a_cutoff_beyond_the_box_reaches_all_and_no_atoms_are_an_error() {
    let folder = Folder::new("beyond");
    folder.write("a.in", &crowd(50, 4.9).replace("1.0 2.5", "1.0 40.0"));
    for search in ["trimmed", "octant", "octant:4", "midplane", "standard:0.5", "brute"] {
        let said = folder.says(&format!("neighbors a.in --search {search}"));
        assert!(said.contains("neighbors     mean 49.000000, least 49, most 49\n"), "{search}: {said}");
    }
    folder.write("b.in", &crowd(50, 1.0).replace("create_atoms 1 random 50 4711 spot\n", ""));
    for command in ["run", "neighbors"] {
        assert!(folder.fails(1, &format!("{command} b.in")).contains("there are no atoms"));
    }
}
