"""Shared by the tests."""

from __future__ import annotations

import pytest

from validation.octant_runner import find_binary


def pytest_report_header() -> str:
    """Names the binary under test, or says how to build it."""
    try:
        return f"octant binary: {find_binary()}"
    except FileNotFoundError as error:
        raise pytest.UsageError(str(error)) from None
