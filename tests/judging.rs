//! Whatever a script says, judging it ends, without a panic, in an answer or in words with a place.

use octant::session::{Settings, check_text};
use proptest::prelude::*;

const SCRIPTS: [&str; 5] = [
    include_str!("../inputs/melt.in"),
    include_str!("../inputs/cluster.in"),
    include_str!("../inputs/slab.in"),
    include_str!("../inputs/metal.in"),
    include_str!("../inputs/dilute.in"),
];

/// A scene small enough that whatever follows can be tried.
const SMALL: &str = "lattice sc 1.0\nregion b block 0 6 0 5 0 4\ncreate_box 2 b\ncreate_atoms 1 box\n";

fn judge(text: &str) {
    if let Err(error) = check_text("in", text, &settings()) {
        let message = error.to_string();
        if let octant::Error::Input(error) = &error {
            let length = error.source.text.len();
            assert!(error.span.start <= error.span.end && error.span.end <= length, "{message}");
            assert!(!format!("{:?}", miette::Report::new((**error).clone())).is_empty());
        }
        assert!(!message.is_empty());
    }
}

/// Files go to the working folder, which is there.
fn settings() -> Settings {
    Settings { variables: vec![("out".into(), ".".into())], ..Settings::default() }
}

#[cfg(feature = "chemfiles")]
#[test]
fn the_scripts_as_they_are_pass() {
    for script in SCRIPTS {
        check_text("in", script, &settings()).unwrap();
    }
}

fn number() -> impl Strategy<Value = String> {
    let odd = [
        "0",
        "1",
        "2",
        "-1",
        "3",
        "0.5",
        "2.5",
        "1e300",
        "-1e300",
        "1e-300",
        "1e-10",
        "1e9",
        "2147483647",
        "2147483648",
        "9223372036854775807",
        "nan",
        "inf",
        "-inf",
        "1e",
        "0x10",
        "NULL",
        "INF",
        "EDGE",
        "*",
        "1*2",
        "*2",
        "2*",
        "1*",
        "1:2:1",
        "$(1/0)",
        "$(step)",
        "${v}",
        "v_v",
        "12345",
        "1e5",
        "$(vol)",
        "$(temp)",
        "$(count(all))",
        "",
        "7",
    ];
    prop_oneof![
        6 => proptest::sample::select(odd.to_vec()).prop_map(str::to_string),
        1 => any::<f64>().prop_map(|x| format!("{x:e}")),
        1 => any::<i32>().prop_map(|x| x.to_string()),
        3 => (0..10i32).prop_map(|x| x.to_string()),
    ]
}

/// A word of the input language.
fn word() -> impl Strategy<Value = String> {
    let words = [
        "all",
        "b",
        "c",
        "g",
        "d",
        "1",
        "box",
        "region",
        "single",
        "random",
        "type",
        "id",
        "union",
        "subtract",
        "yes",
        "no",
        "p",
        "f",
        "s",
        "fs",
        "lj",
        "real",
        "metal",
        "si",
        "sc",
        "fcc",
        "bcc",
        "hcp",
        "diamond",
        "custom",
        "none",
        "a1",
        "a2",
        "basis",
        "orient",
        "origin",
        "spacing",
        "x",
        "y",
        "z",
        "block",
        "sphere",
        "cylinder",
        "side",
        "in",
        "out",
        "units",
        "lattice",
        "create",
        "set",
        "scale",
        "zero",
        "linear",
        "angular",
        "dist",
        "gaussian",
        "loop",
        "geom",
        "local",
        "mom",
        "rot",
        "sum",
        "lj/cut",
        "shift",
        "mix",
        "arithmetic",
        "every",
        "delay",
        "check",
        "once",
        "bin",
        "nve",
        "atom",
        "custom",
        "xyz",
        "dcd",
        "xtc",
        "netcdf",
        "chemfiles",
        "out.dump",
        "out.nc",
        "step",
        "temp",
        "pe",
        "press",
        "vol",
        "v_v",
        "sort",
        "append",
        "first",
        "format",
        "float",
        "%g",
        "%d",
        "line",
        "norm",
        "lost",
        "warn",
        "flush",
        "pre",
        "post",
        "upto",
        "start",
        "stop",
        "map",
        "hash",
        "equal",
        "string",
        "index",
        "v",
        "file",
        "screen",
        "log",
        "none",
        "both",
        "pair",
        "ij",
        "nocoeff",
        "one",
        "multi",
        "delete",
        "clear",
        "intersect",
        "element",
        "image",
        "unwrap",
        "precision",
        "id",
        "xu",
        "ix",
    ];
    prop_oneof![3 => proptest::sample::select(words.to_vec()).prop_map(str::to_string), 2 => number()]
}

