"""Refuse what searches cannot be asked with, before anything is searched."""

from math import inf
from typing import Any

import numpy as np

from bt_manip.exceptions import MotionError
from bt_manip.number_checks import check_amount, check_count, check_generator, check_positive, shown
from bt_manip.robots import RobotModel

from .targets import Target


def check_arm(model: Any) -> RobotModel:
    """Give the model of an arm back.

    Raises:
        MotionError: When it is none.
    """
    if not isinstance(model, RobotModel):
        raise MotionError(
            "the model of an arm is a RobotModel, as Robot.make_model gives it, "
            f"got {type(model).__name__}",
            reason="target",
        )
    return model


def check_following(max_step: Any, margin: Any, tolerance: Any, detours: Any) -> None:
    """Refuse a box that nothing can be followed in.

    Args:
        max_step: Half its sides [rad].
        margin: From the limits [rad].
        tolerance: Of a solution [m] and [rad]; None for that of the arm.
        detours: Whether to try again from elsewhere.

    Raises:
        MotionError: Naming the one that is wrong.
    """
    # Lines are followed in many steps, so that plain numbers are let through fast.
    if (
        type(max_step) is type(margin) is float
        and type(detours) is bool
        and 0.0 < max_step < inf
        and 0.0 <= margin < inf
        and (tolerance is None or (type(tolerance) is float and 0.0 < tolerance < inf))
    ):
        return
    check_positive(max_step, "max_step", "rad")
    check_amount(margin, "a margin", "rad")
    if tolerance is not None:
        check_positive(tolerance, "a tolerance", "m, rad")
    if not isinstance(detours, bool | np.bool_):
        raise MotionError(f"detours is True or False, got {shown(detours)}", reason="target")


def check_listing(starts: Any, margin: Any, distinct: Any, rng: Any) -> None:
    """Refuse what no solutions can be listed with.

    Args:
        starts: How many further configurations to start from.
        margin: From the limits [rad].
        distinct: How far solutions are apart [rad].
        rng: What further configurations are drawn from; None for a new generator.

    Raises:
        MotionError: Naming the one that is wrong.
    """
    check_count(starts, "starts")
    check_amount(margin, "a margin", "rad")
    check_amount(distinct, "distinct", "rad")
    if rng is not None:
        check_generator(rng)


def refuse_beside_problem(margin: float, tolerance: float | None) -> None:
    """Refuse what a problem says itself.

    Raises:
        MotionError: When there is any.
    """
    if margin:
        raise MotionError(
            f"a problem has a margin of its own, got {margin!r} beside it: "
            "ask for IKProblem(margin=...)",
            reason="target",
        )
    if tolerance is not None:
        raise MotionError(
            f"each target of a problem has its own tolerance, got {tolerance!r} beside them: "
            "ask for PoseTarget(tolerance=...)",
            reason="target",
        )


def refuse_target(request: Any) -> None:
    """Refuse a target that is asked for without a problem.

    Raises:
        MotionError: Saying how to ask for it.
    """
    if isinstance(request, Target):
        raise MotionError(
            f"a request is a pose or a problem, got {request.label} alone: "
            f"ask for IKProblem(targets={type(request).__name__}(...))",
            reason="target",
        ) from None
