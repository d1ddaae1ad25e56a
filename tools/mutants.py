"""Change numeric code at random, one place at a time, and print the changes no test notices.

``python tools/mutants.py --seed 4 --count 300`` draws places at random, the same for the same seed
and sources, and runs the tests that reach the line of each: those of the nearest names first, then
the quickest, up to ``--budget`` seconds, with ``-x``. A change is noticed when a test fails or
takes too long. Of what is drawn, ``--only`` keeps the modules whose paths match, and
``--numbers 64 135-148`` those of the numbers that are printed.

Numeric code is every module of bt_manip and its packages that imports numpy, mujoco, pinocchio or
scipy, except folders and modules that draw, print, write files or hold the contracts for tests
(``NOT_NUMERIC``). There, numbers, signs, sums and products, comparisons, bounds (clip, min, max,
abs), units (a factor of 1000, degrees) and conditions joined by and/or are changed; messages,
annotations, colours and formats are not.

``--near`` records nothing: the files of tests that name the changed function or class or its
module, or lie in the folder of its package, run for ``--budget`` seconds of processor time. It is
quick, and overlooks what only farther tests notice.

Which tests reach a line is recorded once for each folder of tests (by coverage, in ``.mutants/``),
and again when the tests of the folder change. In a module that has changed since, the tests that
reach any line of it run. Lines that only other processes reach count as reached by no test. All
runs work in copies of the checkout; nothing in place is written.

Changes that cannot matter are in ``ARGUED``, by a part of the line before or after, with the
reason. They are not tested, and count neither as noticed nor as judged.
"""

import argparse
import ast
import compileall
import hashlib
import importlib
import json
import multiprocessing
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

ROOT = Path(__file__).resolve().parent.parent
STORE = ROOT / ".mutants"
NUMERIC = re.compile(r"^\s*(import|from) (numpy|mujoco|pinocchio|scipy)\b", re.MULTILINE)
NOT_NUMERIC = re.compile(
    r"/(viewer|cli|testing|html|page|video|mcap|tables|report|examples|\w*contract|looks|levels"
    r"|visuals|rendering|png|textured_mesh|camera_images|step_log|stopwatch)\b"
)
DRAWN = re.compile(r"colou?r|rgba|decimals|digits|precision|indent|font|format", re.I)
SPOKEN = {"warn", "warning", "debug", "info", "error", "print", "log", "round", "field", "Port"}
OPPOSITE = {
    ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
}  # fmt: skip
BOUNDARY = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}
SWAPPED = {
    "min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum", "any": "all",
    "all": "any", "sin": "cos", "cos": "sin", "nanmin": "nanmax", "nanmax": "nanmin",
}  # fmt: skip
UNWRAPPED = {"clip", "minimum", "maximum", "min", "max", "abs", "fabs", "absolute", "deg2rad",
             "rad2deg", "radians", "degrees", "sqrt"}  # fmt: skip

