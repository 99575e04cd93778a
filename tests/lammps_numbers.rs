//! Scripts whose output LAMMPS 22Jul2025 printed, digit for digit: rounding at the cutoff, lost atoms, runs without set-up.

#[path = "common/cli.rs"]
mod common;

use common::Folder;
use octant::pair::{Mixing, PairCoefficients};

/// Perfect crystal, cutoff at the distance of a neighbor shell: rounding decides what lies inside.
const TIES: &str = "\
units metal
lattice fcc 1.65 origin 0.1 0.25 0
region b block 0 2 0 3 0 1
create_box 1 b
create_atoms 1 box
mass 1 40
pair_style lj/cut 2.8578838324886475
pair_coeff 1 1 0.01 1.1
neighbor 0.0 bin
thermo_style custom step pe press fmax fnorm
run 0
";

/// A hot crystal evaporates through a fixed side and swells a shrink-wrapped one; its runs go on without set-up.
const LOST: &str = "\
units lj
boundary f s p
lattice fcc 0.8442
region b block 0 3 0 3 0 3
create_box 1 b
create_atoms 1 box
mass 1 1
velocity all create 5.44 87287
pair_style lj/cut 2.5
pair_coeff 1 1 1 1
fix 1 all nve
thermo_modify lost ignore
thermo 20
dump 1 all custom 40 lost.dump id
run 40
velocity all scale 2.0
neigh_modify every 2 check no
timestep 0.002
run 20 pre no
write_data lost.data
print \"NOW $(atoms) $(yhi:%.10g) $(count(all)) $(temp:%.8g)\"
undump 1
reset_timestep 10
run 0
";

const TIES_ROWS: &[&str] = &["0 -1.8649926 119759.28 0.00062650024 0.0012530005", "Total # of neighbors = 1032"];

const LOST_ROWS: &[&str] = &[
    "0 5.44 -5.2919872 0 2.8032509 -0.24854248 127.95736",
    "20 3.5835397 -2.6756366 0 3.0185473 9.3352652 143.35185",
    "40 3.5765774 -2.8668079 0 3.0677785 4.639167 169.90387",
    "Total # of neighbors = 2373",
    "Neighbor list builds = 7",
    "Dangerous builds = 0",
    "40 1.792 -2.8668079 0 0.10664342 3.3262354 169.90387",
    "60 1.7402005 -2.9441172 0 0.022133583 2.07944 179.14409",
    "Total # of neighbors = 2181",
    "Neighbor list builds = 17",
    "Dangerous builds not checked",
    "NOW 110 6.197761974 110 1.7402005",
    "10 1.9956427 -2.9441172 0 0.022133583 2.07944 179.14409",
    "Total # of neighbors = 2181",
    "Neighbor list builds = 0",
    "Dangerous builds not checked",
];

/// Ids of the dump's last snapshot, which is not sorted: storage order after a sort and after atoms have left.
const LOST_IDS: &str = "1 2 3 119 5 6 7 8 9 10 11 12 126 14 15 122 25 27 17 18 19 20 29 31 21 22 23 24 33 35 26 121 37 38 30 32 39 40 34 36 41 42 125 44 45 120 47 48 49 50 51 52 53 54 118 56 57 58 110 69 59 60 61 62 71 73 63 64 65 66 75 77 68 124 123 80 72 74 81 82 76 78 83 84 112 86 87 116 89 90 91 92 93 94 95 96 114 98 99 100 109 111 101 102 103 104 113 115 105 106 107 108 117";

/// The lines of LAMMPS's output that a test compares, with single blanks.
fn compared(text: &str) -> Vec<String> {
    let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    let begins = ["Total #", "Neighbor list builds", "Dangerous", "NOW"];
    let wanted = |line: &String| {
        begins.iter().any(|b| line.starts_with(b)) || line.split(' ').all(|word| word.parse::<f64>().is_ok())
    };
    text.lines().map(words).filter(|line| !line.is_empty()).filter(wanted).collect()
}

#[test]
fn ties_at_the_cutoff_are_decided_as_lammps_does() {
    let folder = Folder::new("ties");
    folder.write("a.in", TIES);
    for search in ["trimmed", "octant", "midplane", "standard", "standard:0.5", "brute"] {
        assert_eq!(
            compared(&folder.says(&format!("run a.in --precision double --search {search}")))[..2],
            *TIES_ROWS,
            "{search}"
        );
    }
}

