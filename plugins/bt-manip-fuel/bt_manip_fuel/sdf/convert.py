"""Conversion of an SDF model to MJCF."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pinocchio as pin
from lxml import etree

from bt_manip.models import Assets, FoundModel, MjcfModel, Progress, terminal_progress
from bt_manip.spatial import quat_wxyz
from bt_manip_fuel.sdf.collect import Collector
from bt_manip_fuel.sdf.inertia import inertial
from bt_manip_fuel.sdf.joints import joints_of
from bt_manip_fuel.sdf.looks import material_of
from bt_manip_fuel.sdf.reader import Element, SdfReader
from bt_manip_fuel.sdf.scopes import WORLD, Frame, Scopes
from bt_manip_fuel.sdf.shapes import SdfShape, ShapeReader
from bt_manip_fuel.sdf.surfaces import surface

_KNOWN_LINK = {
    "pose", "inertial", "collision", "visual", "gravity", "self_collide", "kinematic",
    "must_be_base_link", "enable_wind", "velocity_decay",
}  # fmt: skip
_KNOWN_VISUAL = {"pose", "geometry", "material", "transparency", "cast_shadows", "laser_retro"}
_KNOWN_COLLISION = {"pose", "geometry", "surface", "max_contacts", "laser_retro", "density"}


def convert_sdf(
    found: FoundModel, *, convex: str = "hull", progress: Progress = terminal_progress
) -> MjcfModel:
    """Convert an SDF model to MJCF.

    The frame of the model becomes that of the MJCF, and each link a body. Moving bodies have
    joints; links without a joint are fixed to the model. Visual geoms are in group 2, collision
    geoms in group 3.

    Args:
        found: The file.
        convex: Collision geometry of meshes: convex ``"hull"`` or convex ``"parts"``.
        progress: Called with the progress of downloads of included models.

    Raises:
        ModelError: If the document is invalid; elements that MJCF cannot express are warnings.
    """

    def fetch(address: str) -> Path:
        from bt_manip_fuel.fuel.address import fuel_address
        from bt_manip_fuel.fuel.client import find_model

        return find_model(fuel_address(address), progress)[1]

    reader = SdfReader()
    model = reader.open_model(found.path, found.root)
    scopes = Collector(reader, fetch).collect(model)
    static = reader.flag(model, "static")
    assets = Assets()
    shapes = ShapeReader(reader, assets, fetch, convex)
    xml = _Converter(reader, scopes, assets, shapes, static).convert(model, found.name)
    return MjcfModel(
        found.address, found.name, xml=xml, assets=assets.files, static=static,
        warnings=tuple(reader.warnings),
    )  # fmt: skip


class _Converter:
    """Builds the tree of bodies."""

    def __init__(
        self,
        reader: SdfReader,
        scopes: Scopes,
        assets: Assets,
        shapes: ShapeReader,
        static: bool,
    ) -> None:
        self._reader, self._scopes, self._assets = reader, scopes, assets
        self._shapes, self._static = shapes, static
        self._links = dict(scopes.of_kind("link"))
        self._joints: dict[str, tuple[str, Frame]] = {}  # by child link
        self._parents: dict[str, str] = {}
        self._geoms: set[str] = set()

    def convert(self, model: Element, name: str) -> str:
        if not self._links:
            raise self._reader.error(model, "a model without links")
        self._hang()
        root = etree.Element("mujoco", model=name)
        etree.SubElement(root, "compiler", angle="radian", autolimits="true")
        root.append(self._assets.element)
        world = etree.SubElement(root, "worldbody")
        T_om = self._scopes.root_placement().inverse()
        self._equality = etree.Element("equality")
        self._add_links(world, T_om)
        self._add_sites(world, T_om)
        contact = etree.SubElement(root, "contact")
        if not self._static and not self._reader.flag(model, "self_collide"):
            for one, other in combinations(self._links, 2):
                _element(contact, "exclude", body1=one, body2=other)
        root.append(self._equality)
        return etree.tostring(root, encoding="unicode")

    def _hang(self) -> None:
        """Find the parent joint of each link, if any."""
        reader, scopes = self._reader, self._scopes
        for name, frame in scopes.of_kind("joint"):
            ends = []
            for tag in ("parent", "child"):
                element = frame.element.find(tag)
                text = reader.text(frame.element, tag)
                if element is None or not text:
                    raise reader.error(frame.element, f"joint '{name}' has no <{tag}>")
                ends.append(scopes.link_of(scopes.whole_name(frame.scope, text, element)))
            parent, child = ends
            if child == WORLD:
                reader.warn(frame.element, f"joint '{name}' moves the world; left out")
            elif child in self._parents or parent == child or self._above(child, parent):
                reader.warn(
                    frame.element, f"joint '{name}' closes a loop, which cannot be expressed"
                )
            else:
                self._parents[child] = parent
                self._joints[child] = (name, frame)
        roots = [link for link in self._links if self._parents.get(link, WORLD) == WORLD]
        for link in roots[1:]:
            if link not in self._parents and not self._static:
                reader.warn(
                    self._links[link].element,
                    f"no joint holds link '{link}': it is fixed to the model",
                )

    def _above(self, link: str, of: str) -> bool:
        """Return whether a link is an ancestor of another one."""
        while of in self._parents:
            of = self._parents[of]
            if of == link:
                return True
        return False

    def _add_links(self, world: Element, T_om: pin.SE3) -> None:
        """Add all bodies, each after its parent."""
        bodies = {WORLD: world}
        left = list(self._links)
        while left:
            ready = [link for link in left if self._parents.get(link, WORLD) in bodies]
            for link in ready:
                parent = self._parents.get(link, WORLD)
                T_pm = T_om if parent == WORLD else self._scopes.pose(parent).inverse()
                T_pl = T_pm * self._scopes.pose(link)
                bodies[link] = _element(bodies[parent], "body", name=link, **_place(T_pl))
                self._fill(bodies[link], link, self._links[link].element)
                left.remove(link)

    def _fill(self, body: Element, name: str, link: Element) -> None:
        reader = self._reader
        reader.only(link, _KNOWN_LINK)
        if not reader.flag(link, "gravity", True):
            body.set("gravcomp", "1")
        if reader.flag(link, "kinematic"):
            reader.warn(link.find("kinematic"), "<kinematic> cannot be expressed")
        if not self._static and name in self._joints:
            joint, frame = self._joints[name]
            for made in joints_of(reader, self._scopes, joint, frame, name):
                _element(body, "joint", **made.attributes)
                if made.equality is not None:
                    _element(self._equality, "joint", **made.equality)
        attributes = inertial(reader, self._scopes, name, link, self._static)
        if attributes is not None:
            _element(body, "inertial", **attributes)
        for collision in link.iterfind("collision"):
            self._add_collision(body, name, collision, attributes is None)
        for visual in link.iterfind("visual"):
            self._add_visual(body, name, visual)
        if link.find("visual") is not None and body.find("geom[@group='2']") is None:
            for geom in body.iterfind("geom"):  # drawn in place of the visuals that were lost
                geom.set("group", "2")
                geom.set("rgba", "0.7 0.7 0.7 1")

    def _add_collision(self, body: Element, link: str, collision: Element, weighs: bool) -> None:
        reader = self._reader
        reader.only(collision, _KNOWN_COLLISION)
        attributes = surface(reader, collision)
        if weighs:
            attributes["density"] = reader.number(collision, "density", 1000.0)
        shapes = self._shapes.read(collision, collides=True, static=self._static)
        for shape in shapes:
            _element(
                body, "geom", name=self._geom_name(f"{link}::{collision.get('name', 'collision')}"),
                **shape.attributes, **_place(self._in_link(link, collision, shape)),
                group=3, rgba=(0.3, 0.5, 0.8, 0.4), **attributes,
            )  # fmt: skip

    def _add_visual(self, body: Element, link: str, visual: Element) -> None:
        reader = self._reader
        reader.only(visual, _KNOWN_VISUAL)
        for shape in self._shapes.read(visual, collides=False, static=self._static):
            _element(
                body, "geom", **shape.attributes, **_place(self._in_link(link, visual, shape)),
                group=2, contype=0, conaffinity=0, mass=0,
                material=material_of(reader, self._assets, visual, shape, self._shapes.fetch),
            )  # fmt: skip

    def _in_link(self, link: str, element: Element, shape: SdfShape) -> pin.SE3:
        return self._scopes.local(link, element.find("pose")) * shape.T

    def _geom_name(self, wanted: str) -> str:
        name, number = wanted, 1
        while name in self._geoms:
            name, number = f"{wanted}_{number}", number + 1
        self._geoms.add(name)
        return name

    def _add_sites(self, world: Element, T_om: pin.SE3) -> None:
        """Add the named frames as sites of their bodies."""
        bodies = {body.get("name"): body for body in world.iter("body")}
        for name, _ in self._scopes.of_kind("frame"):
            link = self._scopes.link_of(name)
            T = T_om if link == WORLD else self._scopes.pose(link).inverse()
            T = T * self._scopes.pose(name)
            _element(bodies.get(link, world), "site", name=name, size=0.005, group=4, **_place(T))


def _place(T: pin.SE3) -> dict[str, object]:
    return {"pos": T.translation, "quat": quat_wxyz(T)}


def _element(parent: Element, tag: str, **attributes: object) -> Element:
    element = etree.SubElement(parent, tag)
    for name, value in attributes.items():
        if not isinstance(value, str):
            numbers = np.atleast_1d(np.asarray(value))
            value = " ".join(repr(float(n)) if n % 1 else str(int(n)) for n in numbers)
        element.set(name, value)
    return element