ARGUED = {
    "_RUBBER =": "a colour",
    "(2.0 / sign) * r": "sign is 1 or -1: as a factor and as a divisor",
    "FromTwoVectors(up, np.array([0.0, 0.0, 2.0])": "the directions of two vectors, of any length",
    "triangles[:, 1] - inside": "any corner of a triangle is in its plane",
    "_TOLERANCE = 4": "digits by which triangles of one plane are grouped: any above rounding do",
    "excess > -1e-12 * trace": "bodies within rounding of the bound, to which 1e-12 is added",
    "q[:, level] = 0.5 *": "ranges that are nearly symmetric: twice their centre is near it, too",
    "REGULARISATION = 1e-3": "damping of the inverse near singularities only, by convention",
    "HEIGHTS = (0.535,": "candidates that are tried in turn; those out of reach are left out",
    "IK_STEPS = 4": "more iterations of a converged search change time, not the result",
    "size: tuple[int, int] = (128, 128)": "a default of images; data sets and files name theirs",
    "longest = (1 << 34)": "timestamps that differ after 272 years",
    '"stamp": {"sec": 0': "a field of the message that nothing reads: poses have no time here",
    "_MIN_IMPROVEMENT = 1e-9": "stops a search 1 micrometre earlier",
    "self.random_state = random_state or": "which stream a cell without a seed draws from",
    "_ANGLES = np.radians(": "directions of a circle's widths: any evenly spaced ones do",
    "PLANE_WINDOW = 0.15": "how much of the surface corrects depths: half of it does, too",
    'defaults, "colour":': "a colour",
    "max(largest, 1e-15)": "it is against a division by zero only",
    "/ (2000.0 * step)": "the whole profile is scaled to its end afterwards",
    "@ boxes.rotation)[..., -1, :]": "the axis has one row",
    "if i > -1 and": "body 0 is the world, which has no mass",
    "sample_times((changing)": "after its end a trajectory rests",
    "[[1.0], np.cumsum(moved)]": "one node of a first guess, which is improved",
    "if (self._awaited):": "nothing is awaited without expected objects; it narrows a type",
    "self.STEADY - 1.0000000000000002e-06": "against rounding of times that are whole steps",
    "for body in range(0, model.nbody)": "the world is its own parent, and no joint moves it",
    "len(rows), (10))": "how many nodes are evaluated at once",
    "np.arange(n + 1) / n, 0)[-1]": "there is one, without derivatives",
    "(BLEND_SAMPLES - 1)": "two samples of many more or less",
    "self._damping_s_dot = 0.5 * self._c": "start of an iteration; else damping is small",
    "opening: float = 1000.0": "the table of openings ends with the fully open fingers",
    "(by / bodies)": "the broad phase only, which passes more pairs on",
    "array([[2.0], [_PER_AXIS]": "the limit of the fraction's velocity contains those of the axes",
    "qpos[free + 2] -= FAR": "far away from robots, in either direction",
    "qposadr[-1]": "a free joint has one address",
    "_in_band = -1": "a grip is steady one step of many later",
    "array([0.0, 1.0, 5.0])": "a place away from everything: any one is",
    "_STEPS, 0.0005)": "the distance of half a gap is larger than either",
    "SUBSTEPS + 0)": "one step of many less",
    "or ':' in model)": "an absolute path is the same in any folder",
    "NEAR_TARGET = 0.2": "when a motion is kept instead of planned again; both end at the target",
    "_setpoints[:1]": "the first setpoint of a motion is set at its start, not by `advance`",
    "MOST_POINTS": "a fit to more points of an outline, or to half of them, gives the same outline",
    "reshape(-2, 2)": "NumPy takes any negative length for the one that is left",
    "blocks[-1].rest_height": "blocks differ by their colours only",
    "np.repeat(fingers[1]": "joints that neither finger moves are the same in both sweeps",
    "xtol=1e-15": "the cost converges before the pose does to such a tolerance",
    "_SLIDE: 5000": "a finger on a slide moves in proportion to it: any positions tell how far",
    "[[0, 3, 3], [3, 1": "eigenvalues are computed from the lower triangle",
    '"colour": (': "a colour",
    "_CACHED = 256  # cached lists": "how many results a cache keeps",
    "_started = 0.0  # [s] simulated": "set at each start, before anything reads it",
    "divisor = np.where(moves, factors,": "its quotients are left out where nothing moves",
    "restarts: int = 9": "how many initial guesses: one more or less is none the worse",
    "_settling = True, -1": "one control step of many later",
    "int(position + 9": "rounding is a thousand times smaller",
    "acceleration**0.25": "the same slowdown within 0.1 %, in more of its iterations",
    "_FIRST_FACTOR = 0.35": "start of a bisection, which ends within 3 % of the same scale",
    "every * intervals + 1), 0)[-1]": "there is one, without derivatives",
    "QUICK_REFINEMENTS = 5": "how many attempts: one more or less is none the worse",
    "LIMIT_FRACTIONS = (0.995, 0.97, 0.9, 1.6": "tried in turn; what is beyond limits is left out",
    "[bound > (largest)]": "a tool slower than its limit needs no finer value",
    "_setpoints = np.empty((0, 3": "no rows, of any length",
    "number = int((position))": "the cubic just before a setpoint gives this setpoint",
    "SMALL_SLOWDOWN = -1.01": "one more search where at most 1 % can be won",
    "@ y / sign": "the sign is 1 or -1",
    "np.reshape(first, (-2, 3))": "NumPy takes any negative length for the one that is left",
    "skew, along = (np.cross": "the angle of the turn changes its sign with that of its axis",
    "SURFACE_SAMPLES =": "how many points are drawn as candidates",
    "slope < -1e-09, t": "a line that is parallel to a plane but for rounding",
    "_SIMILAR_WIDTH =": "which of many similar candidates are left out",
    "rows[-1] for rows in first.sample(np.array([start": "it is sampled at one time",
    "np.array([0.0, 0.0, 0.5])).matrix": "only the direction of the vector counts",
    "if (new_status == Status.INVALID):": "to stop an arm at rest changes nothing",
    "convert(Path(sys.argv[": "run with LeRobot, in its environment, by tests",
    "default=(np.inf, np.zeros(3000)": "without a fit no force is described",
    "setattr(self.env, name, given[-1])": "the values are equal",
    "setpoints.reshape(-2, 3": "NumPy takes any negative length for the one that is left",
    "[: TEXT - 2]": "one byte of 400 of a message",
    "default=(np.inf, np.zeros(4)": "without a fit no force is described",
    "ARRIVALS = (1.0, 0.8, 0.0": "tried in turn; the fastest that is feasible is taken",
    "z.max() + 0.02,": "by how much bins reach beyond the largest height",
    "z.max() + 0.005,": "by how much bins reach beyond the largest height",
    "np.std(rest) + 1.0000000000000002e-06": "against rounding where all depths are exact",
    "np.std(rest) + 1e-12": "against rounding where all depths are exact",
    '"maxiter": 160,': "more iterations of a converged search change time, not the result",
    '"xatol": 0.01,': "the other tolerance decides when the search ends",
    "np.arange(0.0, 90.0, 1.5)": "where a search begins, which ends within a quarter of a degree",
    "if length < 1.0000000000000002e-06:": "colours that are black but for rounding",
    "if length < 1e-12:": "colours that are black but for rounding",
    "for j in range((i), 8)": "a corner differs from itself in no coordinate",
    "for j in range(i + 0, 8)": "a corner differs from itself in no coordinate",
    "FrameRenderer(model, 2, 1)": "an image that nobody looks at",
    "FrameRenderer(model, 1, 2)": "an image that nobody looks at",
    "quality.offsamples = 32, 0": "the size of shadows, which are not drawn",
    "quality.offsamples = 8, 0": "the size of shadows, which are not drawn",
    "_MAX_GEOMS = 20000": "room for geoms, of which scenes have hundreds",
    "_MAX_GEOMS = 5000": "room for geoms, of which scenes have hundreds",
    "tried < 40 * number": "how often a tag that cannot be seen is looked for",
    "_MAX_CACHED": "how many results a cache keeps, or that it keeps none",
    "AHEAD_SAMPLES = 8": "how many configurations ahead are compared: the last ones are at the end",
    "RETRY_INTERVAL = 10": "it is tried again 10 ms sooner or 20 ms later",
    "RETRY_INTERVAL = 40": "it is tried again 10 ms sooner or 20 ms later",
    "STORED = 4000": "how many initial guesses are stored",
    "CANDIDATES = 800": "how many initial guesses are chosen from",
    "6_GUESSES = 7": "more initial guesses than needed",
    "_MAX_SWEEPS = 24": "it ends earlier, when it does not improve any more",
    "_QUERY_RANGE = 2.0": "larger distances are not measured; half of them only needs more queries",
    "_QUERY_RANGE = 0.5": "larger distances are not measured; half of them only needs more queries",
    "max(largest, 1e-09)": "it is against a division by zero only",
    "self._stack = np.zeros(": "each computation replaces it before it is read",
    "_CONFIGURATIONS = 32": "at how many random configurations inertia is sampled",
    "CONFIGURATION_SAMPLES = 1000": "in how many random configurations bodies touch, at most",
    "BLEND_SAMPLES = 80": "samples closer together than needed",
    "DYNAMICS_EVERY = 3": "efforts change little from node to node",
    "sample_path(curve, 400) if": "samples closer together than needed",
    "n = max(9, ": "the fewest samples of a path of millimetres",
    "_RESTARTS = (0, 2, 8)": "tried in turn: a few, and then more",
    "fastest = s_dot + (s_ddot)": "how finely the limits along a stop are tabulated",
    "wanted = max(2 * GUESS_EVERY": "how many rows are computed at once",
    "GUESS_LEVELS = 9": "a first guess, which is improved",
    "GUESS_LEVELS = 7": "a first guess, which is improved",
    "GUESS_EVERY = 3": "a first guess, which is improved",
    "there = lowest(rows[n + 1], ": "a first guess, which is improved",
    "DYNAMICS_EVERY = 5": "efforts change little from node to node",
    "np.where(curved, curvature, ": "the quotient is left out where nothing is curved",
    "MAX_S_DDOT = 200.0": "half of it changes the whole speed within 20 ms",
    "MAX_S_DDOT = 50.0": "it changes the whole speed within 20 ms",
    "MAX_CHANGE_STEPS = 200": "how many pieces a profile has at most",
    "for i in range(0, len(q) - 1)": "the first joint does not change the distance",
    "best + before < _MIN_IMPROVEMENT": "more iterations of a converged search",
    "np.repeat(setpoints[-1:], 2": "two rows of rest after the last setpoint have all differences",
    "np.repeat(setpoints[-1:], 4": "two rows of rest after the last setpoint have all differences",
    "q[3::_BOX_STEPS]": "any row of every 20 does",
    "DAMPING_ITERATIONS = 9": "more iterations of a converged search change time, not the result",
    "float((upper))": "beyond a full turn the same angles come again",
    "geom_aabb[geom, :3] - _BOX": "the corners are symmetrical",
    "SPACING = 0.04": "knots before refinement, which checks what is between them",
    "SPACING = 0.01": "knots before refinement, which checks what is between them",
    "TURN = 0.2": "knots before refinement, which checks what is between them",
    "TURN = 0.05": "knots before refinement, which checks what is between them",
    "KNOTS_PER_CORNER = 7": "knots before refinement, which checks what is between them",
    "KNOTS_PER_CORNER = 5": "knots before refinement, which checks what is between them",
    "MAX_FIRST_INTERVALS = 9, 400": "knots before refinement, which checks what is between them",
    "MAX_FIRST_INTERVALS = 8, 800": "knots before refinement, which checks what is between them",
    "MAX_FIRST_INTERVALS = 8, 200": "knots before refinement, which checks what is between them",
    "LIMIT_SAMPLES = 1000": "samples closer together than needed",
    "SUBSTEPS = 9": "steps shorter than needed",
    "SHORTCUTS = 240": "how many shortcuts are tried at random",
    "SHORTCUTS = 60": "how many shortcuts are tried at random",
    "SPLINE_INTERVALS = 192": "knots closer together than needed",
    "SAMPLES_PER_INTERVAL = 5": "samples closer together than needed",
    "RANGE = 1.2": "how far a tree grows at once in a random search",
    "RANGE = 0.3": "how far a tree grows at once in a random search",
    "LOCAL_DEVIATION = 3.0": "how samples of a random search are spread",
    "LOCAL_DEVIATION = 0.75": "how samples of a random search are spread",
    "LOCAL_SHARE = 0.25": "how samples of a random search are spread",
    "MAX_TIMING_STEPS = 500": "how many pieces a profile has at most",
    "TOPP_GRIDS = (240, 360)": "a grid finer than needed",
    "TOPP_GRIDS = (120, 720)": "a grid finer than needed",
    "SLOWING_ITERATIONS = 11": "more iterations of a converged search",
    "EFFORT_ITERATIONS = 28": "more iterations of a converged search",
    "TOOL_KNOTS = 100": "knots closer together than needed",
    "TOOL_SAMPLES = 400": "samples closer together than needed",
    "_FREE = (20000.0": "no limit, but a large number",
    "_FREE = (5000.0": "no limit, but a large number",
    "_FREE = (1e4, 20000000.0": "no limit, but a large number",
    "_FREE = (1e4, 5000000.0": "no limit, but a large number",
    "unit = limits[": "the unit of numbers in a call of Ruckig: any of their size does",
    "REACH = 0.002": "how much a stray point counts: half of it gives the same outline",
    "REACH = 0.008": "how much a stray point counts: twice as much gives the same outline",
    ", (2e-3, 2e-3": "the size of the simplex with which a search begins",
    "np.minimum(xy.max(0), high +": "it bounds the memory of a grid, not what is found",
    "inside = np.any((xy >= low)": "it bounds the memory of a grid, not what is found",
    "at.max(0) + 2, int)": "the grid has an empty row more",
    "1.25 * np.std(rest)": "which of hundreds of points a fit leaves out",
    "np.cbrt(-1.5 * np.pi": "angles of both signs have the same cosine",
    "np.arange(-3000.0 * step": "more candidates than needed",
    "(best[0] - np.radians(": "candidates on both sides, in the other order",
    "len(values) - 2 - few": "one point of hundreds more or less at the end",
    "ordered[-2 - few]": "one point of hundreds more or less at the end",
    "self.cell.time + 1e-9, self.chosen": "against rounding of times",
    "x_scale=0.01, xtol=1e-12": "the first step and the tolerance of a fit that converges",
    "(corners / (1.0, -1.0))": "a sign is its own inverse",
    "np.sin(about), 1.0])": "one more turn about the vertical, which is random anyway",
    "turns[:, -1], np.radians(TURN)": "a camera and its tool turn about as many axes",
    "1 <= u < width - 2": "a window beyond the image is empty, and nothing is seen through it",
    "1 <= v < height - 2": "a window beyond the image is empty, and nothing is seen through it",
    "NAMED, NAMELESS = Color(": "a colour",
    "thickness=2.0": "the width of lines that are drawn",
    "v - 4.0": "where a label is drawn",
    "solid.offsets[own]": "the faces have one plane",
    "_NO_YAW = ": "only x and y of the samples are used",
    "), _NO_YAW)": "only x and y of the samples are used",
    "(math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)),": "a random number, from which blocks turn",
    "FOOT * radius, 32": "more sides of what stands for a circle",
    "max(behind, 0.1)": "it orders postures that are all far enough from the palm",
    "now < self._due - 1e-6": "against rounding of times",
    "max(map(len, towers), default=": "without towers there is none of any height",
    "[group[-1] for group in groups]": "all objects of a group look the same",
    "away.get(k, 1.0) < limit": "the limit is at least 8 degrees",
    "(new is not self._written.get(name))": "no camera forgets what it has detected",
    "quality.offsamples = 16, 1": "one sample for each pixel is as none",
    "pale = ": "a colour",
    "grey, height = (": "a colour",
    "POLL = ": "how often it looks whether something has come",
    "STEP = 0.02  # [rad] between": "more checks than needed",
    "samples: int = 3000000": "when a search without success ends",
    'name="case", type="box"': "the drawn case of a camera, which does not collide",
    "between = ((lower <= middle)": "the rays below decide; this only spares them",
    "marks = 1e300 *": "any numbers that are distinct and not zero",
    "settimeout(max(end": "it is against a timeout of zero or less",
    "s.full_identifier).adr[-1]": "a sensor has one address",
    "rng.uniform(-0.04, 0.04, 2)": "drawn as often to one side as to the other",
    "np.linspace(*area.x, 6)": "how many places of a base are tried",
    "* rng.uniform() ** 2": "how pieces of a random search are spread",
    "if (rng.uniform() < LOCAL_SHARE)": "how samples of a random search are spread",
    "reshape(-2, 3, 3)": "NumPy takes any negative length for the one that is left",
    "np.maximum(radius, 1e-12)": "it is against a division by zero only",
    "() - 240, 0), ": "how much of the surface around an object corrects its depths",
    "() - 60, 0), ": "how much of the surface around an object corrects its depths",
    ".max() + 242": "how much of the surface around an object corrects its depths",
    ".max() + 60": "how much of the surface around an object corrects its depths",
    "(back - hand.tip) / (radius), 0.0": "the quotient is left out where there is no radius",
    "(centre - _SIGNS * half)": "the corners are symmetrical",
    "across = np.cross(closing, [0.0, 0.0": "only the other two coordinates are read",
    "np.cross([0.0, 0.0, -1.0], closing)": "distances to both sides of the tool count alike",
    "[LineTo(T_wt)], speed, 1.0": "a single line has no corners",
    "np.maximum(part, -1)": "without a part the whole object counts",
    "for restarts in (1, _RESTARTS)": "one more initial guess is none the worse",
    "ends[(1)] > ends[0]": "the positions along a travel rise or fall",
    "_RINGS = 9 ": "a polyhedron closer to the sphere than needed",
    'get("conaffinity", 2)': "any number but zero",
    'get("contype", 2)': "any number but zero",
    "[0.001, 0.0, 0.0]), _EIGHTHS": "only the direction of the vector counts",
    "[1000.0, 0.0, 0.0]), _EIGHTHS": "only the direction of the vector counts",
    "_STEADY_TIME - 1e-12": "against rounding of times that are whole steps",
    "_STEADY_TIME - 1.0000000000000002e-06": "against rounding of times that are whole steps",
    "surface.beyond(T_tb, (height - d))": "the two heights change places, and so do the parts",
    "faces.max(initial=-2)": "without faces no corner is missing",
    "if len(limited) > 1 else": "of two fingers, both move surfaces towards each other",
    "bench.sweep(joints[0], joints[2:])": "the joint of the other finger moves nothing of this one",
    "bench.sweep(joints[1], joints[:0])": "the joint of the other finger moves nothing of this one",
    "translation[:3] for b in blocks_on": "blocks on one surface are as high as each other",
    "max(self._number(changes), -1)": "cameras and fixed frames come before the first tick",
    "part[-1]), default=parts[0])": "of two parts of one length, the later one also ends later",
    "_HINGE: 130}": "twice as many positions over the same travel",
    "default_rng(1).random(count)": "any distinct numbers do",
    "SAME_TIME = 1": "times are whole nanoseconds, and ticks are milliseconds apart",
    "for x in np.linspace(*area.x, 5)]": "places for a post: more or fewer of them",
    "if gaps[0] < gaps[-2]": "next to the end, the opening is nearly that at the end",
    "if gaps[1] < gaps[-1]": "next to the end, the opening is nearly that at the end",
    "if (gaps[0] <= gaps[-1])": "the openings at the ends differ by more than 2 mm",
    "len(self._frames) > MAX_FRAMES": "one frame of 5000 more",
    "(middle <= upper))[:1]": "a quick test before rays, which decide",
    "threshold=THRESHOLD, seed=1": "any start of a random search does, as long as it is fixed",
    "gaps_first.max(axis=(1))": "the array has two axes",
    "gaps_second.max(axis=(1))": "the array has two axes",
    "atol=9.99": "six digits differ by less than the other tolerance",
    "(xml.tag != 'mesh')": "meshes are passed as files only to spare time",
    "round(AHEAD / model.opt.timestep), 0)": "a step is shorter than 20 ms",
    "(*position, 0.0, 0.0, 1.0)[:3]": "of a position that is rejected",
    "(*position, 0.0, 1.0, 0.0)[:3]": "of a position that is rejected",
    ".mass or 2.0": "it stands for a mass that nothing declares",
    ".mass or 0.5": "it stands for a mass that nothing declares",
    "at_rest + 1 if slow else -1": "at rest one step of many later",
    "_SUSPECT = 6.0": "a quick test before the exact one",
    "_SUSPECT = 1.5": "a quick test before the exact one: no body has as much inertia",
    "MIN_FINAL_JERK = 0.2": "rare stops with scarce jerk take 0.1 % less time",
    "MIN_FINAL_JERK = 0.05": "rare stops with scarce jerk take 0.1 % more time",
    "MIN_FINAL_JERK = 0.0001": "rare stops with scarce jerk take 0.5 % more time",
    "along[-1] * rng.uniform() ** 4": "how long drawn shortcuts are: other distributions do, too",
    "(rng.uniform() < LOCAL_SHARE)": "the share is a half",
    "rise = np.concatenate([[1.0]": "a constant that is taken off again",
    "fall = np.concatenate([[1.0]": "a constant that is taken off again",
    "np.append(np.diff(v) / np.diff(t), 1.0)": "one node of a first guess, which is improved",
    "s_dot[:, np.newaxis])[:, -1]": "there is one path velocity for each node",
    "trajectory.profiles[-1]": "without intermediate positions Ruckig plans one section",
    "trajectory.profiles[0][-1]": "there is one joint",
    "ruckig.InputParameter(len(start[-1]))": "positions and accelerations are as many",
    "rows[-1] for rows in path.evaluate(np.array([s]))": "it is evaluated at one place",
    "rows[-1] for rows in second.sample(np.array([arrival]))": "it is sampled at one time",
    "self.extend(int(places.max()) + 2000)": "more nodes than are read",
    "s_dot) / (use)) ** 2": "taken where the use is above 1 only",
    "((v[3:-1] - v[1:-3]) * (2.0 * step))": "the whole profile is scaled to its end afterwards",
    "max(trajectory.duration - start, 1.0)": "after its end a trajectory rests",
    "_POWERS - np.arange(4)[:, None]": "derivatives that nothing reads",
    "for _ in range(120):  # halvings": "sixty end at rounding already",
    "np.arange(n + 1) / n, 1)[0]": "positions come first, whatever derivatives follow",
    "moved)) > (1.0 - ROUNDING)": "one rounding more or less",
    "slope = _quotient(-b, a, moves, 1.0)": "without bounds of u the slope does not count",
    "problems.insert(-1, ": "before the only other one",
    "max(1, ((n + 1)).bit_length())": "another order of the same checks",
    "max(2, (n - 1).bit_length())": "another order of the same checks",
    "[n or 2 for n in one]": "any size does where a policy takes any",
    "set_opening(opened, 2.0": "an opening beyond that of fully open fingers is theirs",
    "set_opening(opened, 1000.0": "an opening beyond that of fully open fingers is theirs",
    "reshape(len(array), -2)": "NumPy takes any negative length for the one that is left",
    "_time = 1.0  # [s] simulated": "set at each start, before anything reads it",
    "_op_num_threads = 0": "kernels that are deterministic give the same bits in more threads",
    "_op_num_threads = 2": "kernels that are deterministic give the same bits in more threads",
    "POSITION_ATTEMPTS = ": "how many random places are tried",
    "SIDES = ": "in how many directions the support around an object is looked at",
    "_GROUPS = ": "how many groups are simulated in turn: results do not depend on it",
    "START_TIME = ": "a timeout for machines under load, long after a start",
    "np_random.integers(": "which seed an environment without one draws",
    "LOCKING_FRICTION = 20000.0": "no torque or force of a cell overcomes half of it either",
    "LOCKING_FRICTION = 5000.0": "no torque or force of a cell overcomes it either",
    "LOST_GAIN = 1.0000000000000002e-12": "no gain, but a small number",
    "limit - 1.0000000000000002e-06": "against rounding of times",
    "limit - 1e-12": "against rounding of times",
    "due + step - 1.0000000000000002e-06": "against rounding of times",
    "due + step - 1e-12": "against rounding of times",
    "due - 1.0000000000000002e-06": "against rounding of times",
    "due - 1e-12": "against rounding of times",
    "* step - 1.0000000000000002e-06": "against rounding of times",
    "* step - 1e-12": "against rounding of times",
    "cell.time + 1.0000000000000002e-06": "against rounding of times",
    "cell.time + 1e-12": "against rounding of times",
    "_now.reshape(3, -2)": "NumPy takes any negative length for the one that is left",
    "waiting else 2": "all ticks are alike then",
    "np.arange(count), (count))": "in how many groups: results do not depend on it",
    "threads: int = ": "how many threads simulate: results do not depend on it",
    "_SYNCHRONY = (0.0025, ": "a coupling that is stiffer than needed",
    "_SYNCHRONY = (5e-06, ": "MuJoCo takes two control steps for what is shorter",
    "_SYNCHRONY = (0.005, 0.5": "a coupling that is damped a little less",
    "+ 5e-06 * np.eye(6)": "damping of the inverse near singularities only, by convention",
    "+ 2e-05 * np.eye(6)": "damping of the inverse near singularities only, by convention",
    "digits[-1].geoms[-1]])": "the tip of any finger stands for those of all",
    "np.array([0.299, 0.587, 0.114])": "grey of pictures that are black and white",
    'declared["colour"], default=': "a colour",
    '"fatol": 0.001': "the other tolerance decides when the search ends",
    'self._awaited, self._since = "", 1.0': "it is set when something is awaited",
    "(self.inset - self.distance) / towards": "the sign is 1 or -1",
    "_REACH = 0.6": "larger than any body of a gripper",
    "_REACH = 0.15": "larger than any body of a gripper",
    'default=(1.0, ""))[1]': "only the name of the leaf counts",
    "_SAMPLES = 2000  # random conf": "of how many random configurations the reach is estimated",
    "_SAMPLES = 500  # random conf": "of how many random configurations the reach is estimated",
    "default_rng(1), self.model.joint": "any seed will do for an estimate of the reach",
    "if (not self.limits_tool)": "without an arm the speed of the tool is not limited",
    "self._names[-1] is not": "names that are looked up again are the same",
    "self._ids[-1] is not": "ids that are looked up again are the same",
    "q[(1):]]))": "more samples than needed",
    "self._repeated = -1  #": "set at each start of a motion, before anything reads it",
    "self._repeated = 1  #": "set at each start of a motion, before anything reads it",
    "time.sleep(0.0001)": "how often it looks whether setpoints have passed",
    "time.sleep(0.0004)": "how often it looks whether setpoints have passed",
    "KEPT_SETPOINTS = 4096": "how many seconds of readings are kept for a parent that is busy",
    "KEPT_SETPOINTS = 16384": "how many seconds of readings are kept for a parent that is busy",
    "cam_quat[camera[-1]]": "a camera has one identifier",
    "mj_model.joint(name).dofadr[-1]": "a hinge or a slide has one address",
    "int(2.2 * duration / step)": "more rows of rest after the end",
    "refined.yaw + (0.0 if length": "the yaw of a rectangle is taken modulo half a turn",
    "camera.azimuth, camera.elevation = -145.0": "from where a picture is drawn",
    "height(result.q) > (_ROUNDING)": "against rounding",
}
"""Changes that cannot matter, by a part of the line before or after them, and why."""


