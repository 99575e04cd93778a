"""The page: speed with its error, OpenMM beside, stages, scenes, what others reach. Every number is from the tables."""

from __future__ import annotations

from pathlib import Path

from validation.bench.gpu import tables
from validation.bench.gpu.plan import OCTANT, PLAIN, SCENES
from validation.bench.gpu.tables import Group, Spread
from validation.bench.liquid import CUTOFF, DENSITY, TEMPERATURE, TIMESTEP
from validation.markdown import number, spaced, table

#: Columns of the stages, in the order of the page.
_STAGES = ("pair", "list", "sort", "check", "modify", "output", "other")


def write(folder: Path) -> None:
    """Writes ``speed.md`` beside the tables."""
    bench, openmm = tables.read(folder / tables.BENCH), tables.read(folder / tables.OPENMM)
    (folder / "speed.md").write_text("\n".join(lines(bench, openmm, tables.read(tables.PEERS))), encoding="utf-8")


def lines(bench: list[tables.Row], openmm: list[tables.Row], peers: list[tables.Row]) -> list[str]:
    """The page, line by line."""
    if not bench:
        return ["# Speed on a GPU", "", "Nothing was measured.", ""]
    plain, beside = tables.groups(bench, scene=PLAIN), tables.groups(openmm)
    return [
        "# Speed on a GPU",
        "",
        *_head(bench, openmm),
        "![Speed against number of atoms, force error and drift beside it](speed.svg)",
        "",
        *_speed(plain),
        *_openmm(plain, beside),
        *_stages(plain),
        *_scenes(bench, plain),
        *_peers(peers),
    ]


def _head(bench: list[tables.Row], openmm: list[tables.Row]) -> list[str]:
    stamps = dict.fromkeys((row["date"], row["device"], row["driver"], row["version"], row["commit"]) for row in bench)
    said = [
        f"{date}, {device}{f', driver for CUDA {driver}' if driver else ''}, octant {version}, commit {commit}."
        for date, device, driver, version, commit in stamps
    ]
    others = dict.fromkeys(f"{row['program']} {row['version']} ({row['platform']})" for row in openmm)
    peer = f"{', '.join(others)} ran on the same card in turns with octant." if others else "OpenMM did not run beside."
    skins = sorted({float(row["skin"]) for row in bench})
    rounds = sorted(
        {len(group.rows) if len(group.rows) > 1 else int(group.first["rounds"]) for group in tables.groups(bench)}
    )
    return [
        *said,
        peer,
        "",
        f"The liquid of LAMMPS's `bench/in.lj`: fcc at density {DENSITY}, temperature {TEMPERATURE}, cutoff {CUTOFF}, "
        f"NVE, timestep {TIMESTEP}, "
        "`neigh_modify delay 0 every 1 check yes`; list builds are part of what is timed. "
        f"Skins: {' to '.join(f'{skin:g}' for skin in dict.fromkeys((skins[0], skins[-1])))}. "
        f"Speeds are medians over the rounds ({' or '.join(map(str, rounds))}), least and most in brackets. "
        "Force errors are against f64 sums over all pairs, over the RMS force. In single and mixed precision f32 decides "
        "whether a pair is within the cutoff: where one lies there to its rounding, two atoms may be off by the force at "
        "the cutoff, 0.039, a worst atom of some 1.6e-03. Drift of the total energy is epsilon per "
        "atom and tau; pairs are those that a list built in the run lacks, and has too much. A dash: not measured at this "
        "size.",
        "",
    ]


def _spread(spread: Spread) -> str:
    return f"{number(spread.median)} ({number(spread.least)} to {number(spread.most)})"


def _cell(value: float | None, digits: int = 3) -> str:
    return "-" if value is None else number(value, digits)


def _drift(group: Group) -> str:
    found = group.drift()
    return "-" if found is None else f"{found[0]:.1e} ± {found[1]:.0e}"


def _errors(group: Group) -> list[str]:
    return [f"{group.most('force_error_rms'):.1e}", f"{group.most('force_error_worst'):.1e}", _drift(group)]


def _pairs(group: Group) -> str:
    missing, extra = group.total("pairs_missing"), group.total("pairs_extra")
    return "-" if missing is None else f"{missing} / {extra}"