#[test]
fn atoms_leave_and_runs_go_on_as_in_lammps() {
    let folder = Folder::new("lost");
    folder.write("a.in", LOST);
    assert_eq!(compared(&folder.says("run a.in --precision double")), *LOST_ROWS);
    let dump = folder.read("lost.dump");
    let last = dump.rsplit("ITEM: ATOMS id").next().unwrap();
    assert_eq!(last.split_whitespace().collect::<Vec<_>>().join(" "), LOST_IDS);
}

/// A crystal of two metals, all pairs set.
const MORSE: &str = "\
units metal
lattice fcc 3.615 origin 0.1 0.2 0.3
region b block 0 4 0 4 0 4
create_box 2 b
create_atoms 1 box basis 1 2
mass 1 63.546
mass 2 107.87
velocity all create 1800 4711 loop geom
pair_style morse 5.5
pair_modify shift yes
pair_coeff 1 1 0.3429 1.3588 2.866
pair_coeff 1 2 0.3376 1.3638 2.99 5.2
pair_coeff 2 2 0.3323 1.3690 3.115 5.4
fix 1 all nve
thermo_style custom step temp pe ke press
thermo 50
run 100
";

const MORSE_ROWS: [&str; 4] = [
    "0 1800 -586.65217 59.330407 322563.63",
    "50 829.13377 -554.64003 27.329357 338205.91",
    "100 1032.7481 -561.34928 34.04076 335152.94",
    "Total # of neighbors = 17920",
];

/// Screened charges, the unlike pair by mixing.
const YUKAWA: &str = "\
units lj
lattice bcc 0.4
region b block 0 5 0 5 0 5
create_box 2 b
create_atoms 1 box basis 2 2
mass 1 1.0
mass 2 2.5
velocity all create 1.0 4711 loop geom
pair_style yukawa 1.2 3.5
pair_modify mix sixthpower
pair_coeff 1 1 40.0
pair_coeff 2 2 90.0 3.0
fix 1 all nve
timestep 0.002
thermo_style custom step temp pe ke press
thermo 50
run 100
";

const YUKAWA_ROWS: [&str; 4] = [
    "0 1 62.169981 1.494 27.800293",
    "50 0.67660358 62.018478 1.0108458 27.373945",
    "100 0.42780603 62.266298 0.63914221 27.254166",
    "Total # of neighbors = 8802",
];

/// Forces that end without a step, the unlike pair by mixing.
const SMOOTH: &str = "\
units lj
lattice fcc 0.8442
region b block 0 5 0 4 0 5
create_box 2 b
create_atoms 1 box basis 2 2
mass 1 1.0
mass 2 2.5
velocity all create 1.44 4711 loop geom
pair_style lj/smooth/linear 2.4
pair_coeff 1 1 1.0 1.0
pair_coeff 2 2 0.7 0.9 2.1
fix 1 all nve
timestep 0.004
thermo_style custom step temp pe ke press
thermo 50
run 100
";

const SMOOTH_ROWS: [&str; 4] = [
    "0 1.44 -4.590137 2.1546 -3.9966107",
    "50 0.81447656 -3.6544162 1.2186606 1.3397911",
    "100 0.82037487 -3.6630896 1.2274859 1.2517814",
    "Total # of neighbors = 12599",
];

/// Exponents of all kinds, those of the unlike pair by mixing, energies shifted.
const MIE: &str = "\
units lj
lattice fcc 0.8442
region b block 0 5 0 4 0 5
create_box 2 b
create_atoms 1 box basis 2 2
mass 1 1.0
mass 2 2.5
velocity all create 1.44 4711 loop geom
pair_style mie/cut 2.4
pair_coeff 1 1 1.0 1.0 36 6
pair_coeff 2 2 0.7 0.9 14.65 7.2 2.1
pair_modify shift yes mix arithmetic
fix 1 all nve
timestep 0.002
thermo_style custom step temp pe ke press
thermo 50
run 100
";

