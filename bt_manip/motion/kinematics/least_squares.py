"""The damped least-squares step, with few calls."""

import eigenpy
import numpy as np


def damped_step(jacobian: np.ndarray, error: np.ndarray, damping: float) -> np.ndarray:
    """Give ``J^T (J J^T + damping I)^-1 error``, by the smaller of both square matrices.

    Where J has more rows than columns this is ``(J^T J + damping I)^-1 J^T error``, the same.

    Args:
        jacobian: J.  # (m, nv)
        error: What the step shall make up for.  # (m,)
        damping: Above 0 where the rows depend on each other.
    """
    m, nv = jacobian.shape
    if m > nv:
        square = jacobian.T.dot(jacobian)
        square.ravel()[:: nv + 1] += damping
        return eigenpy.LLT(square).solve(jacobian.T.dot(error))  # (nv,)
    square = jacobian.dot(jacobian.T)
    square.ravel()[:: m + 1] += damping
    return jacobian.T.dot(eigenpy.LLT(square).solve(error))  # (nv,)
