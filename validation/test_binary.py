"""What the compiler made of the vector code."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from validation.octant_runner import find_binary


@pytest.mark.skipif(shutil.which("nm") is None, reason="there is no nm")
def test_no_vector_instruction_is_a_call() -> None:
    """An intrinsic that was not inlined is called instead, at ten times its cost: code around it lacks ``inline(always)``,
    or is a closure that the compiler left alone."""
    symbols = subprocess.run(["nm", "-C", find_binary()], capture_output=True, text=True, check=True).stdout
    calls = [line.split("core::core_arch::", 1)[1] for line in symbols.splitlines() if "core::core_arch::" in line]
    assert [name for name in calls if "_mm" in name] == []
