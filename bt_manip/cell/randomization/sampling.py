"""Drawing values by composer's variations, each from a stream of its own."""

import hashlib
from typing import Any

import numpy as np
from dm_control.composer import variation

Varied = Any
"""One of composer's variations, or a value that is always the same."""


def stream(seed: int, cycle: int, *key: str | int) -> np.random.RandomState:
    """Give what one thing's value is drawn from in one cycle of a run.

    It depends on nothing but these: neither on what else is drawn, nor on what was drawn before.

    Args:
        seed: Seed of the run.
        cycle: Number of the cycle.
        key: What the value is for.
    """
    return np.random.RandomState(np.random.MT19937(_sequence(seed, cycle, key)))


def generator(seed: int, *key: str | int) -> np.random.Generator:
    """Give the same for what is drawn once, before the first cycle.

    Args:
        seed: Seed of the run.
        key: What the values are for.
    """
    return np.random.Generator(np.random.PCG64(_sequence(seed, 0, ("at first", *key))))


def _sequence(seed: int, cycle: int, key: tuple[str | int, ...]) -> np.random.SeedSequence:
    digest = hashlib.sha256("\0".join(map(str, key)).encode()).digest()
    words = np.frombuffer(digest, "<u4").tolist()
    return np.random.SeedSequence(seed, spawn_key=(cycle, *words))


def draw(varied: Varied, nominal: Any, random_state: np.random.RandomState) -> Any:
    """Draw a value.

    Args:
        varied: What it is drawn by; composer's variations get the nominal value, too.
        nominal: The value without variation: a number or an array.
        random_state: What it is drawn from.

    Returns:
        A number or a list of numbers: plain data.
    """
    value = variation.evaluate(varied, nominal, nominal, random_state)
    numbers = np.asarray(value)
    return numbers.astype(int if numbers.dtype.kind in "iu" else float).tolist()
