"""Temporal ensembling of action chunks."""

from collections.abc import Sequence

import numpy as np

Chunks = Sequence[tuple[int, Sequence[Sequence[float]]]]
"""Predictions that overlap: the steps since each was made, and its actions, oldest first."""


def ensembled(chunks: Chunks, decay: float) -> list[float]:
    """Return the mean of what several predictions say about the present step.

    The i-th oldest prediction weighs ``exp(-decay i)`` (Zhao, Kumar, Levine and Finn 2023, Learning
    Fine-Grained Bimanual Manipulation with Low-Cost Hardware, section IV-B).

    Args:
        chunks: The predictions; those that do not reach the present step are left out.
        decay: The larger it is, the less recent predictions count.

    Returns:
        The action.  # (n,)
    """
    present = np.array([rows[age] for age, rows in chunks if age < len(rows)])
    weights = np.exp(-decay * np.arange(len(present)))
    return ((weights / weights.sum()) @ present).tolist()


def older(chunks: Chunks) -> list[tuple[int, Sequence[Sequence[float]]]]:
    """Return the predictions that still count in the next step."""
    return [(age + 1, rows) for age, rows in chunks if age + 1 < len(rows)]