class Mutant(NamedTuple):
    """A change of the text of a module between two offsets."""

    module: str
    line: int
    lines: range  # of the statement; none for what runs at import
    start: int
    end: int
    text: str
    number: int = -1  # in the draw


def variants(node: ast.AST, subscript: bool) -> Iterator[str]:
    """Yield the texts that may replace an expression."""
    match node:
        case ast.Constant(value=bool()):
            return
        case ast.Constant(value=int(value)):
            large = abs(value) > 10  # of such counts, one more or less is none the worse
            yield from map(str, (value * 2, value // 2) if large else (value + 1, value - 1))
            if value > 1 and not subscript:
                yield str(value * 1000)
        case ast.Constant(value=float(value)):
            if value and abs(value) < 1e-5:  # a tolerance: twice as much is none the worse
                yield from (repr(value * 1000), repr(value / 1000))
            elif value:
                yield from map(repr, (value * 2, value / 2, -value, value * 1000, value / 1000))
            else:
                yield "1.0"
        case ast.Attribute(value=ast.Name(id="np" | "math"), attr="nan"):
            yield "0.0"
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            yield f"({ast.unparse(operand)})"
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OPPOSITE:
            if any(isinstance(a, ast.Constant | ast.JoinedStr) and not is_number(a)
                   for a in (left, right)):  # fmt: skip
                return
            yield f"({ast.unparse(ast.BinOp(left, OPPOSITE[type(op)](), right))})"
            if isinstance(op, ast.Add | ast.Sub):
                yield f"({ast.unparse(left)})"
                yield f"({ast.unparse(right)})"
        case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in OPPOSITE:
            yield f"({ast.unparse(ast.Compare(left, [OPPOSITE[type(op)]()], [right]))})"
            if type(op) in BOUNDARY and any(is_count(a) for a in (left, right)):
                yield f"({ast.unparse(ast.Compare(left, [BOUNDARY[type(op)]()], [right]))})"
        case ast.BoolOp(op=op, values=values):
            if any(isinstance(value, ast.Compare) for value in values):
                for gone in range(len(values)):
                    kept = [v for index, v in enumerate(values) if index != gone]
                    new = kept[0] if len(kept) == 1 else ast.BoolOp(op, kept)
                    yield f"({ast.unparse(new)})"
        case ast.AugAssign(target=target, op=op, value=value) if type(op) in OPPOSITE:
            yield ast.unparse(ast.AugAssign(target, OPPOSITE[type(op)](), value))
        case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name), args=[first, *_]):
            function = ast.unparse(node.func)
            if name in SWAPPED:
                new = function[: -len(name)] + SWAPPED[name]
                yield new + ast.unparse(node)[len(function) :]
            if name in UNWRAPPED and not isinstance(first, ast.Starred):
                yield f"({ast.unparse(first)})"


