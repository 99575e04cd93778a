"""The README's words, run."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

from validation.octant_runner import ROOT, call

README = (ROOT / "README.md").read_text(encoding="utf-8")


def block_after(heading: str) -> list[str]:
    """The lines of the first shell block below a heading."""
    found = re.search(rf"^## {re.escape(heading)}\n.*?^```sh\n(.*?)^```", README, re.MULTILINE | re.DOTALL)
    assert found, f"no shell block below {heading!r}"
    return found.group(1).splitlines()


def test_install_to_plot_in_ten_lines(tmp_path: Path) -> None:
    """The block as it stands, but for its first line: a smaller scene by the binary that is there already."""
    lines = block_after("From install to a plotted trajectory")
    assert len(lines) <= 10
    assert lines[0].split("#")[0].strip() == "make run"
    (tmp_path / "output").mkdir()
    done = call("run", ROOT / "inputs" / "melt.in", "-v", "out=output", "-v", "size=6", "-v", "steps=100", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    (tmp_path / ".venv" / "bin").mkdir(parents=True)
    (tmp_path / ".venv" / "bin" / "python").write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    (tmp_path / ".venv" / "bin" / "python").chmod(0o755)
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    subprocess.run(["sh", "-e", "-c", "\n".join(lines[1:])], cwd=tmp_path, env=environment, check=True)
    assert (tmp_path / "output" / "melt.png").stat().st_size > 5_000


def test_two_commands() -> None:
    targets = [line.split("#")[0].strip() for line in block_after("Two commands")]
    assert targets == ["make run", "make test"]
    for target in targets:
        subprocess.run([*target.split(), "--dry-run"], cwd=ROOT, capture_output=True, check=True)


def test_links_lead_somewhere() -> None:
    for link in re.findall(r"\]\(((?!https?:)[^)#]+)\)", README):
        # The results are written by `make validate`.
        assert (ROOT / link).exists() or link.startswith("validation/results/"), link


def test_ci_runs_the_two_commands() -> None:
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert os.access(ROOT / ".ci" / "run", os.X_OK)
    assert "make" in script and "test" in script and "run" in script
