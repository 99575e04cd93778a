"""The progress bar: on a terminal it shows and leaves the thermo table whole; a pipe never sees it."""

from __future__ import annotations

import os
import pty
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest

from validation.octant_runner import find_binary

SCRIPT = """\
units lj
lattice fcc 0.8442
region box block 0 5 0 5 0 5
create_box 1 box
create_atoms 1 box
mass 1 1.0
velocity all create 3.0 87287
pair_style lj/cut 2.5
pair_coeff 1 1 1.0 1.0
fix 1 all nve
thermo 100
run ${steps}
"""

#: Enough that the bar has been drawn anew on any machine, and rows of the table between its head and the end.
STEPS = 20_000
ROWS = STEPS // 100 + 1

ESCAPE = re.compile(rb"\x1b\[[0-9;?]*[A-Za-z]")


def read_all(terminal: int) -> bytes:
    """Everything written to a terminal until its last writer has gone."""
    pieces = []
    while True:
        try:
            piece = os.read(terminal, 65536)
        except OSError:
            piece = b""
        if not piece:
            return b"".join(pieces)
        pieces.append(piece)


def pieces_of(seen: bytes) -> list[str]:
    """What stood on lines of the terminal: text between line ends and the escape sequences that move the cursor."""
    text = ESCAPE.sub(b"\r", seen).decode()
    return [piece.rstrip() for piece in re.split(r"[\r\n]+", text)]


def start(folder: Path, steps: int, **streams: int) -> subprocess.Popen[bytes]:
    (folder / "bar.in").write_text(SCRIPT)
    arguments = [find_binary(), "run", "bar.in", "-v", f"steps={steps}"]
    return subprocess.Popen(arguments, cwd=folder, stdin=subprocess.DEVNULL, **streams)


def table(text: str) -> list[str]:
    """Header and rows of the thermo table of a log."""
    lines = [line.rstrip() for line in text.splitlines()]
    first = next(k for k, line in enumerate(lines) if line.split()[:2] == ["Step", "Temp"])
    last = next(k for k, line in enumerate(lines) if line.startswith("Loop time of"))
    return lines[first:last]


def test_the_bar_shows_on_a_terminal_and_leaves_the_table_whole(tmp_path: Path) -> None:
    ours, theirs = pty.openpty()
    process = start(tmp_path, STEPS, stdout=theirs, stderr=theirs)
    os.close(theirs)
    seen = read_all(ours)
    assert process.wait() == 0
    shown = pieces_of(seen)
    assert any(re.search(rf"\d+/{STEPS} steps .* steps/s .* left", piece) for piece in shown)
    rows = table((tmp_path / "log.octant").read_text())
    assert len(rows) == 1 + ROWS
    assert [piece for piece in shown if piece in rows] == rows
    assert not any("left" in piece for piece in shown[-3:]), "the bar is still there at the end"
    assert "\x1b" not in (tmp_path / "log.octant").read_text()


def test_output_in_a_file_holds_no_trace_of_the_bar(tmp_path: Path) -> None:
    ours, theirs = pty.openpty()
    with open(tmp_path / "screen", "wb") as screen:
        process = start(tmp_path, STEPS, stdout=screen.fileno(), stderr=theirs)
        os.close(theirs)
        seen = read_all(ours)
    assert process.wait() == 0
    assert b"steps/s" in seen
    text = (tmp_path / "screen").read_text()
    assert "\x1b" not in text and "\r" not in text
    assert table(text) == table((tmp_path / "log.octant").read_text())


def test_a_pipe_sees_no_bar(tmp_path: Path) -> None:
    process = start(tmp_path, 500, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    out, error = process.communicate()
    assert process.returncode == 0
    assert error == b""
    assert b"\x1b" not in out and b"\r" not in out


@pytest.mark.parametrize("times", [1, 2])
def test_ctrl_c_on_a_terminal_takes_the_bar_away(tmp_path: Path, times: int) -> None:
    ours, theirs = pty.openpty()
    process = start(tmp_path, 100_000_000, stdout=theirs, stderr=theirs)
    os.close(theirs)
    time.sleep(1.0)
    for _ in range(times):
        process.send_signal(signal.SIGINT)
    seen = read_all(ours)
    assert process.wait() == 130
    if times == 1:
        shown = pieces_of(seen)
        rows = table((tmp_path / "log.octant").read_text())
        assert [piece for piece in shown if piece in rows] == rows
        assert any(piece.startswith("Interrupted: ") for piece in shown)