def is_number(node: ast.AST) -> bool:
    """Return whether the node is a number, not text."""
    return isinstance(node, ast.Constant) and isinstance(node.value, int | float)


def is_count(node: ast.AST) -> bool:
    """Return whether the node is a whole number: elsewhere, < and <= differ by chance only."""
    return (isinstance(node, ast.Constant) and type(node.value) is int and node.value != 0) or (
        isinstance(node, ast.Call) and ast.unparse(node.func) == "len"
    )


def is_left_out(node: ast.AST) -> bool:
    """Return whether nothing is changed below a node: text, colours and formats."""
    match node:
        case ast.JoinedStr() | ast.Raise() | ast.Assert() | ast.Import() | ast.ImportFrom():
            return True
        case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name)):
            return name in SPOKEN
        case ast.Assign(targets=[target]) | ast.AnnAssign(target=target):
            return bool(DRAWN.search(ast.unparse(target)))
        case ast.keyword(arg=str(name)):
            return bool(DRAWN.search(name))
    return False


def mutants_of(module: str, text: str) -> Iterator[list[Mutant]]:
    """Yield the changes of each place of a module."""
    starts = [0]
    for line in text.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    pending: list[tuple[Any, bool, range]] = [(ast.parse(text), False, range(0))]
    while pending:
        node, subscript, lines = pending.pop()
        if is_left_out(node):
            continue
        texts = list(variants(node, subscript))
        if texts:
            start = starts[node.lineno - 1] + node.col_offset
            end = starts[node.end_lineno - 1] + node.end_col_offset
            yield [Mutant(module, node.lineno, lines, start, end, new) for new in texts]
        for name, value in ast.iter_fields(node):
            if name in ("annotation", "returns", "decorator_list", "type_params"):
                continue
            below = subscript or (isinstance(node, ast.Subscript) and name == "slice")
            for child in value if isinstance(value, list) else [value]:
                reached = lines
                if isinstance(child, ast.stmt) and is_deferred(node, name, lines):
                    body = getattr(child, "body", None)
                    end = body[0].lineno if body else child.end_lineno + 1
                    reached = range(child.lineno, max(end, child.lineno + 1))
                if isinstance(child, ast.AST):
                    pending.append((child, below, reached))


