from collections.abc import Callable
from pathlib import Path

import pytest


@pytest.fixture
def write(tmp_path) -> Callable[[str], Path]:
    """Write a scene file and return its path."""

    def write(text: str) -> Path:
        path = tmp_path / "scene.toml"
        path.write_text(text)
        return path

    return write
