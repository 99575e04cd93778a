"""LAMMPS input scripts as lists of statements, and the changes that the comparison makes to them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

#: Statements that make or change atoms; a data file with the atoms takes their place.
SETUP = frozenset({"lattice", "region", "create_box", "create_atoms", "read_data", "mass", "velocity", "set"})

#: Statements that write something.
OUTPUT = frozenset(
    {"dump", "dump_modify", "undump", "write_data", "pair_write"}
    | {"thermo", "thermo_style", "thermo_modify", "log", "print"}
)


def statements(text: str) -> list[str]:
    """The statements of a script, without comments, with lines that end in ``&`` joined."""
    joined = text.replace("&\n", " ")
    lines = (line.split("#", 1)[0].strip() for line in joined.splitlines())
    return [line for line in lines if line]


def command(statement: str) -> str:
    """The command word of a statement."""
    return statement.split(None, 1)[0]


@dataclass(frozen=True)
class Script:
    """A script as its statements; every change gives a new script."""

    lines: tuple[str, ...]

    @classmethod
    def read(cls, path: Path) -> Script:
        """The script in a file."""
        return cls.of(path.read_text(encoding="utf-8"))

    @classmethod
    def of(cls, text: str) -> Script:
        """The script in a text."""
        return cls(tuple(statements(text)))

    def __str__(self) -> str:
        return "\n".join(self.lines) + "\n"

    def write(self, path: Path) -> Path:
        """Writes the script to a file and returns its path."""
        path.write_text(str(self), encoding="utf-8")
        return path

    def without(self, names: Iterable[str]) -> Script:
        """The script without these commands."""
        left_out = frozenset(names)
        return Script(tuple(line for line in self.lines if command(line) not in left_out))

    def silent(self) -> Script:
        """The script without anything that writes files or changes the thermo table."""
        return self.without(OUTPUT)

    def for_lammps(self) -> Script:
        """The script without octant's own commands: ``dump ID GROUP chemfiles`` and what refers to such a dump."""
        ours: set[str] = set()
        kept = []
        for line in self.lines:
            words = line.split()
            if words[0] == "dump" and len(words) > 3 and words[3] == "chemfiles":
                ours.add(words[1])
            elif not (words[0] in ("undump", "dump_modify") and len(words) > 1 and words[1] in ours):
                kept.append(line)
        return Script(tuple(kept))

    def until_run(self) -> Script:
        """Everything before the first ``run``."""
        for index, line in enumerate(self.lines):
            if command(line) == "run":
                return Script(self.lines[:index])
        return self

    def before_runs(self, *added: str) -> Script:
        """The script with statements put before every ``run``."""
        kept: list[str] = []
        for line in self.lines:
            if command(line) == "run":
                kept.extend(added)
            kept.append(line)
        return Script(tuple(kept))

    def then(self, *added: str) -> Script:
        """The script with statements at its end."""
        return Script(self.lines + added)

    def from_data(self, path: Path) -> Script:
        """The script with its atoms read from a data file: what makes atoms goes, groups and coefficients stay."""
        kept: list[str] = []
        read = False
        for line in self.lines:
            if command(line) in ("create_box", "read_data") and not read:
                kept.append(f"read_data {path}")
                read = True
            elif command(line) not in SETUP:
                kept.append(line)
        return Script(tuple(kept))