const MIE_ROWS: [&str; 4] = [
    "0 1.44 -3.2943483 2.1546 -4.7260526",
    "50 1.2158458 -2.9594207 1.8192093 3.2242466",
    "100 1.2694929 -3.0395687 1.8994788 3.2805498",
    "Total # of neighbors = 12582",
];

#[test]
fn other_styles_print_what_lammps_prints() {
    let folder = Folder::new("styles");
    for (script, rows) in [(MORSE, MORSE_ROWS), (YUKAWA, YUKAWA_ROWS), (SMOOTH, SMOOTH_ROWS), (MIE, MIE_ROWS)] {
        folder.write("a.in", script);
        assert_eq!(compared(&folder.says("run a.in --precision double"))[..4], rows);
    }
}

#[test]
fn exponents_are_mixed_as_lammps_mixes_them() {
    let given = |first: &[&str], second: &[&str], mixing| {
        let mut given = PairCoefficients::new("mie/cut", 2.5, 2).unwrap();
        given.set((1, 1), (1, 1), first).unwrap();
        given.set((2, 2), (2, 2), second).unwrap();
        given.mixing = mixing;
        given.complete()
    };
    // Energies of the unlike pair at this distance, and at the cutoff, that LAMMPS 22Jul2025 has.
    let expected = [
        (Mixing::Geometric, -0.9027189193845566, -0.0036912013926),
        (Mixing::Arithmetic, -0.9134407356184031, -0.0035332721076),
        (Mixing::SixthPower, -0.6764929204215251, -0.0024796439587),
    ];
    for (mixing, energy, at_cutoff) in expected {
        let (table, mixed, _) =
            given(&["1.3", "0.9", "36.5", "6.25"], &["0.7", "1.2", "14", "7", "3.0"], mixing).unwrap();
        let found = table.evaluate(0, 1, 1.34f64.sqrt()).unwrap().energy;
        assert!((found - energy).abs() < 1e-14, "{mixing:?}: {found}");
        assert!((table.pairs[1].energy_at_cutoff - at_cutoff).abs() < 1e-12, "{mixing:?}");
        assert_eq!(mixed, 1);
    }
    // sqrt(12 6) twice, of which no potential can be made.
    let why = given(&["1", "1", "12", "6"], &["1", "1", "6", "12"], Mixing::Geometric).unwrap_err();
    assert!(why.contains("gives no number"), "{why}");
    // Mie's potential with exponents 12 and 6 is that of Lennard and Jones, C being 4.
    let (table, ..) = given(&["1.3", "0.9", "12", "6"], &["1", "1", "12", "6"], Mixing::Geometric).unwrap();
    for r in [0.8, 1.0, 1.5, 2.4f64] {
        let s6 = (0.9 / r).powi(6);
        let exact = 4.0 * 1.3 * s6 * (s6 - 1.0);
        assert!((table.evaluate(0, 0, r).unwrap().energy - exact).abs() < 1e-14 * exact.abs().max(1.0));
    }
}

/// Tail corrections of a slab whose volume changes: kept by a run without set-up, counted anew by a set-up.
const TAIL: &str = "\
units lj
boundary p p s
lattice fcc 0.8442
region b block 0 3 0 3 0 3
create_box 2 b
region half block INF INF INF INF INF 1.4
create_atoms 1 box
group low region half
create_atoms 2 single 0.5 0.5 0.5
create_atoms 2 single 1.5 1.5 0.5
mass 1 1
mass 2 1.5
velocity all create 1.44 87287
pair_style lj/cut 2.5
pair_coeff 1 1 1 1
pair_coeff 2 2 0.5 0.9 2.2
pair_modify tail yes
fix 1 all nve
thermo_style custom step pe evdwl etail enthalpy press pxx pxy
thermo 10
run 20
create_atoms 1 single 1.5 1.5 3.1
print \"NOW $(etail:%.10g) $(pe:%.10g)\"
run 10
pair_modify tail no
run 1 pre no
thermo_modify norm no
pair_modify tail yes mix arithmetic
run 1
pair_modify tail no shift yes
run 0
";

