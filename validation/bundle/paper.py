"""The experiments of the paper: ``octant paper``, CSV files of it in the folder ``paper`` of the results.

Figures and verdict are made of them where there is matplotlib: ``python -m validation.paper results/paper``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from validation.bundle.device import Device
from validation.bundle.outcome import FAILED, PASSED, SKIPPED, Outcome, call

#: Seconds, unless others are asked for. What is cut off leaves the rows so far, the largest sizes come last, and the verdict is
#: on the sizes that are whole.
LIMIT = 290.0

#: The paper's sizes and two that a GPU is made for.
SIZES = (1_000, 2_000, 5_000, 10_000, 20_000, 50_000, 100_000, 200_000, 1_000_000, 10_000_000)

#: Rounds of each time.
ROUNDS = 3


def run(
    root: Path,
    results: Path,
    scratch: Path,
    environment: Mapping[str, str],
    device: Device,
    backend: str,
    limit: float,
    sizes: Sequence[int],
    quick: bool,
) -> Iterator[Outcome]:
    """Measures on the engine under test."""
    name = "octant paper"
    if backend == "cuda" and not device.present:
        yield Outcome("paper", name, SKIPPED, device.missing)
        return
    words: list[str | Path] = [root / "bin" / "octant", "paper", "--backend", backend, "--out", results / "paper"]
    words += ["--quick"] if quick else ["--rounds", str(ROUNDS)]
    if sizes or not quick:
        words += ["--sizes", ",".join(map(str, sizes or SIZES))]
    done = call(words, results / "paper.log", environment, limit, scratch)
    wrong = "did not end in time" if done.status is None else "".join(done.output.splitlines()[-1:])
    verdict = PASSED if done.status == 0 else FAILED
    yield Outcome("paper", name, verdict, "" if verdict == PASSED else wrong, seconds=done.seconds, log="paper.log")