def _speed(plain: list[Group]) -> list[str]:
    heads = (
        "atoms",
        "precision",
        "skin",
        "million atom-steps/s",
        "steps/s",
        "force error, RMS",
        "worst atom",
        "drift",
        "pairs lacking / too much",
        "atoms compared",
    )
    body = [
        [
            spaced(group.atoms),
            group.precision,
            f"{float(group.first['skin']):g}",
            _spread(group.speed()),
            _cell(group.speed("steps_per_s").median),
            *_errors(group),
            _pairs(group),
            spaced(int(group.first["sampled_atoms"])),
        ]
        for group in plain
    ]
    return ["## Speed and error", "", *table(heads, body)]


def _openmm(plain: list[Group], beside: list[Group]) -> list[str]:
    if not beside:
        return []
    heads = [
        "atoms",
        "OpenMM",
        "million atom-steps/s",
        "force error, RMS",
        "worst atom",
        *(f"octant {p} over it" for p in OCTANT),
    ]
    body = []
    for peer in beside:
        own = {group.precision: group for group in plain if group.atoms == peer.atoms}
        ratios = [_spread(tables.ratio(own[name], peer)) if name in own else "-" for name in OCTANT]
        errors = [f"{peer.most(column):.1e}" for column in ("force_error_rms", "force_error_worst")]
        body.append([spaced(peer.atoms), peer.precision, _spread(peer.speed()), *errors, *ratios])
    note = "Ratios are taken round by round: what slows a whole round cancels."
    return ["## OpenMM on the same card", "", note, "", *table(heads, body)]


def _stages(plain: list[Group]) -> list[str]:
    heads = [
        "atoms",
        "precision",
        *(f"{stage}, us a step" for stage in _STAGES),
        "steps a build",
        "us a build",
        "list entries an atom",
        "bytes an atom",
        "start-up, s",
        "dangerous builds",
        "melted, steps",
        "timed, steps",
    ]
    body = []
    for group in plain:
        numbers = [
            *(f"{stage}_us" for stage in _STAGES),
            "steps_per_build",
            "build_us",
            "list_entries_per_atom",
            "bytes_per_atom",
        ]
        # The first round has no kernels in its cache.
        start = group.most("start_up_s")
        last = [_cell(start), _cell(group.total("dangerous_builds")), spaced(int(group.first["melted"]))]
        body.append(
            [
                spaced(group.atoms),
                group.precision,
                *(_cell(group.mean(name)) for name in numbers),
                *last,
                spaced(int(group.first["steps"])),
            ]
        )
    return ["## Stages", "", *table(heads, body)]


def _scenes(bench: list[tables.Row], plain: list[Group]) -> list[str]:
    body = []
    for scene in SCENES:
        for group in tables.groups(bench, scene=scene):
            base = next((g for g in plain if (g.atoms, g.precision) == (group.atoms, group.precision)), None)
            over = "-" if base is None else f"{group.speed().median / base.speed().median:.3f}"
            body.append(
                [
                    scene,
                    spaced(group.atoms),
                    group.precision,
                    _spread(group.speed()),
                    over,
                    *_errors(group),
                    _pairs(group),
                ]
            )
    if not body:
        return []
    heads = (
        "scene",
        "atoms",
        "precision",
        "million atom-steps/s",
        "speed over the plain liquid's",
        "force error, RMS",
        "worst atom",
        "drift",
        "pairs lacking / too much",
    )
    note = (
        "`morse`: the same liquid with a Morse potential; `two-types`: two types at random with cutoffs that differ by "
        "type, lists about as long; `sums`: a thermo row, hence energy and virial, at every step."
    )
    return ["## Scenes", "", note, "", *table(heads, body)]


def _peers(peers: list[tables.Row]) -> list[str]:
    heads = ("program", "precision", "atoms", "million atom-steps/s", "skin", "hardware", "date", "source")
    body = [
        [
            peer["program"],
            peer["precision"] or "-",
            spaced(int(peer["atoms"])),
            peer["matom_steps_per_s"] + (f" ({peer['note']})" if peer["note"] else ""),
            peer["skin"] or "-",
            peer["hardware"],
            peer["date"],
            peer["source"],
        ]
        for peer in peers
    ]
    note = "Measured separately, not in this run; the dashed lines of the figure."
    return ["## What others reach", "", note, "", *table(heads, body)]
