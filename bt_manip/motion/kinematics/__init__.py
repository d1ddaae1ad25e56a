"""Inverse kinematics: problems that one states, and what solves them."""

from .inverse_kinematics import InverseKinematics as InverseKinematics
from .result import IKResult as IKResult
