"""Coming to rest on the path, as soon as the limits allow.

`brake` finds a clock that brings a motion to rest. `halting` brakes as hard as each moment allows;
`programme` weighs all moments at once, for when that leads nowhere. The one looks at the limits by
`clock_limits`, the other by `near_clock`: there a `Clock` is what linear programmes change.
"""

from .brake import brake as brake
from .brake import clock_along as clock_along
from .brake import halt as halt
