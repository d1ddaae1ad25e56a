"""Lifting of the held object."""

import numpy as np
import pinocchio as pin

from bt_manip.bt import Traits
from bt_manip.exceptions import MotionError

from .arm_behaviour import MotionBehaviour, blend_radius_input, speed_input
from .automatic import number_or_auto

LIFT_HEIGHT = 0.4  # [m] if within reach
MIN_HEIGHT = 0.03  # [m] smallest lift
FOLLOWED_PART = 0.9  # fraction of the feasible path that is used: joints turn fast near its end


class Lift(MotionBehaviour):
    """Raise the tool straight up by a height."""

    traits = Traits(commands={"arm"}, leaves={"at_object": None})

    blend_radius = blend_radius_input()
    height = number_or_auto("Height [m]; auto: 0.4, or as far as it reaches.", at_least=0.0)
    least = number_or_auto(
        "Smallest accepted height if the arm reaches no higher [m]; auto: the whole height, or "
        "0.03 if `height` is auto."
    )
    speed = speed_input()

    def start(self) -> None:
        """Move up the vertical through the tool."""
        height, least = self.height, self.least
        if least is None:
            least = MIN_HEIGHT if height is None else height
        height = LIFT_HEIGHT if height is None else height
        T_wt = self.T_wt
        while True:
            up = T_wt.translation + np.array([0.0, 0.0, height])
            try:
                return self.arm.move_linear(pin.SE3(T_wt.rotation, up), speed=self.speed)
            except MotionError as error:
                height *= FOLLOWED_PART * (error.fraction or 0.0)
                if not height >= least:  # also for NaN
                    raise
