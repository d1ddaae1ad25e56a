"""The page of a run in Chromium, without a display and with WebGL in software."""

import io
import os
import re
import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

playwright_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")

from PIL import Image  # noqa: E402

from ..conftest import PATIENCE, Program  # noqa: E402

ARTEFACTS = Path(os.environ.get("BT_MANIP_ARTEFACTS", ".ci/artefacts"))
"""Where the screenshots are kept."""

CHROMIUM_OPTIONS = (
    "--no-sandbox", "--disable-quic",
    "--use-angle=gl-egl", "--ignore-gpu-blocklist",  # Mesa: its shaders compile 10 times faster
    "--enable-unsafe-swiftshader",  # where there is none
    "--no-first-run", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--force-device-scale-factor=1",
)  # fmt: skip

DRAW_ON_REQUEST = """
    window.drawing = false;
    const names = [
        "clear", "drawElements", "drawArrays", "drawElementsInstanced", "drawArraysInstanced"
    ];
    for (const name of names) {
        const draw = WebGL2RenderingContext.prototype[name];
        WebGL2RenderingContext.prototype[name] = function (...options) {
            const offscreen = this.getParameter(this.FRAMEBUFFER_BINDING);
            const [x, y, width, height] = this.getParameter(this.VIEWPORT);
            const light = offscreen && !(width == 1024 && height == 1024);  // no shadow
            if (window.drawing || (light && window.light)) draw.apply(this, options);
        };
    }
"""
"""Lets a page draw its scene only where a test wants its pixels: in software that takes seconds."""

FIXED_RESOLUTION = """
    const get = URLSearchParams.prototype.get;
    URLSearchParams.prototype.get = function (name) {
        return name == "fixedDpr" ? "1" : get.call(this, name);
    };
"""
"""Sets viser's query ``?fixedDpr=1`` in each page and frame.

A page that is slow would change its resolution otherwise, which empties what has been drawn.
"""

DRAW_ONE_FRAME = """
    () => new Promise((done, fail) => {
        setTimeout(() => fail(new Error("no frame was drawn")), 90000);  // PATIENCE
        const frame = () => __viserTestpoints.rendererInfo.render.frame;
        const first = frame();
        window.drawing = true;
        const check = () => {
            __viserMutable.requestRender();
            if (frame() < first + 2) return requestAnimationFrame(check);
            window.drawing = false;  // what is drawn stays
            requestAnimationFrame(done);
        };
        check();
    })
"""
"""Draws a whole frame of the scene as it is now."""

SIZE = {"width": 1280, "height": 720}
"""Size of the window [pixels]."""

COMPLETE = """
    () => {
        if (!(window.__viserTestpoints?.rendererInfo.render.triangles > 1000)) return false;
        const { nodeRefFromName, messageQueue, scene } = __viserMutable;
        const shapes = Object.keys(nodeRefFromName).filter((name) => /shape\\d+$/.test(name));
        const drawn = (name) => {  // those with a texture come later than others
            let meshes = 0;
            nodeRefFromName[name]?.traverse((node) => { meshes += Boolean(node.isMesh); });
            return meshes > 0;
        };
        return messageQueue.length == 0 && Boolean(scene.environment) && shapes.every(drawn);
    }
"""
"""Tells whether the scene is there, with its light and textures."""

CORNERS = """
    names => {
        const { nodeRefFromName, camera } = __viserMutable;
        let farthest = 0, count = 0;
        camera.updateMatrixWorld();
        for (const name of names) nodeRefFromName[name].traverse((mesh) => {
            if (!mesh.isMesh || !mesh.geometry?.attributes?.position) return;
            mesh.updateWorldMatrix(true, false);
            const { array, itemSize } = mesh.geometry.attributes.position;
            const step = itemSize * Math.max(1, Math.floor(array.length / itemSize / 200));
            for (let i = 0; i < array.length; i += step, count++) {
                const v = camera.position.clone().set(array[i], array[i + 1], array[i + 2]);
                v.applyMatrix4(mesh.matrixWorld).project(camera);
                farthest = Math.max(farthest, Math.abs(v.x), Math.abs(v.y));
            }
        });
        return [farthest, count];
    }
"""
"""Gives the farthest coordinate of points of nodes, up to 1 in the picture, and their number."""