def is_deferred(node: ast.AST, name: str, lines: range) -> bool:
    """Return whether a statement below the node runs in a call, not at import."""
    return len(lines) > 0 or (isinstance(node, ast.FunctionDef) and name == "body")


def mutated(mutant: Mutant, source: bytes) -> bytes:
    """Return the module with the change."""
    return source[: mutant.start] + mutant.text.encode() + source[mutant.end :]


def numeric_modules() -> list[str]:
    """Return the modules with numeric code, relative to the root."""
    paths = [*ROOT.glob("bt_manip/**/*.py"), *ROOT.glob("plugins/*/bt_manip_*/**/*.py")]
    names = sorted(str(path.relative_to(ROOT)) for path in paths)
    return [
        name
        for name in names
        if NUMERIC.search((ROOT / name).read_text()) and not NOT_NUMERIC.search(name)
    ]


def is_argued(mutant: Mutant) -> bool:
    """Return whether a change is one that cannot matter."""
    source = (ROOT / mutant.module).read_bytes()
    before, after = source.splitlines(), mutated(mutant, source).splitlines()
    lines = (before[mutant.line - 1] + after[mutant.line - 1]).decode()
    return any(part in lines for part in ARGUED)


def draw(seed: int, count: int) -> list[Mutant]:
    """Draw places, and for each one of its changes; changes elsewhere leave the draw as it is."""
    drawn: dict[str, Mutant] = {}
    for module in numeric_modules():
        source = (ROOT / module).read_bytes()
        seen: dict[str, int] = {}
        for place in mutants_of(module, source.decode()):
            text = f"{seed} {module} {source[place[0].start : place[0].end].decode()}"
            seen[text] = seen.get(text, 0) + 1
            key = digest(f"{text} {seen[text]}".encode())
            drawn[key] = place[int(key, 16) % len(place)]
    keys = sorted(drawn)[:count]
    return [drawn[key]._replace(number=number) for number, key in enumerate(keys)]


