"""What the files of ``octant paper`` consist of: what tells rows apart, and which of them are judged together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product

Row = dict[str, str]
Cells = tuple[str, ...]


class Unfit(ValueError):
    """A file from which nothing can be judged; the message says why."""


@dataclass(frozen=True)
class Layout:
    """Rows that belong together have the same cells in the columns ``group``, and differ in those in ``member``."""

    group: Cells
    member: Cells
    #: Members that a group must have; by its first cell where that decides it, under "" elsewhere. Others must be there where
    #: another group has them.
    needed: dict[str, frozenset[Cells]] = field(default_factory=dict)
    #: Members that some groups have not.
    optional: frozenset[Cells] = frozenset()
    #: Whether each cell of a column of ``member`` is to be there with each of the others.
    crossed: bool = False
    #: Groups without which the others say nothing.
    groups: frozenset[Cells] = frozenset()

    def needs(self, group: Cells) -> frozenset[Cells]:
        """Members of a group that are judged by name."""
        return self.needed.get(group[0] if group else "", self.needed.get("", frozenset()))


def _names(*names: str) -> frozenset[Cells]:
    return frozenset((name,) for name in names)


_STANDARD = ("standard:0.5", "standard", "standard:2", "standard:2.52", "standard:4")
_OCTANT = ("octant", "octant:2.52", "octant:4", "trimmed", "midplane", "midplane:4")
_ORDERED = ("standard", "standard:2", "octant", "trimmed")
_DIRECTIONS = [("own", "0"), *product("XYZ", "12"), ("XY", "5"), ("XY", "8"), ("XYZ", "17"), ("XYZ", "26")]
_INTEGRATORS = ("nve/euler2", "nve")

#: By the names of the files.
LAYOUTS = {
    "table1": Layout(("particles",), ()),
    "later": Layout(("particles",), ("force", "step"), {"": frozenset({("spring", "0"), ("inverse", "0")})}, crossed=True),
    "stability": Layout(
        ("system", "part"),
        ("force", "box", "integrator"),
        {
            "pair": frozenset(product(("spring",), ("periodic",), _INTEGRATORS)),
            "gas": frozenset(product(("spring", "inverse"), ("periodic", "walls"), _INTEGRATORS)),
        },
        groups=frozenset({("pair", "1"), ("gas", "1")}),
    ),
    "figure4": Layout((), ("direction", "adjacent_cells"), {"": frozenset(_DIRECTIONS)}),
    "orders": Layout(
        ("particles",), ("search",), {"": _names(*_ORDERED, *(f"{search}+zorder" for search in _ORDERED))}
    ),
    "distributions": Layout(("distribution",), ("search",), {"": _names("standard", "octant")}),
    "figure5": Layout(("particles",), ("search",), {"": _names(*_STANDARD, *_OCTANT)}, optional=_names("brute")),
}


def whole(layout: Layout, rows: Sequence[Row]) -> tuple[list[Row], str]:
    """The rows of groups that are whole, and in words what was left out. Unfit where nothing is, or a row is there twice."""
    columns = (*layout.group, *layout.member)
    if not rows:
        raise Unfit("there are no rows in it")
    if missing := [name for name in columns if name not in rows[0]]:
        raise Unfit(f"there is no column {missing[0]!r} in it")
    found: dict[Cells, set[Cells]] = {}
    for row in rows:
        group, member = _cells(row, layout.group), _cells(row, layout.member)
        members = found.setdefault(group, set())
        if member in members:
            raise Unfit(f"two rows are of {_said(columns, group + member)}; each is to be measured once")
        members.add(member)
    lacking = {group: _lacking(layout, found, group) for group in found}
    fine = {group for group, lacks in lacking.items() if not lacks}
    if not fine or not layout.groups <= fine:
        group = min(layout.groups - fine or lacking, key=lambda of: (of not in lacking, len(lacking.get(of, ()))))
        lacks = sorted(lacking.get(group) or layout.needs(group))
        of = f" {_said(layout.group, group)}" if group else ""
        others = f" and {len(lacks) - 1} others" if len(lacks) > 1 else ""
        raise Unfit(f"it was cut off: there is no row of{of} {_said(layout.member, lacks[0])}{others}")
    kept = [row for row in rows if _cells(row, layout.group) in fine]
    out = [f"{_said(layout.group, group)}" for group in found if group not in fine]
    return kept, f"{'; '.join(out)} left out ({len(rows) - len(kept)} of {len(rows)} rows)" if out else ""


def _lacking(layout: Layout, found: dict[Cells, set[Cells]], group: Cells) -> frozenset[Cells]:
    """Members that are named, or that another group of the kind has."""
    kind = group[:1] if group and group[0] in layout.needed else ()
    alike = [members for other, members in found.items() if other[: len(kind)] == kind]
    wanted = layout.needs(group) | frozenset().union(*alike)
    if layout.crossed:
        wanted = frozenset(product(*(sorted(set(cells)) for cells in zip(*wanted, strict=True))))
    return wanted - layout.optional - found[group]


def _cells(row: Row, columns: Cells) -> Cells:
    return tuple(row[name] for name in columns)


def _said(columns: Cells, cells: Cells) -> str:
    return ", ".join(f"{name} {cell}" for name, cell in zip(columns, cells, strict=True))
