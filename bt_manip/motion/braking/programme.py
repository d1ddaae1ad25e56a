"""Halts that linear programmes find, where the joints' limits of jerk get in each other's way.

Near a clock the limits are linear in what another one differs from it by. So the one that travels
least is the answer of a linear programme; going there, or part of the way, and linearising again
leads to a clock that keeps the limits themselves. This takes a hundred times what `halting` takes,
and finds a way where that finds none: it knows which jerk to save because another joint will need
it later.
"""

from collections.abc import Callable, Iterator

import numpy as np

from bt_manip.robots import RobotModel

from ..jerk_profile import JerkProfile
from .clock_limits import Curve, State
from .near_clock import Clock, NearClock, Rows

COARSE, FINE = 60, 80  # steps of a clock that is looked for, and of one that is driven
HORIZONS = (2.5, 4.0)  # times the least time to rest: within which a clock shall rest
LONGER = 1.4  # times what the coarse clock takes: within which the fine one shall rest
MARGIN = 0.995  # of the limits, for the fine clock
# Times what the fine clock takes, for one that rests exactly then, and its margin: with a smaller
# one, what lies between the nodes is inside the limits too, but less is found.
EXACTLY = ((1.01, 0.995), (1.04, 0.99), (1.08, 0.995), (1.13, 0.99), (1.2, 0.995), (1.3, 0.98))
ROUGH = 0.02  # excess over the limits of a clock that is of use
PROGRAMMES = 30
PARTS = (1.0, 0.5, 0.25, 0.1, 0.03)  # of the way to the answer of a programme
PENALTY = 1000.0  # of exceeding the limits by all they are, in mean paces
GAIN = 3e-3  # in mean paces, below which another programme is not worth it
HURRY = 1e-3  # what travelling costs a clock whose time is given
STALLED = 0.005  # of its cost: gaining less, that clock gets nowhere
RESTING = 2e-3  # of the greatest pace
RESTED = 1e-7  # of the same: what a programme leaves of it

Limited = Callable[[Clock], list[Rows]]


def programmed_halts(
    curve: Curve, state: State, least: float, left: float, model: RobotModel, allowed: float
) -> Iterator[JerkProfile]:
    """Bring a clock to rest as early as linear programmes find a way.

    At first the limits are looked at roughly, at few nodes: that shows the way. Then closely, until
    nothing travels less; then the clock that rests when this one nearly does.

    Args:
        curve: What the clock goes through, inside its limits at pace 1.
        state: Its reading, its pace and the pace's change.
        least: A time that no halt can be below [s].
        left: One that it has to be below [s].
        model: The arm with its payload.
        allowed: Fraction of the limits of effort that may be used.

    Returns:
        Clocks that keep the limits as far as the programmes look.
    """
    rough, near = (NearClock(curve, state, model, allowed, margin) for margin in (1.0, MARGIN))
    for horizon in HORIZONS:
        times = np.linspace(0.0, min(horizon * least, left), COARSE + 1)
        guess = _braking_all(state, times, -np.sin(np.pi * times / times[-1]))
        coarse = _Search(rough, rough.roughly, guess)
        coarse.travel_less()
        if coarse.excess > ROUGH:
            continue
        fine = _Search(near, near.closely, coarse.clock)
        fine.travel_less(np.linspace(0.0, min(LONGER * coarse.rest, left), FINE + 1))
        if fine.excess > ROUGH:
            continue
        nearest = fine.clock
        for later, margin in EXACTLY:
            if later * fine.rest >= left:
                return
            nearer = NearClock(curve, state, model, allowed, margin)
            exact = _Search(nearer, nearer.closely, nearest)
            even = np.linspace(0.0, later * fine.rest, FINE + 1)
            for _ in range(PROGRAMMES):
                gained = exact.step(HURRY, even)
                if exact.kept:
                    yield exact.clock.profile()
                if gained <= STALLED * exact.cost(HURRY):
                    break
            nearest = exact.clock


def _braking_all(state: State, t: np.ndarray, u: np.ndarray) -> Clock:
    """Make a clock whose changes go like some others, and which rests in the end."""
    u = u.copy()
    u[0], u[-1] = state[2], 0.0
    h = np.diff(t)
    inner = 0.5 * float((h[1:] + h[:-1]) @ u[1:-1])
    u[1:-1] *= -(state[1] + 0.5 * float(h[0]) * state[2]) / inner
    return Clock(state, t, u)