# As a plugin of pytest, it records which test reaches which lines.

_seconds: dict[str, float] = {}
_spoiled: set[str] = set()


def pytest_runtest_logstart(nodeid: str, location: Any) -> None:
    """Count the lines from here on for the test."""
    import coverage

    if measured := coverage.Coverage.current():
        measured.switch_context(nodeid)


def pytest_runtest_logreport(report: Any) -> None:
    """Add the duration of a phase of a test, and remember tests that do not pass."""
    _seconds[report.nodeid] = _seconds.get(report.nodeid, 0.0) + report.duration
    if not report.passed:
        _spoiled.add(report.nodeid)


def pytest_unconfigure(config: Any) -> None:
    """Write the durations of the tests that passed."""
    if path := os.environ.get("MUTANTS_SECONDS"):
        passed = {test: value for test, value in _seconds.items() if test not in _spoiled}
        Path(path).write_text(json.dumps(passed))


LIBRARIES = ("numpy", "mujoco", "pinocchio", "dm_control.composer", "trimesh", "ruckig", "scipy")


class Copy:
    """A copy of the checkout, in which changed modules are tested."""

    def __init__(self, number: int) -> None:
        self.root = STORE / f"copies-{os.getpid()}" / str(number)
        listed = subprocess.run(
            ["git", "ls-files", "-co", "--exclude-standard", "-z"],
            cwd=ROOT, check=True, capture_output=True, text=True,
        )  # fmt: skip
        for name in filter(None, listed.stdout.split("\0")):
            if (ROOT / name).is_file():
                (self.root / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, self.root / name)
        compileall.compile_dir(self.root, quiet=2)
        shared = self.root.parent / "shared"  # where tests look for the models of others
        if (ROOT.parent / "shared").exists() and not shared.exists():
            shared.symlink_to((ROOT.parent / "shared").resolve())
        folders = [self.root, *sorted(self.root.glob("plugins/*"))]
        self.environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join(map(str, folders)),
            "PYTHONDONTWRITEBYTECODE": "1",
            "BT_MANIP_CACHE": str(self.root / "cache"),
        }

    def test(self, arguments: list[str], seconds: float) -> tuple[int | None, str]:
        """Run pytest in a fork, which has the libraries already; no exit code: it took too long."""
        with tempfile.TemporaryFile() as output:
            if (process := os.fork()) == 0:
                os.setsid()
                resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 60, int(seconds) + 65))
                os.chdir(self.root)
                os.environ.update(self.environment)
                sys.path[:0] = self.environment["PYTHONPATH"].split(os.pathsep)
                sys.dont_write_bytecode = True
                for stream in (1, 2):
                    os.dup2(output.fileno(), stream)
                try:
                    code = int(pytest.main(arguments, [Budget(seconds)]))
                    sys.stdout.flush()
                finally:
                    os._exit(code)
            deadline = time.monotonic() + 20 * (seconds + 60)  # others may use the processor, too
            while not (ended := os.waitpid(process, os.WNOHANG))[0]:
                time.sleep(0.02)
                if time.monotonic() > deadline:
                    os.killpg(process, signal.SIGKILL)
            output.seek(0)
            code = os.waitstatus_to_exitcode(ended[1])
            return (code if code >= 0 else None), output.read().decode(errors="replace")


