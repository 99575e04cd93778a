"""Labels beside markers that overlap neither each other nor a marker."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from matplotlib.axes import Axes
from matplotlib.text import Text
from matplotlib.transforms import Bbox

#: Half the width of a marker with some air, points.
_MARKER = 5.0

#: Half the width of a line with some air, points.
_LINE = 2.0

#: Directions in the order in which they are tried, degrees, and distances, points.
_DIRECTIONS = (0, 180, 40, -40, 140, -140, 90, -90)
_DISTANCES = (9.0, 12.0, 18.0, 28.0, 40.0, 55.0)


def place_labels(
    panel: Axes,
    points: Sequence[tuple[float, float, str, str]],
    lines: Sequence[Sequence[tuple[float, float]]] = (),
) -> None:
    """Writes a label for each point ``(x, y, text, color)``, with a thin line to those that do not fit right beside it.

    ``lines`` are drawn already, each by its corners, along the axes from one to the next; labels keep off them too.
    """
    renderer = panel.figure.canvas.get_renderer()
    scale = panel.figure.dpi / 72
    inside = panel.get_window_extent(renderer)
    marks = [panel.transData.transform((x, y)) for x, y, _, _ in points]
    taken = [Bbox.from_bounds(x - _MARKER * scale, y - _MARKER * scale, *[2 * _MARKER * scale] * 2) for x, y in marks]
    for line in lines:
        corners = [panel.transData.transform(corner) for corner in line]
        taken += [_around(a, b, _LINE * scale) for a, b in pairwise(corners)]
    # From the top down.
    for x, y, text, color in sorted(points, key=lambda point: -point[1]):
        best = None
        for distance in _DISTANCES:
            for direction in _DIRECTIONS:
                offset = _offset(distance, direction)
                label = panel.annotate(
                    text,
                    (x, y),
                    offset,
                    textcoords="offset points",
                    color=color,
                    fontsize=8.5,
                    ha="left" if offset[0] > 1 else "right" if offset[0] < -1 else "center",
                    va="center",
                    arrowprops={"arrowstyle": "-", "lw": 0.6, "color": "0.6", "shrinkB": 5} if distance > 13 else None,
                )
                label.update_positions(renderer)
                # The box of the words alone: that of an annotation includes its line.
                box = Text.get_window_extent(label, renderer)
                clash = sum(_common(box, other) for other in taken) + _outside(box, inside)
                if best is None or clash < best[0]:
                    if best:
                        best[1].remove()
                    best = (clash, label, box)
                else:
                    label.remove()
                if clash == 0:
                    break
            if best and best[0] == 0:
                break
        taken.append(best[2])


def _around(one: Sequence[float], other: Sequence[float], margin: float) -> Bbox:
    """The box around the line between two places."""
    (left, right), (low, high) = sorted((one[0], other[0])), sorted((one[1], other[1]))
    return Bbox.from_extents(left - margin, low - margin, right + margin, high + margin)


def _offset(distance: float, direction: float) -> tuple[float, float]:
    angle = math.radians(direction)
    return distance * math.cos(angle), distance * math.sin(angle)


def _common(one: Bbox, other: Bbox) -> float:
    """The area that two boxes share."""
    common = Bbox.intersection(one, other)
    return common.width * common.height if common else 0.0


def _outside(box: Bbox, frame: Bbox) -> float:
    """The area of a box outside a frame."""
    return box.width * box.height - _common(box, frame)
