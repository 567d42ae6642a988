"""Where the recordings are, and the program that the wheel is compared with."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
RECORDINGS = sorted((ROOT / "recordings").glob("*.mcap"))
RECORDINGS = [path for path in RECORDINGS if not path.name.endswith(".estimate.mcap")]


@pytest.fixture
def program():
    """The path of `enact`, of the same revision: ENACT says it."""
    path = os.environ.get("ENACT")
    if path is None:
        pytest.skip("no ENACT: expected the path of the program")
    return path


@pytest.fixture(scope="session")
def recordings():
    return {path.stem: path for path in RECORDINGS}