class Budget:
    """Leaves out tests, as a plugin of pytest, when others have taken some processor time [s]."""

    def __init__(self, seconds: float) -> None:
        self._end = sum(os.times()[:4]) + seconds

    def pytest_runtest_protocol(self, item: Any) -> bool | None:
        """Return true for a test that is left out."""
        return True if sum(os.times()[:4]) > self._end else None


class Near:
    """The files of tests that are nearest to a change by their names and words."""

    FILES = 8

    def __init__(self, folders: list[str]) -> None:
        paths = sorted(path for folder in folders for path in (ROOT / folder).rglob("test_*.py"))
        self._texts = {str(path.relative_to(ROOT)): path.read_text() for path in paths}
        self.seconds = dict.fromkeys(self._texts, 0.0)

    def tests_of(self, mutant: Mutant) -> list[str]:
        """Return the files, the nearest first."""
        package, stem = os.path.split(mutant.module.removesuffix(".py"))
        home = "/".join(mutant.module.split("/")[:2]).replace("bt_manip/", "tests/") + "/"
        dotted = re.sub(r"^plugins/[^/]*/", "", f"{package}/{stem}").replace("/", ".")
        words = set(re.findall(r"[a-z]+", dotted)) - {"bt", "manip"}
        name = next(
            ast.unparse(getattr(node, "targets", [node])[0])
            if isinstance(node, ast.Assign)
            else getattr(node, "name", stem)
            for node in ast.parse((ROOT / mutant.module).read_text()).body
            if node.lineno <= mutant.line <= node.end_lineno
        )

        def nearness(test: str) -> int:
            named = re.search(rf"\b{name}\b", self._texts[test])
            return (
                4 * bool(named)
                + 3 * (dotted in self._texts[test])
                + 2 * test.startswith(home)
                + len(words.intersection(re.findall(r"[a-z]+", test)))
                + len(words.intersection(re.findall(r"[a-z]+", test.rpartition("/")[2])))
            )

        near = sorted(self._texts, key=lambda test: (-nearness(test), len(self._texts[test])))
        return [test for test in near[: self.FILES] if nearness(test) > 1]


class Reach:
    """Which tests reach which lines, by folders of tests."""

    def __init__(self, folders: list[str]) -> None:
        import coverage

        self._data, self._sources, self.seconds = [], [], {}
        for folder in folders:
            base = STORE / "reach" / folder.replace("/", "+")
            if not base.exists():
                continue
            record = json.loads(base.with_name(f"{base.name}.json").read_text())
            data = coverage.CoverageData(basename=str(base))
            data.read()
            self._data.append(data)
            self._sources.append(record["sources"])
            self.seconds |= record["seconds"]

    def tests_of(self, mutant: Mutant) -> list[str]:
        """Return the tests that reach the line, the nearest and quickest first."""
        text = (ROOT / mutant.module).read_bytes()
        tests: set[str] = set()
        for data, sources in zip(self._data, self._sources, strict=True):
            by_line: dict[int, set[str]] = {}
            for name in data.measured_files():
                if name.endswith(f"/{mutant.module}"):
                    for line, contexts in data.contexts_by_lineno(name).items():
                        by_line.setdefault(line, set()).update(contexts)
            known = mutant.lines and sources.get(mutant.module) == digest(text)
            for line in mutant.lines if known else by_line:
                tests.update(by_line.get(line, ()))
        words = set(re.findall(r"[a-z]+", mutant.module))

        def distance(test: str) -> tuple[int, float, str]:
            path = re.findall(r"[a-z]+", test.partition("::")[0])
            return -len(words.intersection(path)), self.seconds[test], test

        return sorted((test for test in tests if test in self.seconds), key=distance)


def digest(text: bytes) -> str:
    """Return a short hash."""
    return hashlib.sha256(text).hexdigest()[:16]


def folders_of_tests() -> list[str]:
    """Return the folders whose tests are recorded together."""
    folders = [path for path in ROOT.glob("tests/*") if list(path.glob("test_*.py"))]
    folders += ROOT.glob("plugins/*/tests")
    return sorted(str(path.relative_to(ROOT)) for path in folders)