class _Search:
    """A clock that comes nearer to what is wanted, programme by programme.

    Attributes:
        clock: The best one yet.
        excess: The greatest share of what it shall use that it uses beyond all of it.
        kept: Whether it keeps the limits.
    """

    def __init__(self, near: NearClock, limited: Limited, clock: Clock) -> None:
        self._near, self._limited = near, limited
        self._look(clock)

    @property
    def rest(self) -> float:
        """When it rests, but for little [s]."""
        moving = self.clock.p[::-1] >= RESTING * self._near.pace
        return float(self.clock.t[min(len(moving) - int(np.argmax(moving)), len(moving) - 1)])

    def travel_less(self, even: np.ndarray | None = None) -> None:
        """Solve programmes until one brings nothing; nodes as for `step`."""
        for _ in range(PROGRAMMES):
            if self.step(1.0, even) < GAIN:
                return

    def step(self, travelling: float, even: np.ndarray | None = None) -> float:
        """Solve one programme, and go towards its answer as far as that is better.

        Args:
            travelling: What a clock costs that keeps its first pace to the end.
            even: Times of nodes, beside those at the corners of the curve; by default those that
                the clock has.

        Returns:
            How much cheaper the clock is now.
        """
        if even is not None:
            t = self.clock.with_nodes_at(self._near.curve.corners, even)
            u = np.interp(t, self.clock.t, self.clock.u, right=0.0)
            self._look(_braking_all(self._near.state, t, u))
        before, cost = self.clock, self.cost(travelling)
        wanted = _solve(before, self._rows, travelling * self._late, self._near.curve.end)
        if wanted is None:
            return 0.0
        for part in PARTS:
            self._look(Clock(self._near.state, before.t, before.u + part * wanted))
            if self.cost(travelling) < cost:
                return cost - self.cost(travelling)
        self._look(before)
        return 0.0

    def cost(self, travelling: float) -> float:
        """Give what the clock costs, if one that keeps its first pace costs so much."""
        return PENALTY * max(0.0, self.excess) + travelling * float(self._late @ self.clock.p)

    def _look(self, clock: Clock) -> None:
        self.clock, self._rows = clock, self._limited(clock)
        used = max(float((np.abs(rows.value) / rows.most).max()) for rows in self._rows)
        off = max(-float(clock.p.min()), abs(float(clock.p[-1]))) / self._near.pace
        beyond = float(clock.s[-1]) / self._near.curve.end - 1.0
        self.excess = max(used - 1.0, off, beyond)
        self.kept = max(off, beyond) <= RESTED and all(rows.kept for rows in self._rows)

    @property
    def _late(self) -> np.ndarray:
        """Give what a pace costs at each node: the later, the more."""
        weights = np.gradient(self.clock.t) * self.clock.t
        return weights / (self._near.pace * weights.sum())


def _solve(clock: Clock, rows: list[Rows], late: np.ndarray, end: float) -> np.ndarray | None:
    """Give what to add to a clock's changes, by a linear programme; None where it has no answer.

    Its variables are the differences of changes, paces and readings at the nodes, and the share by
    which all limits are exceeded.

    Args:
        clock: What the limits are linearised around.
        rows: These limits.
        late: What a pace costs at each node.  # (n,)
        end: The last reading.
    """
    from scipy import sparse  # half a second to import, and few halts need it
    from scipy.optimize import linprog

    nodes, h = len(clock.u), np.diff(clock.t)
    at = {name: k * nodes + np.arange(nodes) for k, name in enumerate("ups")}
    u, p, s = at.values()
    size, k = 3 * nodes + 1, np.arange(nodes - 1)
    one = np.ones(nodes - 1)
    moving = [
        (k, p[1:], one),
        (k, p[:-1], -one),
        (k, u[1:], -0.5 * h),
        (k, u[:-1], -0.5 * h),
        (len(k) + k, s[1:], one),
        (len(k) + k, s[:-1], -one),
        (len(k) + k, p[:-1], -h),
        (len(k) + k, u[:-1], -h * h / 3.0),
        (len(k) + k, u[1:], -h * h / 6.0),
    ]
    limited, most, count = [], [], 0
    for limit in rows:
        for sign in (1.0, -1.0):
            # What points the other way does not come to exceed its limit in one programme.
            i, j = np.nonzero(sign * limit.value > 0.0)
            row = count + np.arange(len(i))
            limited += [(row, at[name][k[i]], sign * rate[i, j]) for name, k, rate in limit.rates]
            limited.append((row, np.full(len(i), size - 1), -limit.most[i, j]))
            most.append((limit.most - sign * limit.value)[i, j])
            count += len(i)
    low, high = np.full(size, -np.inf), np.full(size, np.inf)
    low[p], low[-1], high[s] = -clock.p, 0.0, end - clock.s
    known = [u[0], p[0], s[0], u[-1]]
    low[known] = high[known] = 0.0
    low[p[-1]] = high[p[-1]] = -clock.p[-1]
    cost = np.zeros(size)
    cost[p], cost[-1] = late, PENALTY

    def matrix(entries: list, shape: tuple[int, int]) -> sparse.csr_matrix:
        at_row, at_column, values = (np.concatenate(part) for part in zip(*entries, strict=True))
        return sparse.csr_matrix((values, (at_row, at_column)), shape=shape)

    found = linprog(
        cost,
        A_ub=matrix(limited, (count, size)),
        b_ub=np.concatenate(most),
        A_eq=matrix(moving, (2 * len(k), size)),
        b_eq=np.zeros(2 * len(k)),
        bounds=np.column_stack([low, high]),
        method="highs",
    )
    return None if found.x is None else found.x[u]
