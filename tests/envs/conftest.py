"""Environments of trees; skipped where Gymnasium is not installed."""

import pytest

pytest.importorskip("gymnasium", reason="Gymnasium is not installed: bt-manip[learn]")