def record(folder: str, copy: Copy) -> None:
    """Record which lines the tests of a folder reach, those of new and changed files."""
    base = STORE / "reach" / folder.replace("/", "+")
    described, seconds = (base.with_name(base.name + end) for end in (".json", ".seconds"))
    before: dict[str, dict[str, Any]] = {"tests": {}, "sources": {}, "seconds": {}}
    if described.exists():
        before = json.loads(described.read_text())
    paths = sorted((ROOT / folder).rglob("test_*.py"))
    tests = {str(path.relative_to(ROOT)): digest(path.read_bytes()) for path in paths}
    changed = [test for test, key in tests.items() if before["tests"].get(test) != key]
    if not changed:
        return
    print(f"recording {len(changed)} files of {folder}", flush=True)
    base.parent.mkdir(parents=True, exist_ok=True)
    seconds.unlink(missing_ok=True)
    begin = time.monotonic()
    arguments = ["-m", "coverage", "run", "--append", f"--data-file={base}", "--rcfile=/dev/null",
                 "--include=*/bt_manip/*,*/bt_manip_*/*", "-m", "pytest", "-q", "-p", "mutants",
                 "-p", "no:cacheprovider", "-p", "no:xdist", *changed]  # fmt: skip
    path = f"{copy.environment['PYTHONPATH']}{os.pathsep}{copy.root / 'tools'}"
    environment = {**copy.environment, "PYTHONPATH": path, "MUTANTS_SECONDS": str(seconds)}
    subprocess.run([sys.executable, *arguments], cwd=copy.root, env=environment)
    print(f"{time.monotonic() - begin:.0f} s", flush=True)
    sources = {module: digest((ROOT / module).read_bytes()) for module in numeric_modules()}
    for module, key in before["sources"].items():
        if sources.get(module) != key:
            sources[module] = ""  # the lines of earlier records have moved
    passed = json.loads(seconds.read_text()) if seconds.exists() else {}
    kept = {*tests} - {*changed}
    known = {test: s for test, s in before["seconds"].items() if test.partition("::")[0] in kept}
    now = {"tests": tests, "sources": sources, "seconds": known | passed}
    described.write_text(json.dumps(now))


class Judge:
    """Tests changes in a copy, in a process of its own."""

    def __init__(self, copies: Any, near: bool, folders: list[str], budget: float) -> None:
        # Coverage erases data that is used in a fork of the process that has read it.
        self._reach = Near(folders) if near else Reach(folders)
        self._copy, self._budget = copies.get(), budget

    def verdict(self, mutant: Mutant) -> str:
        """Return how the tests took a change: an empty text if one noticed it."""
        tests, total = [], 0.0
        reaching = self._reach.tests_of(mutant)
        for test in reaching:
            if not tests or total + self._reach.seconds[test] <= self._budget:
                tests.append(test)
                total += self._reach.seconds[test]
        if not tests:
            return "no test reaches it"
        target = self._copy.root / mutant.module
        original = target.read_bytes()
        target.write_bytes(mutated(mutant, original))
        try:
            arguments = ["-q", "-x", "-p", "no:cacheprovider", "-p", "no:xdist", *tests]
            code, output = self._copy.test(arguments, 3 * total or self._budget)
        finally:
            target.write_bytes(original)
        if code == 0:
            return f"{len(tests)} of {len(reaching)} near tests pass"
        failed = re.findall(r"^(?:FAILED|ERROR) (\S+)", output, re.MULTILINE)
        if code == pytest.ExitCode.INTERNAL_ERROR:  # a plugin, such as fixtures, cannot be imported
            failed = re.findall(rf"^{mutant.module}:\d+: in <module>", output, re.MULTILINE)
        if code is not None and not failed:
            return f"pytest ended with {code}: {output[-200:]}"
        with (STORE / "noticed.log").open("a") as log:
            place = f"{mutant.number} {mutant.module}:{mutant.line}"
            log.write(f"{place} {mutant.text}: {failed or 'too long'}\n")
        return ""


def start(*arguments: Any) -> None:
    """Begin a process that judges."""
    global _judge
    _judge = Judge(*arguments)


def try_one(mutant: Mutant) -> tuple[str, float]:
    """Return the verdict on a change, and how long it took [s]."""
    begin = time.monotonic()
    return _judge.verdict(mutant), time.monotonic() - begin


def main() -> int:
    """Print the changes that no test noticed, and the share of noticed ones by package."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--numbers", nargs="+", metavar="N-M", default=["0-999999"])
    parser.add_argument("--only", default="")
    parser.add_argument("--budget", type=float, default=20.0)
    parser.add_argument("--near", action="store_true")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--tests", nargs="+", metavar="FOLDER", default=folders_of_tests())
    options = parser.parse_args()
    os.environ.setdefault("MUJOCO_GL", "disable")
    for library in LIBRARIES:
        importlib.import_module(library)
    context = multiprocessing.get_context("fork")
    copies = [Copy(number) for number in range(options.workers)]
    try:
        for folder in options.tests if not options.near else ():
            record(folder, copies[0])
        waiting = context.SimpleQueue()
        for copy in copies:
            waiting.put(copy)
        mutants = [
            mutant
            for mutant in draw(options.seed, options.count)
            if any(mutant.number in numbers for numbers in map(numbers_of, options.numbers))
            and re.search(options.only, mutant.module)
        ]
        argued = [mutant for mutant in mutants if is_argued(mutant)]
        mutants = [mutant for mutant in mutants if mutant not in argued]
        print(f"{len(argued)} argued: cannot matter")
        given = (waiting, options.near, options.tests, options.budget)
        with context.Pool(options.workers, start, given) as pool:
            report(mutants, pool.imap(try_one, mutants), options.seed)
    finally:
        shutil.rmtree(copies[0].root.parent, ignore_errors=True)
    return 0


def numbers_of(text: str) -> range:
    """Return the numbers from N to M of ``N-M``, or N alone."""
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def report(mutants: list[Mutant], verdicts: Iterator[tuple[str, float]], seed: int) -> None:
    """Print each change that was not noticed, and then the counts."""
    counts: dict[str, list[bool]] = {}
    for mutant, (verdict, seconds) in zip(mutants, verdicts, strict=True):
        counts.setdefault("/".join(mutant.module.split("/")[:2]), []).append(not verdict)
        if verdict:
            source = (ROOT / mutant.module).read_bytes()
            old = source.splitlines()[mutant.line - 1].decode().strip()
            new = mutated(mutant, source).splitlines()[mutant.line - 1].decode().strip()
            print(f"{mutant.number} {mutant.module}:{mutant.line}: {verdict} ({seconds:.0f} s)")
            print(f"- {old}\n+ {new}")
            sys.stdout.flush()
    for package, noticed in sorted(counts.items()):
        print(f"{sum(noticed):4} of {len(noticed):4} noticed  {package}")
    everything = sum(counts.values(), [])
    print(f"{sum(everything)} of {len(everything)} noticed with seed {seed}")


if __name__ == "__main__":
    sys.exit(main())
