"""Sampling of composer's variations, each from a random stream of its own."""

import hashlib
from typing import Any

import numpy as np
from dm_control.composer import variation

Varied = Any
"""One of composer's variations, or a constant."""


def stream(seed: int, cycle: int, *key: str | int) -> np.random.RandomState:
    """Return the random stream of one value in one cycle of a run.

    It depends on nothing else: neither on which other values vary, nor on earlier samples.

    Args:
        seed: Seed of the run.
        cycle: Number of the cycle.
        key: What the value is for.
    """
    return np.random.RandomState(np.random.MT19937(_sequence(seed, cycle, key)))


def generator(seed: int, *key: str | int) -> np.random.Generator:
    """Return the random generator of values that are sampled once, before the first cycle.

    Args:
        seed: Seed of the run.
        key: What the values are for.
    """
    return np.random.Generator(np.random.PCG64(_sequence(seed, 0, ("at first", *key))))


def _sequence(seed: int, cycle: int, key: tuple[str | int, ...]) -> np.random.SeedSequence:
    digest = hashlib.sha256("\0".join(map(str, key)).encode()).digest()
    words = np.frombuffer(digest, "<u4").tolist()
    return np.random.SeedSequence(seed, spawn_key=(cycle, *words))


def sample(varied: Varied, nominal: Any, random_state: np.random.RandomState) -> Any:
    """Sample a value as plain data: a number or a list of numbers.

    Args:
        varied: The variation; composer's variations get the nominal value too.
        nominal: The value without variation: a number or an array.
        random_state: The random stream.
    """
    value = variation.evaluate(varied, nominal, nominal, random_state)
    numbers = np.asarray(value)
    return numbers.astype(int if numbers.dtype.kind in "iu" else float).tolist()
