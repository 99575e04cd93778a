"""The parts of the benchmark, one module each: ``measure`` gives rows, ``render`` their part of the page."""

from __future__ import annotations

from validation.bench.sections import errors, features, isa, ratios, sizes, stages

#: In the order of the page. Each module has NAME, ``measure(plan, liquids)`` and ``render(rows)``.
SECTIONS = (ratios, sizes, errors, stages, features, isa)