class Window:
    """A page in the browser, with what a person does there."""

    def __init__(self, page: Any, url: str) -> None:
        self.page = page
        self.frame = page.main_frame  # which has the scene
        self.log: list[str] = []
        page.on("pageerror", lambda error: self.log.append(str(error)))
        page.goto(url)

    def button(self, name: str) -> Any:
        return self.page.get_by_role("button", name=name, exact=True)

    def press(self, name: str) -> None:
        """Press a button, without waiting for the frames of a slow scene."""
        self.button(name).dispatch_event("click")

    def choose(self, label: str, option: str) -> None:
        """Choose an option of a drop-down list."""
        self.page.get_by_role("combobox", name=label, exact=True).select_option(option)

    def node(self, name: str) -> Any:
        """Return the row of a node of the tree that is in view."""
        name = re.escape(name)
        rows = self.page.locator(".line:not([hidden])")
        return rows.filter(has=self.page.locator(".name", has_text=re.compile(f"^{name}$"))).first

    def select(self, name: str) -> None:
        """Select a node of the tree."""
        self.node(name).locator(".name").click(force=True)

    def set_breakpoint(self, name: str) -> None:
        """Set a breakpoint in the margin of a node, or remove it."""
        self.node(name).locator(".margin").click(force=True)

    def tree(self) -> str:
        """Return the rows of the tree that are in view, a line for each."""
        rows = "[...document.querySelectorAll('.line:not([hidden])')]"
        order = "sort((a, b) => parseFloat(a.style.top) - parseFloat(b.style.top))"
        texts = "map((line) => [...line.children].slice(2).map((e) => e.textContent).join(' '))"
        return str(self.page.evaluate(f"() => {rows}.{order}.{texts}.join('\\n')"))

    def wait_for_tree(self, pattern: str) -> None:
        """Wait until a row of the tree matches."""
        wait_until(
            lambda: re.search(pattern, self.tree(), re.MULTILINE) is not None,
            lambda: f"no {pattern!r} in:\n{self.tree()}",
        )

    def open_tab(self, name: str) -> None:
        """Bring a tab to the front."""
        tab = self.page.get_by_role("tab", name=name, exact=True)

        def selected() -> bool:
            tab.click(force=True)  # lost if the page is drawn anew meanwhile
            return tab.get_attribute("aria-selected") == "true"

        wait_until(selected)

    def wait_for_text(self, pattern: str) -> str:
        """Return the first text of the page that matches, waiting for it."""
        found: list[str] = []

        def matches() -> bool:
            if (match := re.search(pattern, self.text())) is not None:
                found.append(match[0])
            return bool(found)

        wait_until(matches, lambda: f"no {pattern!r} in:\n{self.text()}")
        return found[0]

    def text(self) -> str:
        return str(self.page.locator("body").inner_text())

    def time(self) -> float:
        """Return the simulated time that is shown [s]."""
        return float(self.wait_for_text(r"[\d.]+ s: ").split()[0])

    def evaluate(self, script: str, argument: Any = None) -> Any:
        return self.frame.evaluate(script, argument)

    def wait_for_scene(self) -> None:
        """Wait until the scene is there, with its light and textures."""
        if self.page.locator("iframe#scene").count():
            # It comes after the rest of the page.
            self.frame = self.page.locator("iframe#scene[src]").element_handle().content_frame()
            self.frame.wait_for_url("**/scene*")
        wait_until(lambda: bool(self.evaluate(COMPLETE)))
        # The note that the scene is drawn in software goes by itself, sooner or later.
        self.evaluate("() => document.querySelector('.mantine-Notification-closeButton')?.click()")

    def scene_without(self, node: str) -> np.ndarray:
        """Return the pixels of the scene without one of its nodes."""
        self.evaluate(
            "name => { const node = __viserMutable.nodeRefFromName[name];"
            " window.put_back = () => window.parent_of_node.add(node);"
            " window.parent_of_node = node.parent; node.removeFromParent(); }",
            node,
        )
        pixels = self.scene()
        self.evaluate("() => { put_back(); }")  # without its result: it has the whole scene
        return pixels

    def scene(self, name: str | None = None) -> np.ndarray:
        """Draw the scene and return its pixels, without the panels.

        Args:
            name: Of the artefact that keeps the whole picture.
        """  # (height, width, 3)
        self.evaluate(DRAW_ONE_FRAME)
        data = self.page.screenshot()
        if name is not None:
            ARTEFACTS.mkdir(parents=True, exist_ok=True)
            (ARTEFACTS / f"{name}.png").write_bytes(data)
        return _cut(data, self.frame.locator("canvas[data-engine]").bounding_box())

    def pixels(self, element: Any) -> np.ndarray:
        """Return the pixels of the visible part of an element."""  # (height, width, 3)
        return _cut(self.page.screenshot(), element.bounding_box())

    def position(self, node: str) -> np.ndarray:
        """Return where the origin of a node is in the world [m]."""  # (3,)
        script = (
            "name => { const { nodeRefFromName, camera } = __viserMutable;"
            " const v = nodeRefFromName[name].getWorldPosition(camera.position.clone());"
            " return nodeRefFromName[''].worldToLocal(v).toArray(); }"
        )
        self._await_node(node)
        return np.array(self.evaluate(script, node))

    def _await_node(self, node: str) -> None:
        self.frame.wait_for_function("name => __viserMutable.nodeRefFromName[name]", arg=node)

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Drag with the left button of the mouse from one point of the page to another."""
        mouse = self.page.mouse
        mouse.move(*start)
        mouse.down()
        mouse.move(*end, steps=10)
        mouse.up()

    def pull(
        self, node: str, start: Sequence[float], end: Sequence[float], done: Callable[[], bool]
    ) -> None:
        """Drag a handle of the scene until something has happened, and keep the button pressed.

        A scene that is drawn slowly may not see the mouse over the handle: it is tried again.

        Args:
            node: Name of the handle's node.
            start: Where the mouse takes hold, from the origin of the node in the world [m].
            end: Where the mouse goes, likewise.
            done: Tells whether it has happened.
        """
        mouse = self.page.mouse

        def happened() -> bool:
            mouse.up()
            mouse.move(*self.pixel(node, start))
            self.page.wait_for_timeout(500)
            mouse.down()
            mouse.move(*self.pixel(node, end), steps=10)
            latest = time.monotonic() + 10.0
            while not done() and time.monotonic() < latest:
                time.sleep(0.1)
            return done()

        wait_until(happened)

    def pixel(self, node: str, offset: Sequence[float] = (0.0, 0.0, 0.0)) -> tuple[float, float]:
        """Return where a point of the scene is on the page [pixels].

        Args:
            node: Name of a node of the scene.
            offset: From its origin to the point, in the frame of the world [m].
        """
        self._await_node(node)
        x, y = self.evaluate(
            "([name, [x, y, z]]) => {"
            " const { nodeRefFromName, camera } = __viserMutable;"
            " const world = nodeRefFromName[''];"
            " const v = nodeRefFromName[name].getWorldPosition(camera.position.clone());"
            " world.worldToLocal(v); v.set(v.x + x, v.y + y, v.z + z); world.localToWorld(v);"
            " v.project(camera); return [v.x, v.y]; }",
            [node, list(offset)],
        )
        box = self.frame.locator("canvas[data-engine]").bounding_box()
        half_width, half_height = box["width"] / 2, box["height"] / 2
        return box["x"] + half_width * (1 + x), box["y"] + half_height * (1 - y)


def _cut(data: bytes, box: dict[str, float]) -> np.ndarray:
    """Return the pixels of a screenshot inside a box."""
    left, top, width, height = (int(box[key]) for key in ("x", "y", "width", "height"))
    pixels = np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(int)
    return pixels[max(top, 0) : top + height, left : left + width]


def wait_until(
    condition: Callable[[], bool], explain: Callable[[], str] = lambda: "it did not happen"
) -> None:
    """Wait for a condition, which is checked often."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, explain()
        time.sleep(0.1)