const TAIL_ROWS: [&str; 11] = [
    "0 -5.9362561 -5.9362561 -0.52934287 -6.4552726 -2.6630286 -2.9670795 -0.03522258",
    "10 -5.9865441 -5.9865441 -0.51362124 -5.5992529 -1.7642147 -1.8790578 0.02724717",
    "20 -5.137628 -5.137628 -0.50035702 -1.111985 2.5162313 2.6144507 -0.033361578",
    "NOW -0.5003570216 -5.137628005",
    "20 -5.1270549 -5.1270549 -0.48978387 -1.0802945 2.482606 2.5787499 -0.032656607",
    "30 -5.4528889 -5.4528889 -0.47537443 -2.7105533 0.93296279 1.6108564 -0.28898564",
    "30 -4.9775145 -4.9775145 0 -1.2857316 1.7858946 2.4637882 -0.28898564",
    "31 -4.952637 -4.952637 0 -1.2003594 1.8621787 2.6004823 -0.30802681",
    "31 -694.15603 -694.15603 -60.249427 -333.6285 1.0115438 1.7415321 -0.3051164",
    "32 -689.86668 -689.86668 -60.249427 -317.74833 1.1216562 1.9155507 -0.31207801",
    "32 -581.15607 -581.15607 0 -88.703835 1.9516666 2.7430515 -0.31109147",
];

#[test]
fn tail_corrections_are_those_of_lammps() {
    let folder = Folder::new("tail");
    folder.write("a.in", TAIL);
    let said = folder.says("run a.in --precision double");
    let rows: Vec<String> =
        compared(&said).into_iter().filter(|row| !row.contains("build") && !row.contains('#')).collect();
    assert_eq!(rows, TAIL_ROWS);
    assert_eq!(said.matches("WARNING: tail corrections").count(), 3, "{said}");
    let plain = YUKAWA.replace("mix sixthpower", "mix sixthpower tail yes");
    folder.write("a.in", &plain);
    let said = folder.says("run a.in --precision double");
    assert!(said.contains("WARNING: pair style yukawa has no tail corrections"), "{said}");
    assert_eq!(compared(&said)[..4], YUKAWA_ROWS);
}

/// Chains of several lengths, a ramp, drag, parts of a step, two masses, two groups, runs with and without set-up.
const NVT: &str = "\
units lj
lattice fcc 0.8442
region b block 0 4 0 4 0 4
create_box 2 b
create_atoms 1 box basis 3 2 basis 4 2
mass 1 1
mass 2 2.5
velocity all create 1.44 87287 loop geom
pair_style lj/cut 2.5
pair_coeff * * 1 1
fix 1 all nvt temp 1.5 0.9 0.3 tchain 4 tloop 2 drag 0.1
thermo_style custom step temp pe press ke ecouple econserve etotal
thermo_modify format float %.12g
thermo 50
run 200
run 50
velocity all scale 1.1
run 50 pre no
unfix 1
group g type 2
group h type 1
fix 1 g nvt temp 1.0 1.0 0.2 
fix 2 h nvt temp 0.8 0.8 0.5 tchain 1
run 100
";

/// Twelve digits of values of order 1: what rounding makes of 400 steps stays below the last.
const NVT_ROWS: [&str; 12] = [
    "0 1.44 -6.77336805325 -5.02441789509 2.1515625 0 -4.62180555325 -4.62180555325",
    "50 0.828434031556 -5.69931094649 0.600669095953 1.23779694168 -0.173275620994 -4.6347896258 -4.46151400481",
    "100 0.898009368831 -5.57462748612 1.31462431207 1.3417522796 -0.410234315555 -4.64310952207 -4.23287520652",
    "150 1.03054258063 -5.61267902949 1.16682441607 1.53977553551 -0.537988291421 -4.6108917854 -4.07290349398",
    "200 0.987689138461 -5.50976170401 1.57716647436 1.47574646665 -0.511820147698 -4.54583538506 -4.03401523736",
    "200 0.987689138461 -5.50976170401 1.57716647436 1.47574646665 -0.853033579497 -4.88704881686 -4.03401523736",
    "250 1.03194108654 -5.44115567643 2.01745430752 1.54186510001 -0.627835442773 -4.52712601919 -3.89929057642",
    "250 1.1 -5.44115567643 2.07468520736 1.6435546875 -0.627835442773 -4.4254364317 -3.79760098893",
    "300 1.09817357895 -5.30263720208 2.72681467029 1.64082575762 -0.734019612221 -4.39583105668 -3.66181144446",
    "300 1.09817357895 -5.30263720208 2.72681467029 1.64082575762 0 -3.66181144446 -3.66181144446",
    "350 1.06863914609 -5.34231672945 2.52525551542 1.59669716164 0.0852890491246 -3.66033051868 -3.74561956781",
    "400 0.94780273564 -5.49466397778 1.73104669978 1.41615057181 0.418586706419 -3.65992669955 -4.07851340597",
];

