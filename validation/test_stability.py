"""The page of the stability suite says what the checks say."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from validation import stability


def _row(value: object, bound: float, *, holds: bool, variant: str = "avx2", case: str = "a box") -> dict[str, Any]:
    return {
        "section": "stiff",
        "case": case,
        "backend": "cpu",
        "precision": "mixed",
        "variant": variant,
        "measured": f"error of {variant}",
        "value": value,
        "bound": bound,
        "holds": holds,
        "reason": "rounding",
    }


def test_a_line_shows_the_check_nearest_to_its_bound() -> None:
    rows = [_row(1.0, 4.0, holds=True), _row(3.0, 4.0, holds=True, variant="avx512"), _row(0.0, 0.0, holds=True)]
    (line,) = stability.lines_of(rows)
    assert (line.checks, line.measured, line.value) == (3, "error of avx512", 3.0)


def test_a_check_that_fails_is_never_behind_one_that_holds() -> None:
    rows = [_row(0.99, 1.0, holds=True), _row("NaN", 1.0, holds=False, variant="portable"), _row(0.999, 1.0, holds=True)]
    lines = stability.lines_of(rows)
    assert [line.holds for line in lines] == [False]
    text = stability.page(lines, [], "short form")
    assert "**fails**" in text and "**1 cases fail.**" in text


def test_a_test_that_is_not_there_fails() -> None:
    named = [one for one in stability.ELSEWHERE if one.suite == "precision"]
    verdicts = dict(stability.judge(f"test {named[0].test} ... ok\ntest {named[1].test} ... FAILED\n"))
    assert [verdicts[one] for one in named[:3]] == [stability.HOLDS, stability.FAILS, stability.FAILS]
    repeated = next(one for one in stability.ELSEWHERE if one.suite == "cuda_repeat")
    assert verdicts[repeated] == stability.NOT_RUN


def test_named_tests_exist() -> None:
    for one in stability.ELSEWHERE:
        text = (stability.ROOT / "tests" / f"{one.suite}.rs").read_text(encoding="utf-8")
        assert f"fn {one.test}(" in text, one


def test_rows_of_several_machines_share_the_page(tmp_path: Path) -> None:
    paths = [tmp_path / name for name in ("cpu", "gpu")]
    paths[0].write_text(json.dumps(_row(0.5, 1.0, holds=True)) + "\n", encoding="utf-8")
    paths[1].write_text(json.dumps(_row(0.5, 1.0, holds=True) | {"backend": "cuda"}) + "\n", encoding="utf-8")
    lines = stability.lines_of(stability.read_rows(paths))
    assert [line.backend for line in lines] == ["cpu", "cuda"]
