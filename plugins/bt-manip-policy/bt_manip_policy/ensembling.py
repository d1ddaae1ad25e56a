"""Temporal ensembling of action chunks."""

from collections.abc import Sequence

import numpy as np

Chunks = Sequence[tuple[int, Sequence[Sequence[float]]]]
"""Overlapping predictions, oldest first: the steps since the prediction, and its actions."""


def ensembled(chunks: Chunks, decay: float) -> list[float]:
    """Return the weighted mean of several predictions for the present step.

    The i-th oldest prediction weighs ``exp(-decay i)`` (Zhao, Kumar, Levine and Finn 2023, Learning
    Fine-Grained Bimanual Manipulation with Low-Cost Hardware, section IV-B).

    Args:
        chunks: The predictions; those that do not reach the present step are ignored.
        decay: Decay of the weights; with larger values, recent predictions count less.

    Returns:
        The action.  # (n,)
    """
    present = np.array([rows[age] for age, rows in chunks if age < len(rows)])
    weights = np.exp(-decay * np.arange(len(present)))
    return ((weights / weights.sum()) @ present).tolist()


def older(chunks: Chunks) -> list[tuple[int, Sequence[Sequence[float]]]]:
    """Return the predictions that reach the next step."""
    return [(age + 1, rows) for age, rows in chunks if age + 1 < len(rows)]
