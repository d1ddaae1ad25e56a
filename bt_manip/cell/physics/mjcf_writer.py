"""Compilation of an arena's MJCF, with cached texts of unchanged models."""

import hashlib
import struct
from collections.abc import Collection, Hashable, Iterable, Iterator
from html import escape
from typing import Any, NamedTuple

import mujoco
import numpy as np
from dm_control import mjcf
from lxml import etree

from .edit_tracker import EditTracker, attached_to, with_attached

_PLAIN_MESH = {
    "name", "class", "vertex", "face", "scale", "inertia", "maxhullvert",
    "smoothnormal", "refpos", "refquat",
}  # fmt: skip


class _Text(NamedTuple):
    """The MJCF of an attached model, by section."""

    key: tuple[Any, ...]
    """A key that changes when the model or its attachment frame is edited."""
    sections: dict[str, str]
    assets: dict[str, bytes]


class MjcfWriter:
    """Compiles an arena, and caches the MJCF of each attached model.

    The text is PyMJCF's own, element by element, except that freely moving models are at the
    origin: their poses are part of the state, so that equal entities elsewhere have the same model.
    Names and ids are those of ``mjcf.Physics.from_mjcf_model``, which spends most of its time
    serializing unchanged models. Here each model is serialized once, and meshes with inline
    vertices are passed to MuJoCo as files in memory, which it caches.

    Args:
        root: The model of the arena.
        tracker: Counts the edits of models.
    """

    def __init__(self, root: mjcf.RootElement, tracker: EditTracker):
        self._root = root
        self._texts: dict[int, _Text] = {}
        self._tracker = tracker

    def forget(self, model: mjcf.RootElement) -> None:
        """Drop the text of a model; required when it is detached."""
        self._texts.pop(id(model), None)

    def key(self) -> Hashable:
        """Return a key that changes when a model is attached, detached or edited."""
        return tuple((model, self._key(model)) for model in attached_to(self._root))

    def compile(self, models: Iterable[mjcf.RootElement]) -> mujoco.MjModel:
        """Compile the arena.

        Args:
            models: The attached models whose texts are cached.

        Raises:
            ValueError: If MuJoCo or PyMJCF rejects the model.
        """
        kept = {id(model): model for model in models}
        frames = {id(mjcf.get_attachment_frame(model)): model for model in kept.values()}
        self._texts = texts = {i: self._text_of(model) for i, model in kept.items()}
        assets = {file.to_xml_string(): file.get_contents() for file in self._files(kept)}
        for text in texts.values():
            assets.update(text.assets)
        whole = [f'<mujoco model="{escape(self._root.model)}">']
        for section in self._root.all_children():
            tag = section.tag
            if tag == "default":
                whole.append(self._write_default(texts, kept))
            elif not any(child.repeated for child in section.spec.children.values()):
                whole.append(_written(section, self._root, assets))
            else:
                parts, done = [], set()
                for child in section.all_children():
                    owner = id(frames.get(id(child)) or self._owner(child))
                    if owner not in kept:
                        parts.append(_written(child, self._root, assets))
                    elif owner not in done:
                        done.add(owner)
                        parts.append(texts[owner].sections[tag])
                if parts:
                    whole += [f"<{tag}>", *parts, f"</{tag}>"]
        whole.append("</mujoco>")
        return mujoco.MjModel.from_xml_string("".join(whole), assets)

    def _write_default(self, texts: dict[int, _Text], kept: dict[int, Any]) -> str:
        """Serialize the defaults of the arena and of all attached models."""
        default = self._root.default
        own = "".join(_written(child, self._root, {}) for child in default.all_children())
        name = escape(default.dclass or "/")
        parts = [f'<default><default class="{name}">{own}</default>']
        for model in attached_to(self._root):
            known = texts.get(id(model))
            parts.append(known.sections["default"] if known else self._default_of(model))
        return "".join([*parts, "</default>"])

    def _default_of(self, model: mjcf.RootElement) -> str:
        xml = model.default.to_xml(self._root.namescope)
        return "".join(etree.tostring(child, encoding="unicode") for child in xml)

    def _text_of(self, model: mjcf.RootElement) -> _Text:
        key = self._key(model)
        text = self._texts.get(id(model))
        if text is None or text.key != key:
            text = self._texts[id(model)] = self._write_model(model, key)
        return text

    def _write_model(self, model: mjcf.RootElement, key: tuple[Any, ...]) -> _Text:
        assets: dict[str, bytes] = dict(model.get_assets())
        sections = {"default": self._default_of(model)}
        for section in model.all_children():
            if section.tag == "worldbody":
                frame = mjcf.get_attachment_frame(model)
                sections[section.tag] = _written(frame, self._root, assets, _state_of(frame))
            elif section.tag != "default":
                children = (c for c in section.all_children() if c.spec.repeated)
                sections[section.tag] = "".join(_written(c, self._root, assets) for c in children)
        return _Text(key, sections, assets)

    def _key(self, model: mjcf.RootElement) -> tuple[Any, ...]:
        """Return a key that changes when a model or its attachment frame is edited."""
        frame = mjcf.get_attachment_frame(model)
        joints = [child for child in frame.all_children() if child.root is self._root]
        return (
            model.full_identifier,
            *self._tracker.edits(model),
            _attributes(frame, _state_of(frame)),
            *(_attributes(joint) for joint in joints),
        )

    def _owner(self, element: Any) -> Any:
        """Return the model attached to the arena that contains an element, or the arena."""
        owner = element.root
        while owner is not self._root and owner.parent_model is not self._root:
            owner = owner.parent_model
        return owner

    def _files(self, kept: dict[int, Any]) -> Iterator[Any]:
        """Yield the files of the arena and of attached models without a cached text."""
        models = [self._root]
        for model in attached_to(self._root):
            if id(model) not in kept:
                models += with_attached(model)
        for model in models:
            yield from (file for file in model.namescope.files if file.value)


