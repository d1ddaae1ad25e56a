"""What the package brings; everything expensive is imported when it is needed."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any

from bt_manip import hookimpl
from bt_manip.parameters import Parameter

if TYPE_CHECKING:
    from bt_manip.cli import Session
    from bt_manip_groot.publisher import GrootPublisher


def groot(
    session: "Session",
    *,
    port: Annotated[
        int,
        Parameter(
            "Port to which Groot2 connects; the next one must be free, too.",
            at_least=1,
            at_most=65534,
        ),
    ] = 1667,
) -> "GrootPublisher":
    """Let Groot2 on this computer monitor the run, set breakpoints and replace statuses."""
    from bt_manip_groot.publisher import GrootPublisher

    publisher = GrootPublisher(port, session.tell, stays=session.stays)
    session.tell(f"Groot2 can connect to 127.0.0.1, port {port}.")
    return publisher


@hookimpl
def register_views(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Bring the publisher that Groot2 connects to."""
    register("groot", groot)


@hookimpl
def register_recorders(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Bring the log files."""
    from bt_manip_groot.log_files import BtlogRecorder, SqliteRecorder

    register("btlog", BtlogRecorder)
    register("db3", SqliteRecorder)


@hookimpl(optionalhook=True)
def register_export_formats(register: Callable[[str, Callable[..., None]], None]) -> None:
    """Bring the log files of recordings."""
    from bt_manip_groot.log_files import BtlogRecorder, SqliteRecorder

    register("btlog", BtlogRecorder.export)
    register("db3", SqliteRecorder.export)
