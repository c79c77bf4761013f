from __future__ import annotations

from pathlib import Path

import pytest

from tests.capture.cleaning.grid import Grid


@pytest.fixture(scope="session")
def grid(shared_data: Path) -> Grid:
    return Grid(shared_data)
