//! The expected texts are those of LAMMPS 22Jul2025.

use super::*;
use crate::output::SceneFacts;
use crate::output::quantities::tests::{sample, snapshot};
use crate::script::command::thermo::ThermoCommand;
use crate::script::testing::statement;

fn table(lines: &[&str]) -> ThermoTable {
    let style = ThermoStyleCommand::parse(&mut statement(lines[0]).args()).unwrap();
    let mut table = ThermoTable::new(&style, Units::named("lj").unwrap());
    for line in &lines[1..] {
        table.modify(&ThermoModifyCommand::parse(&mut statement(line).args()).unwrap()).unwrap();
    }
    table
}

fn row(step: i64, cpu: f64, values: &[f64]) -> ThermoRow {
    ThermoRow { step, cpu, values: values.iter().map(|x| Number::Float(*x)).collect() }
}

#[test]
fn style_one() {
    let table = table(&["thermo_style one"]);
    let mut row = row(50, 0.0, &[0.0, 0.75416748, -5.7556332, 0.0, -4.6288009, 0.2557531]);
    row.values[0] = Number::Integer(50);
    assert_eq!(
        table.header(),
        ["   Step          Temp          E_pair         E_mol          TotEng         Press     "]
    );
    let expected = "        50   0.75416748    -5.7556332      0             -4.6288009      0.2557531    ";
    assert_eq!(table.text(&row).unwrap(), expected);
    assert!(table.footer().is_empty());
}

#[test]
fn a_changing_box_adds_the_volume() {
    let mut table = table(&["thermo_style one"]);
    table.start_run(true);
    table.start_run(true);
    assert!(table.header()[0].ends_with("TotEng         Press          Volume    "), "{:?}", table.header());
    table.start_run(false);
    assert!(table.header()[0].ends_with("  Press     "));
}

#[test]
fn style_multi() {
    let mut table = table(&["thermo_style multi"]);
    table.start_run(true);
    let values = [-4.62979, 1.18290, 0.79167, -5.81266, 0.0, 0.0, 0.0, 0.0, -5.81266, 0.0, 0.0, -0.12992, 56.869936];
    let expected = "\
------------ Step            150 ----- CPU =  0.008527918 (sec) -------------
TotEng   =        -4.6298 KinEng   =         1.1829 Temp     =         0.7917 
PotEng   =        -5.8127 E_bond   =         0.0000 E_angle  =         0.0000 
E_dihed  =         0.0000 E_impro  =         0.0000 E_vdwl   =        -5.8127 
E_coul   =         0.0000 E_long   =         0.0000 Press    =        -0.1299 
Volume   =        56.8699";
    assert_eq!(table.text(&row(150, 0.008527918, &values)).unwrap(), expected);
    assert!(table.header().is_empty());
}

#[test]
fn style_yaml() {
    let table = table(&["thermo_style yaml"]);
    let head = [
        "---",
        "keywords: ['Step', 'Temp', 'KinEng', 'PotEng', 'E_bond', 'E_angle', 'E_dihed', 'E_impro', 'E_vdwl', 'E_coul', 'E_long', 'Press', ]",
        "data:",
    ];
    assert_eq!(table.header(), head);
    let mut row = row(200, 0.0, &[0.0, 0.760849321207528, 1.0]);
    row.values[0] = Number::Integer(200);
    assert_eq!(table.text(&row).unwrap(), "  - [200, 0.760849321207528, 1, ]");
    assert_eq!(table.footer(), ["..."]);
}

