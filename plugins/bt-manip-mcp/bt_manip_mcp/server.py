"""The server: its tools run commands of bt-manip, and return the JSON that they print."""

import importlib.util
import json
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Annotated, Any, Final
from uuid import uuid4

import anyio
from mcp.server.mcpserver import Image, MCPServer
from mcp.server.mcpserver.exceptions import ToolError
from pydantic import Field

from bt_manip_mcp.limits import Limits
from bt_manip_mcp.warm_process import WarmProcess

MAX_FILE: Final = 16_000_000
"""Size of the largest file that is read or written [bytes]."""

INSTRUCTIONS: Final = """\
Behaviour trees for simulated robot arms (bt-manip). Trees are XML in the format of BehaviorTree.CPP
4. List behaviours with list_parts, write a tree, check it, run it with a few seeds, then evaluate
it. The physics, not the tree, judges the goal that a tree declares by _goal. A finding has file,
line and column; its suggestion, where there is one, is an edit. All files are in one folder.
"""

WRITE: Final = """\
Write a behaviour tree that does this: {task}

1. list_parts of the kinds behaviours, objects, scenes and trees; a name describes one of them. Use
   only behaviours that are listed. A registered tree shows what a working one is like.
2. Declare the goal: <BehaviorTree ID="Main" _goal="IsIn object={{c}} container=basket">.
3. write_tree, then check_tree with the scene, until it has no findings.
4. run_tree with seeds 0 to 4. Where it fails, picture_of_end shows the cell; change the tree.
5. evaluate_tree tells the success rate. Report it with its interval, also if it is low.
"""

REPAIR: Final = """\
Repair the behaviour tree {tree}.

1. read_tree and check_tree. Apply the suggestion of each finding that has one: from the place of
   the suggestion, or else of the finding, the first occurrence of `replace` as a whole word becomes
   `with`. Check again, until none is left.
2. run_tree with seeds 0 to 4. The report names the node that failed and the reason; picture_of_end
   shows the cell then. Change as little as possible, and never the goal.
3. evaluate_tree; report what was wrong, what you changed, and the success rate with its interval.
"""

Tree = Annotated[str, Field(description="A registered name, path.xml, or path.xml:TREE.")]
Scene = Annotated[str, Field(description="A registered scene or path.toml; empty: the tree's.")]
Robot = Annotated[str, Field(description="A registered robot or path.toml; empty: the default.")]
Settings = Annotated[
    dict[str, str | int | float | bool] | None, Field(description="Keys that the tree declares.")
]
Document = Annotated[str, Field(description="Path of an .xml file in the folder.")]


def serve(limits: Limits) -> None:
    """Serve the client at standard input and output until it closes the connection."""
    with (
        closing(WarmProcess(limits)) as commands,
        closing(WarmProcess(limits, draws=True)) as pictures,
    ):
        _make_server(Tools(limits, commands, pictures)).run("stdio")


def _make_server(tools: "Tools") -> MCPServer:
    server = MCPServer("bt-manip", instructions=INSTRUCTIONS, log_level="WARNING")
    offered: list[Callable[..., Any]] = [
        tools.list_parts, tools.list_tasks, tools.read_tree, tools.write_tree, tools.check_tree,
        tools.run_tree, tools.evaluate_tree, tools.read_report, tools.picture_of_end,
    ]  # fmt: skip
    if importlib.util.find_spec("bt_manip_stress") is not None:
        offered.append(tools.stress_tree)
    for tool in offered:
        server.add_tool(tool, structured_output=False)

    @server.prompt()
    def write_a_tree(task: str) -> str:
        """Write a tree for a task, and measure it."""
        return WRITE.format(task=task)

    @server.prompt()
    def repair_this_tree(tree: str) -> str:
        """Find what is wrong with a tree, and repair it."""
        return REPAIR.format(tree=tree)

    return server


