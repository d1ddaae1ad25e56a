"""The linear programme that tells how to change a clock."""

from typing import Any, NamedTuple

import numpy as np

from .clock import Clock
from .rows import Rows

NODES = ("u", "p", "s")
STEPS = ("bow", "h")
EXACT = 1e-9  # that the programme's answer shall be


class Wanted(NamedTuple):
    """What a programme tells to add to a clock's changes, bows and steps.

    Attributes:
        u: To the changes.  # (n,)
        bow: To the bows.  # (n - 1,)
        h: To the steps [s].  # (n - 1,)
        cost: What that costs more, and what it costs to exceed the limits then.
    """

    u: np.ndarray
    bow: np.ndarray
    h: np.ndarray
    cost: float


class Aim(NamedTuple):
    """What a clock shall become.

    Attributes:
        price: What each variable costs.  # (n,) or (n - 1,) each
        penalty: What it costs to exceed the limits by all they are.
        held: Where variables stay as they are.
        even: Steps that keep their ratio to the one before.
        reach: By how much each step may become longer or shorter, as a share of it, and each change
            of the pace, as a share of the greatest.
    """

    price: dict[str, np.ndarray]
    penalty: float
    held: dict[str, np.ndarray]
    even: np.ndarray
    reach: float = 1.0


def solved(clock: Clock, rows: list[Rows], end: float, aim: Aim) -> Wanted | None:
    """Give what to add to a clock, by a linear programme; None where it has no answer.

    Its variables are the differences of the clock's variables, and the share by which all limits
    are exceeded. Everything is measured in its own limit, since the solver's tolerance is absolute.

    Args:
        clock: What the limits are linearised around; it rests at its last node.
        rows: These limits.
        end: The last reading.
        aim: What it shall become.
    """
    from scipy.optimize import linprog  # half a second to import, and few halts need it

    nodes = len(clock.u)
    ends = np.cumsum([*(nodes for _ in NODES), *(nodes - 1 for _ in STEPS)])
    at = dict(zip((*NODES, *STEPS), np.split(np.arange(ends[-1]), ends[:-1]), strict=True))
    size = int(ends[-1]) + 1
    limited, room = _limited(rows, at, size - 1)
    moving = _moving(clock, aim.even, at)
    low, high = np.full(size, -np.inf), np.full(size, np.inf)
    low[at["p"]], low[-1], high[at["s"]] = -clock.p, 0.0, end - clock.s
    low[at["h"]], high[at["h"]] = -aim.reach * clock.h, aim.reach * clock.h
    high[at["u"]] = aim.reach * float(np.abs(clock.u).max())
    low[at["u"]] = -high[at["u"]]
    known = [at["u"][0], at["p"][0], at["s"][0], at["u"][-1]]
    held = np.concatenate([known, *(at[name][which] for name, which in aim.held.items())])
    low[held] = high[held] = 0.0
    low[at["p"][-1]] = high[at["p"][-1]] = -clock.p[-1]
    cost = np.zeros(size)
    cost[-1] = aim.penalty
    for name, price in aim.price.items():
        cost[at[name]] = price
    found = linprog(
        cost,
        A_ub=limited.matrix(size),
        b_ub=room,
        A_eq=moving.matrix(size),
        b_eq=np.zeros(moving.count),
        bounds=np.column_stack([low, high]),
        method="highs",
        options={"primal_feasibility_tolerance": EXACT, "dual_feasibility_tolerance": EXACT},
    )
    if found.x is None:
        return None
    x = found.x
    return Wanted(x[at["u"]], x[at["bow"]], x[at["h"]], float(found.fun))


class _Equations:
    """Rows of a sparse matrix, added one group after the other."""

    def __init__(self) -> None:
        self.count = 0
        self._entries: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def add(self, count: int, *terms: tuple[np.ndarray, np.ndarray]) -> None:
        """Add as many rows: columns and factors of their terms."""
        rows = self.count + np.arange(count)
        for columns, factors in terms:
            self._entries.append((rows, columns, np.broadcast_to(factors, count)))
        self.count += count

    def matrix(self, size: int) -> Any:
        """Give them all."""
        from scipy import sparse  # as slow to import

        row, column, factor = (np.concatenate(part) for part in zip(*self._entries, strict=True))
        return sparse.csr_matrix((factor, (row, column)), shape=(self.count, size))


def _limited(
    rows: list[Rows], at: dict[str, np.ndarray], excess: int
) -> tuple[_Equations, np.ndarray]:
    """Write down the limits, and how far each of them is away."""
    found, room = _Equations(), []
    for limit in rows:
        most = np.broadcast_to(limit.most, limit.value.shape)
        for sign in (1.0, -1.0):
            value = sign * limit.value / most
            i, j = np.nonzero(value > (-np.inf if limit.wild else 0.0))
            terms = [
                (at[name][limit.at[i] + behind], sign * rate[i, j] / most[i, j])
                for (name, behind), rate in limit.rates.items()
            ]
            found.add(len(i), *terms, (np.full(len(i), excess), np.array(-1.0)))
            room.append(1.0 - value[i, j])
    return found, np.concatenate(room)


def _moving(clock: Clock, even: np.ndarray, at: dict[str, np.ndarray]) -> _Equations:
    """Write down how paces and readings follow from changes and steps."""
    u, p, s, bow, steps = (at[name] for name in (*NODES, *STEPS))
    h, found, count = clock.h, _Equations(), len(clock.h)
    found.add(
        count,
        (p[1:], 1.0 / h),
        (p[:-1], -1.0 / h),
        (u[1:], np.array(-1.0 / 2.0)),
        (u[:-1], np.array(-1.0 / 2.0)),
        (bow, np.array(-2.0 / 3.0)),
        (steps, -clock.mean / h),
    )
    found.add(
        count,
        (s[1:], 1.0 / h**2),
        (s[:-1], -1.0 / h**2),
        (p[:-1], -1.0 / h),
        (u[:-1], np.array(-1.0 / 3.0)),
        (u[1:], np.array(-1.0 / 6.0)),
        (bow, np.array(-1.0 / 3.0)),
        (steps, -(clock.p[:-1] + 2.0 * h * clock.early) / h**2),
    )
    found.add(len(even), (steps[even], 1.0 / h[even]), (steps[even - 1], -1.0 / h[even - 1]))
    return found
