"""A real client, and the server that it starts over standard input and output."""

import json
import os
import sys
from collections.abc import Callable
from contextlib import asynccontextmanager
from typing import Any

import pytest

pytest.importorskip("mcp")

import anyio  # noqa: E402
from mcp import ClientSession, StdioServerParameters  # noqa: E402
from mcp.client.stdio import stdio_client  # noqa: E402


class Server:
    """A server, as its client sees it."""

    def __init__(self, session: ClientSession) -> None:
        self.session = session

    async def call(self, tool: str, **arguments: Any) -> Any:
        """Return the content of a result: the parts of a list, or of one text its JSON or text."""
        result = await self.session.call_tool(tool, arguments)
        assert not result.is_error, result.content
        (first, *others) = result.content
        try:
            found = json.loads(first.text)
        except ValueError:
            found = first.text
        return (found, *others) if others else found

    async def refusal(self, tool: str, **arguments: Any) -> str:
        """Return the text of an error."""
        result = await self.session.call_tool(tool, arguments)
        assert result.is_error, result.content
        return str(result.content[0].text)


@pytest.fixture
def served(tmp_path) -> Callable[..., Any]:
    """Run a client against a server of the folder of the test, with these options."""

    def served(client: Callable[[Server], Any], *options: object) -> Any:
        folder = tmp_path / "folder"
        folder.mkdir(exist_ok=True)
        arguments = ["-m", "bt_manip", "mcp", "--folder", folder, *options]
        environment = {key: value for key, value in os.environ.items() if key != "MUJOCO_GL"}
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, sys.path))
        parameters = StdioServerParameters(
            command=sys.executable, args=[str(one) for one in arguments], env=environment
        )

        async def run() -> Any:
            with anyio.fail_after(240):
                async with _connected(parameters) as server:
                    return await client(server)

        return anyio.run(run)

    return served


@asynccontextmanager
async def _connected(parameters: StdioServerParameters):
    async with stdio_client(parameters) as (read, write), ClientSession(read, write) as session:
        await session.initialize()
        yield Server(session)