class Tools:
    """The tools of a server; their docstrings are what the client reads.

    Args:
        limits: What a client may ask for.
        commands: Runs commands.
        pictures: Runs those that draw.
    """

    def __init__(self, limits: Limits, commands: WarmProcess, pictures: WarmProcess) -> None:
        self._limits, self._commands, self._pictures = limits, commands, pictures

    async def list_parts(self, kind: str = "behaviours", name: str = "") -> str:
        """List parts of a kind, or describe one with its ports or parameters.

        Kinds: trees, behaviours, objects, robots, grippers, controllers, planners, scenes.
        """
        for text in filter(None, (kind, name)):
            if text.startswith("-") or "\0" in text:
                raise ToolError(f"refused: {text!r} is no name")
        return await self._run("list", "--", *filter(None, (kind, name)))

    async def list_tasks(self, robots: list[str] | None = None) -> str:
        """Tell which of the robots can do which registered tree, and why not. Takes a while."""
        chosen = [part for robot in robots or () for part in self._limits.part("--robot", robot)]
        return await self._run("list", *chosen, "--", "tasks")

    async def read_tree(self, path: Document) -> str:
        """Return the text of a document."""
        return self._file(path, ".xml").read_text(encoding="utf-8")

    async def write_tree(self, path: Document, text: str) -> str:
        """Write a document; it replaces one that is there. It is not checked yet."""
        if len(text) > MAX_FILE:
            raise ToolError(f"refused: more than {MAX_FILE} characters")
        file = self._limits.folder / self._limits.file(path, ".xml")
        if not file.parent.is_dir():
            raise ToolError(f"there is no folder '{file.parent.name}'")
        file.write_text(text, encoding="utf-8")
        return f"{path}: {len(text)} characters"

    async def check_tree(
        self, tree: Tree, scene: Scene = "", robot: Robot = "", strict: bool = False
    ) -> str:
        """Return all errors and warnings of a tree; with a scene or robot, set it up there too."""
        chosen = ["--strict"] if strict else []
        return await self._run("tree", "check", *chosen, *self._cell(tree, scene, robot))

    async def run_tree(
        self, tree: Tree, seed: int = 0, cycles: int = 1, scene: Scene = "", robot: Robot = "",
        settings: Settings = None,
        report: Annotated[str, Field(description="A .json file to write, or empty.")] = "",
    ) -> str:  # fmt: skip
        """Simulate a tree, and return the report: each cycle, whether the goal holds, what failed.

        The same seed gives the same run.
        """
        words = [f"--seed={seed}", f"--cycles={self._limits.number('cycles', cycles)}"]
        if report:
            words.append(f"--report={self._limits.file(report, '.json')}")
        return await self._run("run", *words, *self._cell(tree, scene, robot, settings))

    async def evaluate_tree(
        self, tree: Tree, episodes: int = 10, seed: int = 0, scene: Scene = "", robot: Robot = "",
        settings: Settings = None,
    ) -> str:  # fmt: skip
        """Measure how often a tree succeeds, on randomized episodes, with a 95 % interval."""
        words = [f"--episodes={self._limits.number('episodes', episodes)}", f"--seed={seed}"]
        return await self._run("evaluate", *words, *self._cell(tree, scene, robot, settings))

    async def stress_tree(
        self, tree: Tree, seeds: int = 1, faults: str = "", phases: str = "", scene: Scene = "",
        robot: Robot = "",
    ) -> str:  # fmt: skip
        """Test how a tree copes with faults, at each of its phases, or at those named (A,B)."""
        chosen = [f"--seeds={self._limits.number('seeds', seeds)}"]
        chosen += [f"--faults={faults}", f"--phases={phases}"]
        return await self._run("stress", *chosen, *self._cell(tree, scene, robot))

    async def read_report(
        self, path: Annotated[str, Field(description="Path of a .json file in the folder.")]
    ) -> str:
        """Return a report that run_tree or bt-manip run --report has written."""
        return self._file(path, ".json").read_text(encoding="utf-8")

    async def picture_of_end(
        self, tree: Tree, seed: int = 0, scene: Scene = "", robot: Robot = "",
        settings: Settings = None,
        camera: Annotated[str, Field(description="Full name of a camera.")] = "overview",
    ) -> list[Any]:  # fmt: skip
        """Run a tree once, and draw the cell at its end, which is where it failed, if it did."""
        if not all(letter.isalnum() or letter in "_/-" for letter in camera):
            raise ToolError(f"refused: '{camera}' is no name of a camera")
        file = self._pictures.folder / f"{uuid4().hex}.png"
        words = [f"--seed={seed}", "--cycles=1", f"--record=picture={file} cameras={camera}"]
        words += self._cell(tree, scene, robot, settings)
        found = await self._run("run", *words, process=self._pictures)
        if not file.exists():
            return [found]
        data = file.read_bytes()
        file.unlink()
        return [found, Image(data=data, format="png")]

    # ------------------------------------------------------------------ commands

    def _cell(self, tree: str, scene: str, robot: str, settings: Settings = None) -> list[str]:
        limits = self._limits
        words = limits.part("--scene", scene) + limits.part("--robot", robot)
        return [*words, *limits.settings(settings or {}), "--", limits.tree(tree)]

    async def _run(self, *words: str, process: WarmProcess | None = None) -> str:
        process = process or self._commands
        at = words.index("--")
        arguments = [*words[:at], "--json", *words[at:]]
        found = await anyio.to_thread.run_sync(process.run, arguments, abandon_on_cancel=True)
        return json.dumps(found, indent=1)

    def _file(self, path: str, suffix: str) -> Path:
        file = self._limits.folder / self._limits.file(path, suffix)
        if not file.is_file():
            raise ToolError(f"there is no file '{path}'")
        if file.stat().st_size > MAX_FILE:
            raise ToolError(f"refused: '{path}' has more than {MAX_FILE} bytes")
        return file
