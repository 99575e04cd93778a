"""How much is measured: sizes, rounds, lengths of runs."""

from __future__ import annotations

from dataclasses import dataclass

#: Arithmetic of octant, the most exact first.
MODES = ("double", "mixed", "single")

#: Speed over LAMMPS that a mode is asked to reach, by mode and whether it runs on one core.
ASKED_SPEED = {("double", True): 2.0, ("double", False): 2.0, ("mixed", True): 4.0, ("mixed", False): 4.0}

#: Largest deviation of the cost of an atom-step from that of the main size that counts as a linear cost.
ASKED_LINEAR = 0.15


@dataclass(frozen=True)
class Plan:
    """The lengths of everything; the defaults are those of the results in the repository."""

    #: Rounds in which every contestant runs once.
    rounds: int = 7
    #: Edges of the box in fcc cells; a box holds four atoms a cell.
    sizes: tuple[int, ...] = (10, 20, 40, 63)
    #: The size at which programs, features and instruction sets are compared.
    main: int = 20
    #: Threads of the runs on all cores.
    threads: int = 2
    #: Steps before anything is timed.
    melting: int = 1000
    #: A timed run is about this many atom-steps long ...
    atom_steps: float = 6.4e6
    #: ... but at least this many steps: two lists are built in them.
    least_steps: int = 40
    #: Size and length of the runs that show the drift of the energy.
    drift_size: int = 10
    drift_steps: int = 10_000
    #: Up to this many atoms the force error is that of all; of larger liquids it is that of a sample.
    all_atoms: int = 40_000
    sampled_atoms: int = 2_000
    #: Cycles a list entry that the pair loop cannot go below, by mode, where known.
    floors: tuple[tuple[str, float], ...] = ()

    @classmethod
    def quick(cls, threads: int) -> Plan:
        """Seconds instead of an hour: shows that everything works, its numbers are worth nothing."""
        return cls(
            rounds=3,
            sizes=(5, 10),
            main=10,
            threads=threads,
            melting=200,
            atom_steps=1.6e5,
            drift_size=5,
            drift_steps=500,
            all_atoms=2_000,
            sampled_atoms=200,
        )

    def steps(self, size: int) -> int:
        """Length of a timed run: a multiple of 20, so that each list is used in full."""
        wanted = max(self.least_steps, self.atom_steps / atoms(size))
        return 20 * max(1, round(wanted / 20))

    @property
    def thread_counts(self) -> tuple[int, ...]:
        """One core, and all of them."""
        return (1,) if self.threads == 1 else (1, self.threads)

    def floor(self, mode: str) -> float | None:
        """The given floor of a mode, cycles a list entry."""
        return dict(self.floors).get(mode)


def atoms(size: int) -> int:
    """Atoms of a box of ``size`` fcc cells an edge."""
    return 4 * size**3