def _state_of(frame: Any) -> tuple[str, ...]:
    """Return the attributes of an attachment frame that are part of the state."""
    return () if frame.freejoint is None else ("pos", "quat")


def _attributes(element: Any, without: Collection[str] = ()) -> tuple[Any, ...]:
    values = ((n, v) for n, v in element.get_attributes().items() if n not in without)
    return tuple((n, v.tobytes() if isinstance(v, np.ndarray) else v) for n, v in values)


def _written(
    element: Any, root: mjcf.RootElement, assets: dict[str, bytes], without: Iterable[str] = ()
) -> str:
    """Serialize an element as PyMJCF does; add the contents of inline meshes to the assets."""
    xml = element.to_xml(root.namescope)
    for attribute in without:
        xml.attrib.pop(attribute, None)
    spec = element.spec
    if not (xml.attrib or len(xml) or spec.repeated or spec.on_demand):
        return ""
    if xml.tag == "mesh":
        _convert_to_file(xml, assets)
    return etree.tostring(xml, encoding="unicode")


def _convert_to_file(mesh: Any, assets: dict[str, bytes]) -> None:
    """Convert the vertices and faces of a mesh to a file in MuJoCo's MSH format.

    The format: numbers of vertices, normals, texture coordinates and faces as int32, then the
    arrays themselves, float32 and int32
    (https://mujoco.readthedocs.io/en/stable/XMLreference.html#asset-mesh).
    """
    if "vertex" not in mesh.attrib or not _PLAIN_MESH.issuperset(mesh.attrib):
        return
    vertices = np.array(mesh.attrib.pop("vertex").split(), dtype=float).astype("<f4")
    faces = np.array(mesh.attrib.pop("face", "").split(), dtype=float).astype("<i4")
    counts = struct.pack("<4i", len(vertices) // 3, 0, 0, len(faces) // 3)
    content = counts + vertices.tobytes() + faces.tobytes()
    name = f"{hashlib.sha1(content).hexdigest()}.msh"
    assets[name] = content
    mesh.set("file", name)
