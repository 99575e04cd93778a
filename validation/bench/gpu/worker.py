"""OpenMM in a process of its own, which keeps its contexts between legs.

As a program, ``CELLS PLATFORM MELTING CHECKED LEG``: melts the crystal in every precision, then answers each line of
standard input with a line of JSON, the rows of one leg each.
"""

from __future__ import annotations

import importlib.util
import json
import math
import os
import select
import subprocess
import sys
import time
from typing import Any

from validation.bench.gpu.plan import OPENMM, Plan
from validation.bench.gpu.tables import Row
from validation.bench.rounds import Absent
from validation.octant_runner import ROOT

#: Steps before a leg whose length is found out.
_PILOT = 100

#: Cells of the fcc lattice, in their edges.
_BASIS = ((0.0, 0.0, 0.0), (0.5, 0.5, 0.0), (0.5, 0.0, 0.5), (0.0, 0.5, 0.5))

_SEED = 87287


class Worker:
    """The process, asked leg by leg."""

    def __init__(self, cells: str, plan: Plan) -> None:
        if importlib.util.find_spec("openmm") is None:
            raise Absent("not installed")
        platform = "CUDA" if plan.backend == "cuda" else "CPU"
        atoms = len(_BASIS) * math.prod(map(int, cells.split("x")))
        words = [cells, platform, str(plan.melting), str(plan.checked_atoms(atoms)), str(plan.leg)]
        path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        self.process = subprocess.Popen(
            [sys.executable, "-m", "validation.bench.gpu.worker", *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": path},
        )

    def legs(self, limit: float) -> list[Row]:
        """A leg in every precision, within ``limit`` seconds."""
        assert self.process.stdin and self.process.stdout
        try:
            print("go", file=self.process.stdin, flush=True)
            ready, _, _ = select.select([self.process.stdout], [], [], limit)
            answer = self.process.stdout.readline() if ready else ""
        except BrokenPipeError:
            answer = ""
        if not answer:
            raise Absent("it ended, see above" if self.process.poll() is not None else "the time was up")
        answer = json.loads(answer)
        if "absent" in answer:
            raise Absent(answer["absent"])
        return answer["rows"]

    def close(self) -> None:
        """Ends the process."""
        self.process.kill()
        self.process.communicate()


def _crystal(cells: list[int]) -> tuple[Any, Any, Any]:
    """Edges, positions and velocities of the crystal that melts, center of mass at rest."""
    import numpy as np

    from validation.bench.liquid import DENSITY, TEMPERATURE

    edge = (len(_BASIS) / DENSITY) ** (1 / 3)
    corners = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), axis=-1).reshape(-1, 1, 3)
    positions = (edge * (corners + np.array(_BASIS))).reshape(-1, 3)
    velocities = np.random.default_rng(_SEED).normal(0.0, math.sqrt(TEMPERATURE), positions.shape)
    return edge * np.array(cells), positions, velocities - velocities.mean(axis=0)


class _Contexts:
    """The liquid in every precision of a platform."""

    def __init__(self, cells: str, platform: str, melting: int, checked: int, leg: float) -> None:
        import openmm

        from validation.bench import openmm_peer

        self.platform, self.melting, self.checked, self.leg = platform, melting, checked, leg
        self.lengths, positions, velocities = _crystal([int(n) for n in cells.split("x")])
        self.atoms, self.version = len(positions), openmm.__version__
        made = openmm_peer.system(self.lengths, self.atoms)
        # The CPU platform has one precision only.
        settings = {name: {"Precision": name} for name in OPENMM} if platform == "CUDA" else {"single": {}}
        self.contexts, self.errors, self.steps = {}, {}, {}
        for name, properties in settings.items():
            begun = openmm_peer.context(made, platform, properties, positions, velocities)
            begun.getIntegrator().step(melting)
            self.contexts[name], self.errors[name] = begun, self._errors(begun)
            self.steps[name] = max(_PILOT, round(leg * _PILOT / self._seconds(begun, _PILOT)))

    def _errors(self, context) -> tuple[float, float]:
        """Force error of some atoms over their RMS force: RMS, and that of the worst."""
        import numpy as np

        from validation.bench.openmm_peer import forces_of
        from validation.bench.reference import all_pairs

        state = context.getState(getPositions=True, getForces=True)
        positions = state.getPositions(asNumpy=True)._value
        chosen = np.sort(np.random.default_rng(_SEED).choice(self.atoms, self.checked, replace=False))
        bounds = np.stack([np.zeros(3), self.lengths], axis=1)
        exact = all_pairs(positions, bounds, chosen).forces
        off = ((forces_of(state)[chosen] - exact) ** 2).sum(axis=1)
        scale = (exact**2).sum(axis=1).mean()
        return float(np.sqrt(off.mean() / scale)), float(np.sqrt(off.max() / scale))

    def _seconds(self, context, steps: int) -> float:
        """Wall time of steps. Asking for an energy waits for the device, and takes about a step itself."""
        context.getState(getEnergy=True)
        started = time.perf_counter()
        context.getIntegrator().step(steps)
        context.getState(getEnergy=True)
        return time.perf_counter() - started

    def rows(self) -> list[Row]:
        """A leg in every precision."""
        rows = []
        for name, context in self.contexts.items():
            rate = self.steps[name] / self._seconds(context, self.steps[name])
            rms, worst = self.errors[name]
            cells = {
                "program": "OpenMM",
                "version": self.version,
                "platform": self.platform,
                "precision": name,
                "atoms": self.atoms,
                "melted": self.melting,
                "steps": self.steps[name],
                "steps_per_s": f"{rate:.6g}",
                "matom_steps_per_s": f"{rate * self.atoms * 1e-6:.6g}",
                "force_error_rms": f"{rms:.6g}",
                "force_error_worst": f"{worst:.6g}",
                "sampled_atoms": self.checked,
            }
            rows.append({column: str(cell) for column, cell in cells.items()})
        return rows


def main() -> None:
    """Answers until standard input ends."""
    cells, platform, melting, checked, leg = sys.argv[1:]
    contexts: _Contexts | None = None
    for _ in sys.stdin:
        try:
            contexts = contexts or _Contexts(cells, platform, int(melting), int(checked), float(leg))
            answer: dict[str, Any] = {"rows": contexts.rows()}
        except Exception as error:
            # Whatever OpenMM lacks here (its plugin, a library, memory), the reason goes on.
            answer = {"absent": " ".join(str(error).split())[:300]}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
