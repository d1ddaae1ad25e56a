"""The fastest halt that linear programmes find, where jerk is what limits; without bt-manip.

Whether a clock along the path can come to rest in a given time is a linear programme in the clock's
changes, once the limits are linearised around the programme before it; the time is bisected. The
first clock brakes like half a sine, whatever bt-manip does. What is found is a halt that keeps all
limits but for `CLOSE`, and an optimum near the last one: there may be a faster one elsewhere.
"""

import numpy as np
from scipy import sparse
from scipy.optimize import linprog

from benchmarks.fastest_halt import State
from bt_manip.motion.braking.clock_limits import Curve
from bt_manip.robots import RobotModel

NODES = 120  # at which the limits hold
PROGRAMMES = 20  # after which a time counts as too short
PARTS = (1.0, 0.5, 0.2, 0.05)  # of the way to the answer of a programme
CLOSE = 1e-5  # of the limits, that an answer may be off: 2e-4 buy a tenth of the time, sometimes
BISECTIONS = 6
LONGEST = (1.4, 2.0, 2.8)  # times the bound, where the search begins


def found(
    curve: Curve, state: State, model: RobotModel, bound: float, driven: np.ndarray, step: float
) -> float | None:
    """Give the shortest time to rest that is found [s]; None where none is.

    Looked for near half a sine and near the halt that bt-manip made.

    Args:
        curve: What the clock goes through.
        state: The clock's reading, its pace and the pace's change.
        model: The arm with its payload.
        bound: A time that none can be below [s].
        driven: Changes of the pace of the halt that was made, until it rested.  # (n,)
        step: The time between them [s].
    """
    best = None
    for factor in LONGEST:
        half_a_sine = -np.sin(np.linspace(0.0, np.pi, NODES + 1))
        best = _shortest(curve, state, model, (bound, factor * bound), half_a_sine)
        if best is not None:
            break
    if driven.min() < 0.0:  # not merely on to the end of the curve
        times, duration = step * np.arange(len(driven)), step * (len(driven) - 1)
        guess = np.interp(np.linspace(0.0, duration, NODES + 1), times, driven)
        near = _shortest(curve, state, model, (bound, duration), guess)
        best = min((time for time in (best, near) if time is not None), default=None)
    return best


def _shortest(
    curve: Curve,
    state: State,
    model: RobotModel,
    between: tuple[float, float],
    guess: np.ndarray,
) -> float | None:
    """Give the shortest time to rest that is found near a guess, if any, between two [s]."""
    low, high = between
    best = _rest_within(curve, state, model, high, guess)
    if best is None:
        return None
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        faster = _rest_within(curve, state, model, middle, best)
        if faster is None:
            low = middle
        else:
            high, best = middle, faster
    return high


def _rest_within(
    curve: Curve, state: State, model: RobotModel, duration: float, guess: np.ndarray
) -> np.ndarray | None:
    """Give a clock's changes that bring it to rest in a time, or None."""  # (NODES + 1,)
    h = duration / NODES
    u = guess.copy()
    u[0], u[-1] = state[2], 0.0
    # The same course in less time: whatever the guess brakes, it has to brake the whole pace.
    inner, ends = h * u[1:-1].sum(), 0.5 * h * (u[0] + u[-1])
    u[1:-1] *= -(state[1] + ends) / inner
    programme = _Programme(curve, state, model, h, u)
    for _ in range(PROGRAMMES):
        if programme.excess <= CLOSE:
            return programme.u
        wanted = programme.solve()
        if wanted is None:
            return None
        trials = (
            _Programme(curve, state, model, h, programme.u + part * (wanted - programme.u))
            for part in PARTS
        )
        better = min(trials, key=lambda trial: trial.excess)
        if better.excess >= programme.excess:
            return None
        programme = better
    return programme.u if programme.excess <= CLOSE else None


