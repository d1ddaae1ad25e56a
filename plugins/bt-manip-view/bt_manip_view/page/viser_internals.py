"""All uses of names of viser that are not public, or of the layout of its client.

Dependencies pin the minor version of viser; a test names the version that this was checked against.
"""

from collections.abc import Collection
from pathlib import Path
from typing import Any

import msgspec
import viser
import viser._messages as viser_messages

UNUSED = (
    viser_messages.ShareUrlRequest,  # would connect to a server of viser
    viser_messages.ShareUrlDisconnect,
    viser_messages.FileTransferStartUpload,
    viser_messages.FileTransferPart,
    viser_messages.GuiUpdateMessage,  # the page has the inputs
    viser_messages.GuiFormDirtyMessage,  # would be forwarded to all browsers unchecked
    viser_messages.GuiFormSubmitMessage,
)
"""Messages of viser without effect here."""

STYLE = """<style>
[data-floating-window],.mantine-Notifications-root{display:none!important}
canvas[data-engine]{background:linear-gradient(#d6e2f0,#f6f8fa)}
[data-theme=dark] canvas[data-engine]{background:linear-gradient(#10141a,#23272e)}
</style>"""
"""Hides viser's own panel, as the page has the inputs; sky behind the scene, light or dark."""

SCENE_PROTOCOL = f"viser-v{viser.__version__}"
"""Subprotocol of the scene's sockets."""

CLIENT = Path(viser.__file__).parent / "client" / "build" / "index.html"


def ignore_unused_messages(server: viser.ViserServer) -> None:
    """Let the `UNUSED` messages have no effect."""
    for kind in UNUSED:
        server._websock_server.unregister_handler(kind)


def connections(server: viser.ViserServer) -> Collection[Any]:
    """Return the open connections of browsers."""
    return server._websock_server._live_connections.values()


def check_message(message: Any) -> None:
    """Raise an exception unless data are the fields of a message of viser, of the right types."""
    kind = getattr(viser_messages, message["type"])
    if not issubclass(kind, viser_messages.Message):
        raise TypeError(f"{kind} is no message")
    fields = {key: value for key, value in message.items() if key != "type"}
    msgspec.convert(fields, kind)
    if not fields.keys() <= kind.__dataclass_fields__.keys():
        raise ValueError("it has further fields")


def client_html() -> str:
    """Return viser's client without its panel."""
    return CLIENT.read_text().replace("</head>", f"{STYLE}</head>", 1)