/// A line: a command with words that suit it, or with any words.
fn line() -> impl Strategy<Value = String> {
    let commands = [
        "units",
        "atom_style",
        "atom_modify",
        "dimension",
        "boundary",
        "lattice",
        "region",
        "create_box",
        "create_atoms",
        "mass",
        "group",
        "velocity",
        "pair_style",
        "pair_coeff",
        "pair_modify",
        "neighbor",
        "neigh_modify",
        "fix",
        "unfix",
        "timestep",
        "thermo",
        "thermo_style",
        "thermo_modify",
        "dump",
        "dump_modify",
        "undump",
        "reset_timestep",
        "print",
        "echo",
        "run",
        "write_data",
        "variable",
        "next",
        "if",
        "label",
        "jump",
        "newton",
    ];
    let any_words = (proptest::sample::select(commands.to_vec()), proptest::collection::vec(word(), 0..9))
        .prop_map(|(command, words)| format!("{command} {}", words.join(" ")));
    let shapes = [
        "lattice fcc N",
        "lattice custom N a1 N N N a2 N N N a3 N N N basis N N N",
        "lattice sc N origin N N N orient x N N N",
        "lattice bcc N spacing N N N",
        "region c block N N N N N N",
        "region c sphere N N N N side out units box",
        "region c cylinder x N N N N N",
        "create_box N b",
        "create_atoms N box",
        "create_atoms N region c",
        "create_atoms N single N N N units box",
        "create_atoms N random 20 N NULL",
        "create_atoms N random 20 N c",
        "mass N N",
        "mass * N",
        "group g type N",
        "group g id N",
        "group g region c",
        "group g subtract all g",
        "velocity all create N N loop geom",
        "velocity g create N N dist gaussian mom N rot yes",
        "velocity all set N N N",
        "velocity all scale N",
        "velocity g zero angular",
        "pair_style lj/cut N",
        "pair_coeff N N N N",
        "pair_coeff * * N N N",
        "pair_modify shift yes mix arithmetic",
        "neighbor N bin",
        "neigh_modify every N delay N check no",
        "fix 1 all nve",
        "fix 1 g nve",
        "timestep N",
        "thermo N",
        "thermo_style custom step temp press v_v",
        "thermo_modify format float %N.Ng",
        "dump d all custom N out.dump id type x vx ix fx",
        "dump d g netcdf N out.nc id type x y z",
        "dump_modify d sort id every N",
        "dump_modify d first yes format float %.Nf",
        "reset_timestep N",
        "run N",
        "run N upto",
        "run N pre no post no",
        "variable v equal N*N/N^N",
        "variable v index N N",
        "variable v loop N N",
        "print \"$(v_v+N)\"",
        "if \"N < N\" then \"run N\" else \"mass 1 N\"",
        "write_data out.data",
        "print \"$(bound(all,xmin)-gyration(g))\"",
    ];
    let shaped = (proptest::sample::select(shapes.to_vec()), proptest::collection::vec(number(), 12)).prop_map(
        |(shape, numbers)| {
            let mut numbers = numbers.into_iter();
            shape.chars().map(|c| if c == 'N' { numbers.next().unwrap_or_default() } else { c.to_string() }).collect()
        },
    );
    prop_oneof![1 => any_words, 3 => shaped]
}

/// Lines of a real script with some changed, doubled, moved or left out.
fn mutated() -> impl Strategy<Value = String> {
    let edits = proptest::collection::vec((any::<u16>(), 0..5u8, any::<u16>(), word(), line()), 1..6);
    (0..SCRIPTS.len(), edits).prop_map(|(script, edits)| {
        let mut lines: Vec<String> = SCRIPTS[script].lines().map(str::to_string).collect();
        for (at, kind, other, word, line) in edits {
            let count = lines.len().max(1);
            let (at, other) = (at as usize % count, other as usize);
            match (kind, lines.get(at).cloned()) {
                (_, None) => lines.push(line),
                (0, Some(_)) => drop(lines.remove(at)),
                (1, Some(old)) => lines.insert(other % count, old),
                (2, Some(_)) => lines.insert(at, line),
                (3, Some(_)) => lines.swap(at, other % count),
                (_, Some(old)) => {
                    let mut words: Vec<&str> = old.split(' ').collect();
                    let k = other % words.len();
                    words[k] = &word;
                    lines[at] = words.join(" ");
                }
            }
        }
        lines.join("\n") + "\n"
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(cases()) })]

    #[test]
    fn random_commands_do_no_harm(set_up in any::<bool>(), lines in proptest::collection::vec(line(), 1..14)) {
        judge(&format!("{}{}\n", if set_up { SMALL } else { "" }, lines.join("\n")));
    }

    #[test]
    fn changed_scripts_do_no_harm(text in mutated()) {
        judge(&text);
    }
}

/// `PROPTEST_CASES` asks for more.
fn cases() -> u32 {
    std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(400)
}