#[test]
fn chains_of_thermostats_are_those_of_lammps() {
    let folder = Folder::new("nvt");
    folder.write("a.in", NVT);
    let said = folder.says("run a.in --precision double");
    let rows: Vec<String> = compared(&said).into_iter().filter(|row| row.split(' ').count() == 8).collect();
    for (row, expected) in rows.iter().zip(NVT_ROWS) {
        let numbers = |row: &str| row.split(' ').map(|word| word.parse::<f64>().unwrap()).collect::<Vec<_>>();
        for (a, b) in numbers(row).into_iter().zip(numbers(expected)) {
            assert!((a - b).abs() <= 2e-11 * b.abs().max(1.0), "{row}\n{expected}");
        }
    }
    assert_eq!(rows.len(), NVT_ROWS.len());
}

/// Two fixes that integrate the same atoms: each ends the step before the next begins to, so that a thermostat goes by the kinetic
/// energy that the fixes before it and its own kick have left. Whoever asks for it is told.
#[test]
fn fixes_that_integrate_the_same_atoms_take_turns() {
    let scene = "units lj\nlattice fcc 0.8442\nregion box block 0 4 0 4 0 4\ncreate_box 1 box\ncreate_atoms 1 box\nmass 1 1.0\n\
                 velocity all create 1.44 87287 loop geom\npair_style lj/cut 2.5\npair_coeff 1 1 1.0 1.0\nregion l block 0 2.1 0 4 0 4\n\
                 group l region l\ngroup r subtract all l\nthermo_style custom step temp epair press ecouple\ntimestep 0.002\n\
                 thermo 10\n";
    let bath = "nvt temp 1.0 1.2 0.1";
    let cases = [
        (format!("fix 1 all {bath}\nfix b all nve\n"), Some("0.65605796 -5.6507864 0.35313225 0.067107721"), true),
        (
            format!("fix 1 all {bath}\nfix b all nvt temp 0.8 0.8 0.2\n"),
            Some("0.63960589 -5.6634541 0.27854844 0.10433926"),
            true,
        ),
        ("fix 1 all nve\nfix b all nve\n".into(), None, true),
        ("fix 1 all nve\nfix b l nve/limit 0.1\n".into(), None, true),
        ("fix 1 all nve\nfix b all nve/euler2\n".into(), None, true),
        (format!("fix 1 l {bath}\nfix b r nve\n"), None, false),
        ("fix 1 all nve\nfix b all langevin 1 1 0.1 5\n".into(), None, false),
    ];
    let folder = Folder::new("twice");
    for (fixes, row, twice) in cases {
        folder.write("a.in", &format!("{scene}{fixes}run 20\n"));
        let said = folder.says("run a.in --backend cpu --precision double");
        let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
        if let Some(row) = row {
            assert!(said.lines().any(|line| words(line) == format!("20 {row}")), "{fixes}: {said}");
        }
        let style =
            |line: &str| fixes.lines().nth(line.parse().unwrap()).unwrap().split(' ').nth(3).unwrap().to_string();
        let told = format!(
            "WARNING: One or more atoms are time integrated more than once: by fix 1 ({}, a.in:16) and fix b ({}, a.in:17)\n",
            style("0"),
            style("1")
        );
        assert_eq!(said.contains(&told), twice, "{fixes}: {said}");
        assert_eq!(said.contains("integrated more than once"), twice, "{fixes}");
        // What no bath has taken is no negative number.
        let first =
            said.lines().map(words).find(|line| line.starts_with("0 ") && line.split(' ').count() == 5).unwrap();
        assert!(first.ends_with(" 0"), "{fixes}: {first}");
    }
}