#[test]
fn formats_and_names() {
    let style = "thermo_style custom step temp v_q nbuild";
    let values = ThermoRow {
        step: 50,
        cpu: 0.0,
        values: vec![Number::Integer(50), Number::Float(0.800603), Number::Float(125.0), Number::Integer(3)],
    };
    let line = table(&[style, "thermo_modify format line '%ld %g %12.3f %d'"]);
    assert_eq!(line.header(), ["   Step          Temp           v_q         Nbuild   "]);
    assert_eq!(line.text(&values).unwrap(), "50 0.800603      125.000 3");
    let mixed = table(&[
        style,
        "thermo_modify format line '%d %g %g %d' format none",
        "thermo_modify format float %20.10e format 2 %8.2f format int %6d colname 2 Tee colname v_q Queue",
    ]);
    assert_eq!(mixed.header(), ["   Step          Tee           Queue        Nbuild   "]);
    assert_eq!(mixed.text(&values).unwrap(), "    50     0.80     1.2500000000e+02      3");
    let json = mixed.json(&values);
    assert_eq!(serde_json::to_string(&json).unwrap(), r#"{"Step":50,"Tee":0.800603,"Queue":125.0,"Nbuild":3}"#);
}

#[test]
fn wrong_formats_are_refused() {
    let mut table = table(&["thermo_style custom step temp"]);
    for (line, word) in [
        ("thermo_modify norm no format line '%d'", 4),
        ("thermo_modify format line '%d %d'", 2),
        ("thermo_modify format float %d", 2),
        ("thermo_modify format int %g", 3),
        ("thermo_modify format 3 %g", 2),
        ("thermo_modify format press %g", 2),
        ("thermo_modify colname 0 T", 2),
    ] {
        let command = ThermoModifyCommand::parse(&mut statement(line).args()).unwrap();
        assert_eq!(table.modify(&command).unwrap_err().word, word, "{line}");
    }
    assert!(table.norm());
}

#[test]
fn commands_that_cannot_be_are_refused_at_their_word() {
    for (line, word, part) in [
        ("thermo_style custom step foo", 3, "unknown thermo keyword 'foo'"),
        ("thermo_style custom c_pe", 2, "computes"),
        ("thermo_style custom", 1, "end of the line"),
        ("thermo_style two", 1, "one, multi, yaml, custom"),
        ("thermo_style one two", 2, "end of the line"),
    ] {
        let error = ThermoStyleCommand::parse(&mut statement(line).args()).unwrap_err();
        assert_eq!((error.word, error.message.contains(part)), (word, true), "{line}: {error:?}");
    }
    for (line, word) in [("thermo_modify", 0), ("thermo_modify temp mine", 1), ("thermo_modify norm maybe", 2)] {
        assert_eq!(ThermoModifyCommand::parse(&mut statement(line).args()).unwrap_err().word, word, "{line}");
    }
    for line in ["thermo -5", "thermo v_x", "thermo 10 20", "thermo 1.5"] {
        assert!(ThermoCommand::parse(&mut statement(line).args()).is_err(), "{line}");
    }
}

#[test]
fn rates_are_since_the_row_before() {
    let (state, simulation_box, sums) = sample();
    let facts = SceneFacts::new(Units::named("metal").unwrap(), vec![1.0, 2.0]);
    let mut table = table(&["thermo_style custom spcpu tpcpu v_x"]);
    let mut at = |step, seconds| {
        let mut snapshot = snapshot(&state, &simulation_box, &sums);
        (snapshot.step, snapshot.elapsed_seconds) = (step, seconds);
        let quantities = Quantities::new(&snapshot, &facts, false);
        table.row(&quantities, &mut |name| Ok(name.len() as f64)).unwrap().values.iter().map(|x| x.value()).collect()
    };
    let rows: [Vec<f64>; 3] = [at(5, 0.0), at(25, 2.0), at(65, 3.0)];
    assert_eq!(rows[0], [0.0, 0.0, 1.0]);
    assert_eq!(rows[1], [10.0, 0.02, 1.0]);
    assert_eq!(rows[2][0], 40.0);
}

#[test]
fn rows_are_at_both_ends_and_at_multiples() {
    let steps = |every, first, last| {
        let schedule = ThermoSchedule { every, first };
        let mut after = first - 1;
        std::iter::from_fn(move || schedule.next(after, last).inspect(|step| after = *step)).collect::<Vec<_>>()
    };
    assert_eq!(steps(50, 0, 100), [0, 50, 100]);
    assert_eq!(steps(50, 30, 110), [30, 50, 100, 110]);
    assert_eq!(steps(0, 7, 27), [7, 27]);
    assert_eq!(steps(1000, 7, 7), [7]);
    assert_eq!(steps(i64::MAX, 1, 3), [1, 3]);
}

#[test]
fn rows_in_between_are_evenly_spaced() {
    let evenly = |every, first, after, end| ThermoSchedule { every, first }.evenly(after, end);
    // The end is left out, whether it has a row or not.
    assert_eq!((evenly(10, 0, 0, 40), evenly(10, 0, 0, 41), evenly(10, 0, 0, 31)), (3, 4, 3));
    assert_eq!((evenly(1, 0, 5, 6), evenly(1, 0, 5, 8), evenly(1, 0, 5, 5)), (0, 2, 0));
    // A run begins between two multiples; then all is even.
    assert_eq!((evenly(50, 30, 30, 200), evenly(50, 30, 50, 200)), (0, 2));
    assert_eq!((evenly(0, 0, 0, 100), evenly(i64::MAX, 0, 0, i64::MAX), evenly(10, -20, -20, 1)), (0, 0, 2));
    // They are the rows that the schedule has.
    let schedule = ThermoSchedule { every: 7, first: 3 };
    let rows = |after: i64, end| {
        std::iter::successors(schedule.next(after, 1000), |s| schedule.next(*s, 1000)).take_while(move |s| *s < end)
    };
    for end in 15..60 {
        assert_eq!(schedule.evenly(14, end), rows(14, end).count() as i64, "{end}");
    }
}

#[test]
fn rows_of_sums_need_no_particles_and_no_clock() {
    let alone = |lines: &[&str]| table(lines).shows_sums_alone();
    assert!(alone(&["thermo_style one"]) && alone(&["thermo_style yaml"]));
    assert!(alone(&["thermo_style custom step elapsed time temp pe ke etotal press pxy vol atoms density"]));
    assert!(!alone(&["thermo_style multi"]) && !alone(&["thermo_style one", "thermo_modify line multi"]));
    for column in ["cpu", "tpcpu", "spcpu", "cpuremain", "nbuild", "ndanger", "fmax", "fnorm", "v_x"] {
        assert!(!alone(&[&format!("thermo_style custom step pe {column}")]), "{column}");
    }
}

#[test]
fn memory_line_as_readers_expect_it() {
    let expected = "Per MPI rank memory allocation (min/avg/max) = 3.119 | 3.119 | 3.119 Mbytes";
    assert_eq!(memory_line(3_270_508), expected);
}
