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
    named = [one for one in stability.ELSEWHERE if one.suite == "neighbors"]
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
    assert stability.read_origins(paths) == []


def test_kept_checks_say_where_they_are_from(tmp_path: Path) -> None:
    kept = [tmp_path / name for name in ("cpu", "gpu", "nowhere")]
    line = json.dumps(_row(0.5, 1.0, holds=True))
    texts = (f'{{"origin": "a machine, commit abc"}}\n{line}\n', f'{{"origin": "a card, commit abd"}}\n{line}\n', f"{line}\n")
    for path, text in zip(kept, texts, strict=True):
        path.write_text(text, encoding="utf-8")
    origins, rows = stability.read_origins(kept), stability.read_rows(kept)
    assert (origins, len(rows)) == (["a machine, commit abc", "a card, commit abd"], 3)
    page = stability.page(stability.lines_of(rows), [], "full form", origins=origins)
    assert "3 checks of 1 cases (full form) by `make stability`, a machine, commit abc; a card, commit abd. All hold." in page


def test_verdicts_of_a_gpu_stand_beside_those_of_here(tmp_path: Path) -> None:
    one = next(one for one in stability.ELSEWHERE if one.suite == "neighbors")
    repeated = next(one for one in stability.ELSEWHERE if one.suite == "cuda_repeat")
    logs = {"cuda_repeat": f"test {repeated.test} ... ok\n", "neighbors on cuda": f"test {one.test} ... FAILED\n"}
    about = {"card": "0: NVIDIA X1, compute capability 9.0", "driver": "580", "commit": "abc"}
    outcomes = [{"part": "tests", "name": name, "log": f"{name.split()[0]}.log"} for name in [*logs, "tail on cuda"]]
    (tmp_path / "summary.json").write_text(json.dumps(about | {"outcomes": outcomes}), encoding="utf-8")
    for name, text in logs.items():
        (tmp_path / f"{name.split()[0]}.log").write_text(text, encoding="utf-8")
    gpu = stability.read_gpu(tmp_path)
    assert gpu.where == "NVIDIA X1, driver 580, commit abc"
    here = [(one, stability.HOLDS), (repeated, stability.NOT_RUN)]
    text = stability.page([], here, "short form", gpu)
    assert f"{one.test} | {one.bound} | holds | **fails** |" in text
    assert f"{repeated.test} | {repeated.bound} | not run | holds |" in text
    assert "1 cases fail" in text and "not run | not run" not in text
    assert f"{repeated.test} | {repeated.bound} | not run | not run |" in stability.page([], here, "short form")


def test_a_test_that_was_skipped_on_a_gpu_was_not_run_there(tmp_path: Path) -> None:
    one = next(one for one in stability.ELSEWHERE if one.suite == "cuda_repeat")
    log = f"test {one.test} ... ok\n\nsuccesses:\n\n---- {one.test} stdout ----\nskipped: no CUDA device: none\n\nsuccesses:\n"
    about = {"card": "0: X", "driver": "1", "commit": "a", "outcomes": [{"part": "tests", "name": one.suite, "log": "x.log"}]}
    (tmp_path / "summary.json").write_text(json.dumps(about), encoding="utf-8")
    (tmp_path / "x.log").write_text(log, encoding="utf-8")
    assert stability.read_gpu(tmp_path).tests == {(one.suite, one.test): stability.NOT_RUN}
    assert dict(stability.judge(log))[one] == stability.NOT_RUN
