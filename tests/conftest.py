"""What every test file shares: the real anatomies, which are optional."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

DATA_FOLDER = Path(
    os.environ.get("SDFSTENT_DATA", Path(__file__).resolve().parents[2] / "shared" / "data")
)


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of real anatomies; tests that need it skip, saying so, where it is absent."""
    if not (DATA_FOLDER / "pulmonary_surface_cm.vtp").is_file():
        pytest.skip(f"real anatomies not found in {DATA_FOLDER}; set SDFSTENT_DATA to their folder")
    return DATA_FOLDER
