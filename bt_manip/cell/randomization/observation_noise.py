"""Noise and delay of observables."""

from collections.abc import Callable
from typing import Any

import numpy as np
from dm_control import composer
from dm_control.composer import variation
from dm_control.composer.variation import noises

from bt_manip.exceptions import did_you_mean

from ..exceptions import CellError
from .sampling import Varied
from .variations import Clipped


def add_noise_and_delay(
    entity: composer.Entity, name: str, *, noise: Varied = None, delay: float | None = None
) -> None:
    """Set noise and delay of an entity's observable, by composer's corruptor and delay.

    Args:
        entity: The entity.
        name: Name of the observable.
        noise: Sampled for each observation. Variations that use the value (``plus``, ``times``:
            composer's ``noises``) replace the observation, all others are added to it.
        delay: Number of steps.

    Raises:
        CellError: If the entity has no such observable, or the delay is not a number of steps.
    """
    known = entity.observables.as_dict(fully_qualified=False)
    if name not in known:
        near = did_you_mean(name, known)
        raise CellError(f"'{entity.mjcf_model.model}' has no observable '{name}'{near}")
    observable = known[name]
    if delay is not None:
        if delay < 0 or delay != round(delay):
            raise CellError(f"the delay of '{name}' is a number of steps, got {delay:g}")
        observable.delay = round(delay)
    if noise is not None:
        observable.corruptor = _corruptor(noise)


def _corruptor(noise: Varied) -> Callable[..., np.ndarray]:
    replaces = _uses_value(noise)

    def corrupt(value: Any, random_state: np.random.RandomState) -> np.ndarray:
        sampled = variation.evaluate(noise, value, value, random_state)
        return np.asarray(sampled if replaces else value + sampled)

    return corrupt


def _uses_value(noise: Varied) -> bool:
    if isinstance(noise, Clipped):
        return _uses_value(noise.varied)
    return isinstance(noise, noises.Additive | noises.Multiplicative)
