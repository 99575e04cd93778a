"""The paper's particle system: neighbors at step 0 and later, and what its integrator does to the energy."""

from __future__ import annotations

import math
from collections.abc import Sequence

from validation.markdown import number, spaced, table
from validation.paper.results import Results, Row, one, where

#: How the integrators are called in LAMMPS's words and in others.
EULER, VERLET = "nve/euler2", "nve"

FORCES = {"spring": "F = k (R - r)", "inverse": "F = k / r"}

#: An energy that changes by less than this part is called kept.
KEPT = 0.05


def table_1(results: Results) -> list[str]:
    """Neighbors at step 0: counted, expected, published."""
    rows = results.tables["table1"]
    cells = [
        [
            spaced(int(row["particles"])),
            row["edge"],
            f"{float(row['neighbors']):.2f} ({float(row['neighbors_least']):.2f} to "
            f"{float(row['neighbors_most']):.2f})",
            f"{float(row['expected']):.2f}",
            row["paper"],
        ]
        for row in rows
    ]
    agree = sum(round(float(row["neighbors"])) == int(row["paper"]) for row in rows)
    off = max(abs(float(row["neighbors"]) / float(row["expected"]) - 1) for row in rows)
    return [
        "The boxes were chosen so that the mean number of others within R, (N - 1) (4 π s³/3 - 3 π s⁴/2 + 8 s⁵/5 - "
        "s⁶/6) with s = R/L, "
        f"is the paper's. What is counted, median over {rows[0]['seeds']} seeds, is {agree} times of {len(rows)} the "
        "paper's number "
        f"when rounded, and at most {100 * off:.1f} % from the closed form.",
        "",
        *table(["particles", "L / R", "neighbors (least to most)", "closed form", "paper"], cells),
    ]


def later(results: Results) -> list[str]:
    """How the counts go on."""
    rows = results.tables["later"]
    steps = sorted({int(row["step"]) for row in rows})
    lines = []
    for force, formula in FORCES.items():
        cells = []
        for size in sorted({int(row["particles"]) for row in where(rows, force=force)}):
            of = where(rows, force=force, particles=size)
            cells.append([spaced(size), *(_left(one(of, step=step)) for step in steps)])
        lines += [
            f"Neighbors of a particle after so many steps, {formula} (in brackets: particles that are left, %):",
            "",
        ]
        lines += table(["particles", *map(str, steps)], cells)
    return lines + [" ".join(_told(results, force) for force in FORCES), ""]


def _left(row: Row) -> str:
    gone = int(row["left"]) < int(row["particles"])
    return f"{float(row['neighbors']):.1f}" + (f" ({float(row['left_percent']):.0f})" if gone else "")


def _told(results: Results, force: str) -> str:
    rows = where(
        results.tables["later"], force=force, particles=min(int(row["particles"]) for row in results.tables["later"])
    )
    first, last = rows[0], max(rows, key=lambda row: int(row["step"]))
    lost = 100 - float(last["left_percent"])
    over = float(last["neighbors_over_first"])
    what = f"With {FORCES[force]} and {spaced(int(first['particles']))} particles"
    if lost > 10:
        gone = (
            f"{lost:.0f} % of them leave the box within {last['step']} steps: they are thrown farther than the box is "
            "wide, and a wall "
            "that reflects once, as LAMMPS's `fix wall/reflect` does, leaves them outside"
        )
    elif lost > 0:
        gone = f"{lost:.1f} % leave the box within {last['step']} steps, past walls that reflect once"
    else:
        gone = "none leaves the box"
    change = 100 * (over - 1)
    then = f"a particle has {abs(change):.0f} % {'fewer' if change < 0 else 'more'} neighbors then"
    return f"{what} {gone}; {then}."


def stability(results: Results) -> list[str]:
    """Growth of the energy against the timestep."""
    rows = results.tables["stability"]
    return [*_pair(where(rows, system="pair")), *_gas(where(rows, system="gas")), *_paper(where(rows, system="gas"))]


def _pair(rows: Sequence[Row]) -> list[str]:
    off = [abs(float(row["rate"]) - float(row["expected"])) for row in rows]
    within = sum(o <= float(row["uncertainty"]) + 1e-6 for o, row in zip(off, rows, strict=True))
    cells = []
    for euler in where(rows, integrator=EULER):
        verlet = one(rows, integrator=VERLET, part=float(euler["part"]))
        amplitude = math.sqrt(1 + 0.5 * float(euler["omega_dt"]) ** 2)
        cells.append(
            [
                number(float(euler["omega_dt"])),
                f"{math.exp(0.5 * float(euler['rate'])):.6f}",
                f"{amplitude:.6f}",
                f"{0.5 * float(euler['uncertainty']):.1e}",
                f"{0.5 * float(verlet['rate']):+.1e}",
                f"{0.5 * float(verlet['uncertainty']):.1e}",
            ]
        )
    verdict = (
        "all agree with the theory to within the measurement"
        if within == len(rows)
        else f"{within} of {len(rows)} agree with the theory to within the measurement, the others do not"
    )
    return [
        "**A pair on springs** in a periodic box of edge 1.5 R, which is a harmonic oscillator as it stands: "
        "second-order Euler should "
        "make its amplitude grow by sqrt(1 + (ω dt)²/2) a step at any timestep, velocity Verlet should keep it. "
        f"Of {len(rows)} runs {verdict} (a straight line through the logarithm of an energy that swings about its "
        "growth is uncertain by "
        "what is given):",
        "",
        *table(
            ["ω dt", "Euler: growth a step", "theory", "uncertain by", "Verlet: ln growth a step", "uncertain by"],
            cells,
        ),
    ]


