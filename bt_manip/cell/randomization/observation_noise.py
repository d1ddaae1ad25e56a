"""Observables that are noisy and late."""

from collections.abc import Callable
from typing import Any

import numpy as np
from dm_control import composer
from dm_control.composer import variation
from dm_control.composer.variation import noises

from bt_manip.exceptions import did_you_mean

from ..exceptions import CellError
from .sampling import Varied
from .variations import Within


def observe_with(
    entity: composer.Entity, name: str, *, noise: Varied = None, delay: float | None = None
) -> None:
    """Let an observable of an entity be noisy and late, by composer's means.

    Args:
        entity: The entity.
        name: Name of the observable.
        noise: Drawn for each observation. What wants the value itself (``plus``, ``times``:
            composer's ``noises``) gives the observation, everything else is added to it.
        delay: How many steps late it is.

    Raises:
        CellError: When the entity has no such observable, or there is no such delay.
    """
    known = entity.observables.as_dict(fully_qualified=False)
    if name not in known:
        raise CellError(
            f"'{entity.mjcf_model.model}' has no observable '{name}'{did_you_mean(name, known)}"
        )
    observable = known[name]
    if delay is not None:
        if delay < 0 or delay != round(delay):
            raise CellError(f"the delay of '{name}' is a number of steps, got {delay:g}")
        observable.delay = round(delay)
    if noise is not None:
        observable.corruptor = _corruptor(noise)


def _corruptor(noise: Varied) -> Callable[..., np.ndarray]:
    whole = _wants_value(noise)

    def corrupt(value: Any, random_state: np.random.RandomState) -> np.ndarray:
        drawn = variation.evaluate(noise, value, value, random_state)
        return np.asarray(drawn if whole else value + drawn)

    return corrupt


def _wants_value(noise: Varied) -> bool:
    if isinstance(noise, Within):
        return _wants_value(noise.varied)
    return isinstance(noise, noises.Additive | noises.Multiplicative)