class _Programme:
    """The limits along a clock, linearised around it."""

    def __init__(self, curve: Curve, state: State, model: RobotModel, h: float, u: np.ndarray):
        n = len(u) - 1
        p = state[1] + np.concatenate([[0.0], np.cumsum(0.5 * h * (u[1:] + u[:-1]))])
        moved = h * (p[:-1] + h * (u[:-1] / 3.0 + u[1:] / 6.0))
        s = np.minimum(state[0] + np.concatenate([[0.0], np.cumsum(moved)]), curve.end)
        self.u, self.p, self.s, self._h, self._n, self._state = u, p, s, h, n, state
        step = 1e-5 * max(float(np.ptp(s)), 1e-6)
        here, there = _limited(curve, model, s), _limited(curve, model, s + step)
        change = [(b - a) / step for a, b in zip(here, there, strict=True)]
        up, pp = u[:, np.newaxis], p[:, np.newaxis]
        rates, squares, linear, rest = here
        drift = change[0] * up + change[1] * pp**2 + change[2] * pp + change[3]
        # value = constant + rates u + by_p p + drift s, around this clock
        self._rates, self._by_p, self._drift = rates, 2.0 * squares * pp + linear, drift
        value = rates * up + squares * pp**2 + linear * pp + rest
        self._constant = value - rates * up - self._by_p * pp - drift * s[:, np.newaxis]
        b, m = curve.bounds, len(curve.bounds.jerk)
        self._bound = np.concatenate([b.acceleration, model.limits.effort])
        self._jerk, self._m = b.jerk, m
        # The first node is where the arm is: what it uses there cannot be helped.
        used = np.abs(value[1:] / self._bound).max()
        steep = np.abs(np.diff(value[:, :m], axis=0) / (h * b.jerk)).max()
        speed = (np.abs(rates[1:, :m] * pp[1:]) / b.velocity).max()
        off = abs(p[-1]) / max(state[1], 1e-9)
        self.excess = max(used, steep, speed, 1.0 + off, 1.0 - p.min() / max(state[1], 1e-9)) - 1.0

    def solve(self) -> np.ndarray | None:
        """Give the changes of the clock that exceed the limits least."""  # (n + 1,)
        n, h, m = self._n, self._h, self._m
        size = 3 * (n + 1) + 1
        at_u, at_p, at_s = (k * (n + 1) + np.arange(n + 1) for k in range(3))
        equal, right = self._motion(size, at_u, at_p, at_s)
        blocks, bounds = [], []
        for row in range(len(self._bound)):
            value = sparse.lil_matrix((n + 1, size))
            k = np.arange(n + 1)
            value[k, at_u] = self._rates[:, row]
            value[k, at_p] = self._by_p[:, row]
            value[k, at_s] = self._drift[:, row]
            value, constant = value.tocsr(), self._constant[:, row]
            pairs = [(value[1:], constant[1:], self._bound[row])]
            if row < m:
                pairs.append((value[1:] - value[:-1], np.diff(constant), h * self._jerk[row]))
            for matrix, offset, most in pairs:
                slack = sparse.csr_matrix(
                    (np.full(n, -most), (np.arange(n), np.full(n, size - 1))), shape=(n, size)
                )
                blocks += [matrix + slack, slack - matrix]
                bounds += [most - offset, most + offset]
        ranges = [(None, None)] * (n + 1) + [(0.0, None)] * (n + 1) + [(None, None)] * (n + 1)
        cost = np.zeros(size)
        cost[-1] = 1.0
        found = linprog(
            cost,
            A_ub=sparse.vstack(blocks).tocsc(),
            b_ub=np.concatenate(bounds),
            A_eq=equal,
            b_eq=right,
            bounds=[*ranges, (0.0, None)],
            method="highs",
        )
        return None if found.x is None else found.x[at_u]

    def _motion(self, size, at_u, at_p, at_s):
        """Write what pace and reading are when the change is linear in each step."""
        n, h = self._n, self._h
        rows = sparse.lil_matrix((2 * n + 5, size))
        right = np.zeros(2 * n + 5)
        k = np.arange(n)
        for column, factor in ((at_p[1:], 1.0), (at_p[:-1], -1.0)):
            rows[k, column] = factor
        rows[k, at_u[1:]] = rows[k, at_u[:-1]] = -0.5 * h
        rows[n + k, at_s[1:]], rows[n + k, at_s[:-1]], rows[n + k, at_p[:-1]] = 1.0, -1.0, -h
        rows[n + k, at_u[:-1]], rows[n + k, at_u[1:]] = -h * h / 3.0, -h * h / 6.0
        fixed = [(at_s[0], self._state[0]), (at_p[0], self._state[1]), (at_u[0], self._state[2])]
        for i, (column, value) in enumerate([*fixed, (at_p[-1], 0.0), (at_u[-1], 0.0)]):
            rows[2 * n + i, column] = 1.0
            right[2 * n + i] = value
        return rows.tocsc(), right


def _limited(curve: Curve, model: RobotModel, s: np.ndarray) -> list[np.ndarray]:
    """Give what multiplies u, p^2, p and 1 in accelerations and efforts."""  # (n, m + nq) each
    x, d1, d2 = curve.evaluate(np.minimum(s, curve.end))
    nq, none = model.nq, np.zeros_like(d1)
    q, v, a = x[:, :nq], d1[:, :nq], d2[:, :nq]
    still = np.zeros(nq)
    gravity = np.array([model.rnea(row, still, still) for row in q])
    inertia = np.array([model.rnea(i, still, j) for i, j in zip(q, v, strict=True)]) - gravity
    motion = np.array([model.rnea(i, j, k) for i, j, k in zip(q, v, a, strict=True)]) - gravity
    return [
        np.hstack([d1, inertia]),
        np.hstack([d2, motion]),
        np.hstack([none, model.damping * v]),
        np.hstack([none, gravity + model.friction * np.sign(v)]),
    ]
