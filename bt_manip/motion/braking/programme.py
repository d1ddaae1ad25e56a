"""Halts that linear programmes find, where the joints' limits of jerk get in each other's way.

Near a clock the limits are linear in what another one differs from it by. So the one that is best
is the answer of a linear programme; going there, or part of the way, and linearising again leads to
a clock that keeps the limits themselves. This takes a hundred times what `halting` takes, and finds
a way where that finds none: it knows which jerk to save because another joint will need it later.
"""

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np

from bt_manip.robots import RobotModel

from ..jerk_profile import JerkProfile
from .clock import Clock
from .clock_limits import Curve, State
from .linear_programme import Aim, Wanted, solved
from .near_clock import CLOSE, ROUNDING, NearClock
from .rows import Looks, Rows
from .stretches import Stretches, stretched

COARSE, FINE = 60, 120  # steps of a clock that is looked for, and of one that is driven
HORIZONS = (2.5, 4.0)  # times the least time to rest: within which a clock shall rest
EFFORT = 0.998  # of what is allowed: it is not looked at everywhere
ROUGH = 0.02  # excess over the limits of a clock that is of use
PROGRAMMES = 60  # for one clock, at the most
PARTS = (1.0, 0.5, 0.25)  # of the way to the answer of a programme
FAR, NEAREST = 0.3, 2e-3  # how much a programme may change, as a share of what there is
NEARER, FARTHER = 0.2, 3.0  # times that, after an answer that was not better, or was
ASTRAY = 4  # answers that may be worse than the best, one after the other
PENALTY = 1000.0  # of exceeding the limits by all they are, in mean paces
GAIN = 3e-3  # in mean paces, below which another programme is not worth it
STRICT = 1e6  # [s] penalty: a millionth of the limits may be worth a fifth of the time
SHORTER = 1e-4  # of the least time: gaining less, another programme is not worth it
ROUNDS = 10  # of looking within the steps
RESTING = 2e-3  # of the greatest pace


def programmed_halt(
    curve: Curve, state: State, least: float, left: float, model: RobotModel, allowed: float
) -> JerkProfile | None:
    """Bring a clock to rest as early as linear programmes find a way.

    At first the limits are looked at roughly, at equal times: that shows the way. Then closely, at
    the corners of the curve and wherever a limit is exceeded, until nothing takes less time.

    Args:
        curve: What the clock goes through.
        state: Its reading, its pace and the pace's change.
        least: A time that no halt can be below [s].
        left: One that it has to be below [s].
        model: The arm with its payload.
        allowed: Fraction of the limits of effort that may be used.

    Returns:
        A clock that keeps the limits as far as the programmes look; None where none is found.
    """
    near = NearClock(curve, state, model, EFFORT * allowed)
    if not near.begins_inside:
        return None
    for horizon in HORIZONS:
        coarse = _Coarse(near, min(horizon * least, left))
        coarse.improve(GAIN)
        if coarse.now.excess > ROUGH:
            continue
        fine = _Fine(near, coarse.rested())
        for _ in range(ROUNDS):
            fine.improve(SHORTER * least)
            if fine.now.excess > ROUGH or fine.now.clock.t[-1] >= left:
                break
            if fine.found_beyond():
                continue
            if fine.now.excess <= CLOSE - ROUNDING:
                return fine.now.clock.profile()
            break
    return None


class _Looked(NamedTuple):
    """A clock that was looked at.

    Attributes:
        clock: The clock.
        rows: The limits near it.
        excess: The greatest share of a limit that it uses beyond all of it.
    """

    clock: Clock
    rows: list[Rows]
    excess: float