def _gas(rows: Sequence[Row]) -> list[str]:
    own = float(where(rows, part=1.0)[0]["omega_dt"])
    lines = [
        f"**The paper's {spaced(int(rows[0]['particles']))} particles**, both readings of the force, without gravity, "
        "for as "
        "long as 100 of the paper's steps take: relative growth of the energy a step (d ln E / d n up to the first "
        "particle "
        f"that is lost; median over {rows[0]['runs']} seeds), and in brackets how many times its beginning the energy "
        "is by "
        "then. Lost is what is outside after a reflection or, in a periodic box, has moved by more than the box in a "
        "step. "
        f"With the paper's step sqrt(k/m) dt is {own:.2f}, which for the spring is ω dt, and k dt²/(m R²) is "
        f"{own * own:.2f}.",
        "",
    ]
    for force, formula in FORCES.items():
        cells = []
        for part in sorted({float(row["part"]) for row in rows}, reverse=True):
            of = where(rows, force=force, part=part)
            each = [one(of, box=box, integrator=i) for box in ("periodic", "walls") for i in (EULER, VERLET)]
            cells.append([f"{_fraction(part)}, {number(float(each[0]['omega_dt']))}", *map(_growth, each)])
        heads = [
            "of the paper's dt, sqrt(k/m) dt",
            "periodic, Euler",
            "periodic, Verlet",
            "walls, Euler",
            "walls, Verlet",
        ]
        lines += [f"{formula}:", "", *table(heads, cells)]
    return lines


def _growth(row: Row) -> str:
    lost = float(row["lost_percent"])
    gone = f", {lost:.0f} % lost" if lost >= 0.5 else ""
    if not row["rate"]:
        return f"lost at once{gone}"
    return f"{float(row['rate']):+.1e} ({number(float(row['ratio']))}x{gone})"


def _paper(rows: Sequence[Row]) -> list[str]:
    lines = ["What this says:", ""]
    for force, formula in FORCES.items():
        own = one(rows, force=force, box="walls", part=1.0, integrator=EULER)
        verlet = one(rows, force=force, box="walls", part=1.0, integrator=VERLET)
        text = (
            f"- **The paper's run** with {formula}, but for its gravity, which these runs leave out, would have seen the "
            f"energy {number(float(own['first_ratio']))} times as large after its first step"
        )
        if own["rate"]:
            text += f", growing by {100 * math.expm1(float(own['rate'])):.0f} % a step until the first particle is lost"
        text += f", and {float(own['lost_percent']):.0f} % of the particles outside the box after a hundred. "
        bad = not verlet["rate"] or float(verlet["rate"]) > 0.5 * float(own["rate"] or "inf")
        text += (
            "Velocity Verlet is no better with this timestep: it is the timestep that is too long for the start, not "
            "the "
            "integrator alone."
            if bad
            else "Velocity Verlet with the same timestep grows by "
            f"{100 * math.expm1(float(verlet['rate'])):.1f} % a step."
        )
        lines.append(text)
    lines += [_limit(rows, force) for force in FORCES]
    lines.append(_walls(rows))
    return [*lines, ""]


def _limit(rows: Sequence[Row], force: str) -> str:
    of = where(rows, force=force, box="periodic")
    parts = sorted({float(row["part"]) for row in of}, reverse=True)

    def kept(integrator: str) -> list[float]:
        ratios = {part: one(of, part=part, integrator=integrator) for part in parts}
        fine = [part for part in parts if ratios[part]["rate"] and abs(float(ratios[part]["ratio"]) - 1) <= KEPT]
        # From a step on, all shorter ones too.
        return [part for part in fine if all(shorter in fine for shorter in parts if shorter < part)]

    said = []
    for name, integrator in (("velocity Verlet", VERLET), ("second-order Euler", EULER)):
        fine = kept(integrator)
        shortest = one(of, part=parts[-1], integrator=integrator)
        said.append(
            f"{name} keeps the energy to {100 * KEPT:.0f} % from {_fraction(max(fine))} of the paper's step down"
            if fine
            else f"{name} does not even at {_fraction(parts[-1])} "
            f"({number(float(shortest['ratio']))} times its beginning)"
        )
    return f"- **{FORCES[force]}, periodic**: {said[0]}; {said[1]}."


def _walls(rows: Sequence[Row]) -> str:
    said = []
    for force, formula in FORCES.items():
        of = where(rows, force=force, integrator=VERLET)
        part = min(float(row["part"]) for row in of)
        box, walls = (float(one(of, box=name, part=part)["ratio"]) for name in ("periodic", "walls"))
        more = [
            p
            for p in sorted({float(row["part"]) for row in of})
            if float(one(of, box="walls", part=p)["ratio"]) > float(one(of, box="periodic", part=p)["ratio"])
        ]
        heat = "heats more" if walls > box else "heats no more"
        said.append(
            f"with {formula} a walled box {heat} than a periodic one at {_fraction(part)} of the step "
            f"({number(walls, 4)} against "
            f"{number(box, 4)} times the beginning; more at {len(more)} of {len({row['part'] for row in of})} "
            "timesteps)"
        )
    return (
        "- **Reflecting walls heat by themselves**: a particle that is put back inside lands where its neighbors did "
        "not push it. "
        "With velocity Verlet, which has no other source of heat where the step is short, " + "; ".join(said) + "."
    )


def _fraction(part: float) -> str:
    return "all" if part == 1 else f"1/{round(1 / part)}" if part < 1 else f"{part:g}"
