"""The built-in nodes around one child."""

from bt_manip.bt.nodes.decorators.conditional import Precondition as Precondition
from bt_manip.bt.nodes.decorators.conditional import RunOnce as RunOnce
from bt_manip.bt.nodes.decorators.conditional import SkipUnlessUpdated as SkipUnlessUpdated
from bt_manip.bt.nodes.decorators.conditional import WaitValueUpdate as WaitValueUpdate
from bt_manip.bt.nodes.decorators.forcing import ForceFailure as ForceFailure
from bt_manip.bt.nodes.decorators.forcing import ForceSuccess as ForceSuccess
from bt_manip.bt.nodes.decorators.forcing import Inverter as Inverter
from bt_manip.bt.nodes.decorators.forcing import KeepRunningUntilFailure as KeepRunningUntilFailure
from bt_manip.bt.nodes.decorators.loop import LoopBool as LoopBool
from bt_manip.bt.nodes.decorators.loop import LoopDouble as LoopDouble
from bt_manip.bt.nodes.decorators.loop import LoopInt as LoopInt
from bt_manip.bt.nodes.decorators.loop import LoopString as LoopString
from bt_manip.bt.nodes.decorators.repeat import Repeat as Repeat
from bt_manip.bt.nodes.decorators.repeat import RetryUntilSuccessful as RetryUntilSuccessful
from bt_manip.bt.nodes.decorators.timing import Delay as Delay
from bt_manip.bt.nodes.decorators.timing import Timeout as Timeout
