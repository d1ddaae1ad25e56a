"""Names of viser that are not public are those of the version that they were checked against."""

import re
from pathlib import Path

import pytest
import viser

import bt_manip_view
from bt_manip_view.page import viser_internals
from bt_manip_view.page.server import close_server, open_server

CHECKED = "1.1.1"
"""Version of viser in which all names of `viser_internals` were looked up."""

PRIVATE = re.compile(r"viser\._|_websock_server|_live_connections|client.{1,5}build")


def test_the_version_is_the_one_that_was_checked():
    assert viser.__version__ == CHECKED, "look at viser_internals.py, then change CHECKED"


def test_only_one_module_uses_private_names():
    package = Path(bt_manip_view.__file__).parent
    using = {file.name for file in package.rglob("*.py") if PRIVATE.search(file.read_text())}
    assert using == {"viser_internals.py"}


def test_the_names_are_there():
    server = open_server(0)
    try:
        assert not viser_internals.connections(server)
    finally:
        close_server(server)
    assert viser_internals.STYLE in viser_internals.client_html()
    message = {"type": "ViewerCameraMessage", "wxyz": 3}
    with pytest.raises(Exception, match="wxyz|missing"):
        viser_internals.check_message(message)