@pytest.fixture(scope="package")
def chromium() -> Iterator[Any]:
    """Start Chromium, or skip the tests where there is none.

    Its event loop runs in this thread meanwhile: tests of other folders could not run their own.
    """
    executable = shutil.which("chromium")
    if executable is None:
        pytest.skip("no chromium here: the Debian package has it")
    with playwright_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=executable, args=[*CHROMIUM_OPTIONS], timeout=1e3 * PATIENCE
        )
        yield browser
        browser.close()


def empty(route: Any) -> None:
    """Answer a request by an empty page."""
    route.fulfill(body="<html></html>", content_type="text/html")


@pytest.fixture(scope="module")
def open_window(chromium) -> Iterator[Callable[..., Window]]:
    """Give a function that opens an address in a window with an empty profile.

    It takes whether the window has the scene, and whether that has the light of its environment:
    both take seconds. In the end, no script may have failed.
    """
    windows: list[Window] = []

    def open_window(url: str, *, scene: bool = True, light: bool = True) -> Window:
        context = chromium.new_context(viewport=SIZE)
        context.set_default_timeout(1e3 * PATIENCE)
        context.add_init_script(DRAW_ON_REQUEST + FIXED_RESOLUTION)
        context.add_init_script(f"window.light = {str(light).lower()};")
        if not scene:
            context.route("**/scene*", empty)
        windows.append(Window(context.new_page(), url))
        return windows[-1]

    yield open_window
    for window in windows:
        window.page.context.close()
    assert not [line for window in windows for line in window.log]


@pytest.fixture(scope="module")
def shared_window(program: Program, open_window: Callable[..., Window]) -> Window:
    """Open the page of the module's program."""
    window = open_window(program.url)
    window.wait_for_scene()
    return window


@pytest.fixture
def window(shared_window: Window) -> Window:
    """Give the page of a run that goes on in real time."""
    if shared_window.button("Continue").count():
        shared_window.press("Continue")
    shared_window.button("Pause").wait_for()
    return shared_window