class _Search(ABC):
    """A clock that comes nearer to what is wanted, programme by programme.

    Attributes:
        now: The clock.
    """

    now: _Looked

    def __init__(self, near: NearClock) -> None:
        self._near, self._left = near, PROGRAMMES

    @abstractmethod
    def _cost(self, looked: _Looked) -> float:
        """Give what a clock costs."""

    @abstractmethod
    def _limits(self, clock: Clock) -> list[Rows]:
        """Give the limits near a clock."""

    @abstractmethod
    def _aim(self) -> Aim:
        """Give what the clock shall become."""

    @abstractmethod
    def _changed(self, before: Clock, wanted: Wanted, part: float) -> Clock | None:
        """Give a clock that is part of the way farther than another; None where there is none."""

    def improve(self, gain: float) -> None:
        """Solve programmes until one promises less than some gain.

        Where no part of the way to an answer is better, one is looked for that is nearer. Where
        that does not help either, all of the way is gone nevertheless: from there the next answers
        may lead to something that is better.
        """
        best, cost, reach, astray = self.now, self._cost(self.now), FAR, 0
        while self._left > 0:
            self._left -= 1
            aim, before = self._aim(), self.now
            aim = aim._replace(reach=reach)
            wanted = solved(before.clock, before.rows, self._near.curve.end, aim)
            if wanted is None or aim.penalty * before.excess - wanted.cost < gain:
                break
            self._go(before.clock, wanted, cost, (1.0,) if astray else PARTS)
            if self._cost(self.now) < cost:
                self._moved()
                best, cost = self.now, self._cost(self.now)
                reach, astray = min(FAR, FARTHER * reach), 0
            elif astray == 0:
                self.now = best
                reach *= NEARER
                if reach < NEAREST:
                    reach, astray = FAR, 1
            elif astray < ASTRAY:
                astray += 1
            else:
                break
        self.now = best

    def _go(self, before: Clock, wanted: Wanted, cost: float, parts: tuple[float, ...]) -> None:
        """Go the first part of the way from a clock to an answer that costs less, or the last."""
        for part in parts:
            clock = self._changed(before, wanted, part)
            if clock is not None:
                self.now = self._look(clock)
                if self._cost(self.now) < cost:
                    return

    @abstractmethod
    def _moved(self) -> None:
        """Look what else is different with another clock."""

    def _look(self, clock: Clock) -> _Looked:
        rows = self._limits(clock)
        used = max(float((np.abs(limit.value) / limit.most).max()) for limit in rows)
        off = max(-float(clock.p.min()), abs(float(clock.p[-1]))) / self._near.pace
        beyond = float(clock.s[-1]) / self._near.curve.end - 1.0
        return _Looked(clock, rows, max(0.0, used - 1.0, off, beyond))


class _Coarse(_Search):
    """A clock with equal steps that travels as little as it can."""

    def __init__(self, near: NearClock, end: float) -> None:
        """Begin with changes that go like half a sine, until some time [s]."""
        super().__init__(near)
        half_a_sine = -np.sin(np.linspace(0.0, np.pi, COARSE + 1))
        steps = np.full(COARSE, end / COARSE)
        clock = Clock.braking_all(near.state, steps, half_a_sine, np.zeros(COARSE))
        weights = np.gradient(clock.t) * clock.t  # the later it travels, the worse
        self._late = weights / (near.pace * weights.sum())
        self.now = self._look(clock)

    def rested(self) -> Clock:
        """Give the clock until it nearly rests, when it shall rest."""
        clock = self.now.clock
        moving = np.flatnonzero(clock.p >= RESTING * self._near.pace)
        n = min(int(moving.max(initial=1)) + 1, COARSE)
        return Clock.braking_all(self._near.state, clock.h[:n], clock.u[: n + 1], clock.bow[:n])

    def _cost(self, looked: _Looked) -> float:
        return PENALTY * looked.excess + float(self._late @ looked.clock.p)

    def _limits(self, clock: Clock) -> list[Rows]:
        return self._near.roughly(clock)

    def _aim(self) -> Aim:
        steps = np.arange(COARSE)
        return Aim({"p": self._late}, PENALTY, {"bow": steps, "h": steps}, steps[:0])

    def _changed(self, before: Clock, wanted: Wanted, part: float) -> Clock:
        return Clock(self._near.state, before.h, before.u + part * wanted.u, before.bow)

    def _moved(self) -> None:
        """Nothing is: its nodes stay where they are."""


class _Fine(_Search):
    """A clock with nodes at the corners of the curve that rests as soon as it can."""

    _stretches: Stretches
    _looks: Looks

    def __init__(self, near: NearClock, clock: Clock) -> None:
        """Begin near a clock that rests at its end."""
        super().__init__(near)
        self._stretch(clock)

    def found_beyond(self) -> bool:
        """Look within steps for what is beyond limits, from now on; tell whether there is any."""
        before = self._looks
        self._looks = self._near.beyond(self.now.clock, before)
        self.now = self._look(self.now.clock)
        return any(len(a.k) > len(b.k) for a, b in zip(self._looks, before, strict=True))

    def _cost(self, looked: _Looked) -> float:
        return STRICT * looked.excess + float(looked.clock.t[-1])

    def _stretch(self, clock: Clock) -> None:
        near = self._near
        self._stretches, new = stretched(near.curve, near.state, clock, near.pace, FINE)
        self._looks = Looks.nowhere()
        self.now = self._look(new)

    def _limits(self, clock: Clock) -> list[Rows]:
        return self._near.closely(clock, self._looks, self._stretches.last)

    def _aim(self) -> Aim:
        soon = {"h": np.ones(len(self.now.clock.h))}
        held = {"s": self._stretches.at_corners}
        return Aim(soon, STRICT, held, self._stretches.inner)

    def _changed(self, before: Clock, wanted: Wanted, part: float) -> Clock | None:
        h, u = before.h + part * wanted.h, before.u + part * wanted.u
        return self._stretches.paced(self._near.state, h, u, before.bow + part * wanted.bow)

    def _moved(self) -> None:
        if not self._stretches.fits(self._near.curve, self.now.clock, self._near.pace):
            self._stretch(self.now.clock)
