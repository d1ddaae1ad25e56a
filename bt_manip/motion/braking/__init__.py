"""Coming to rest on the path, as soon as the limits allow.

`brake` finds a clock that brings a motion to rest. `halting` brakes as hard as each moment allows;
`programme` weighs all moments at once, for when that leads nowhere. Both look at limits along the
path by `clock_limits`.
"""

from .brake import brake, clock_along, halt

__all__ = ["brake", "clock_along", "halt"]
