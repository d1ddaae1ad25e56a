"""Collection of the links, joints and frames of a model and its nested models."""

from bt_manip.models import ModelError
from bt_manip_fuel.sdf.reader import Element, SdfReader, is_true
from bt_manip_fuel.sdf.scopes import MODEL, SEPARATOR, Frame, Scopes
from bt_manip_fuel.sdf.uris import FetchFuel, included_file

_DEPTH = 16
_KNOWN = {
    "pose", "link", "joint", "frame", "model", "include", "static", "self_collide",
    "allow_auto_disable", "enable_wind",
}  # fmt: skip
_KNOWN_INCLUDE = {"uri", "name", "pose", "static", "placement_frame"}


class Collector:
    """Collects the frames of a model and its nested models."""

    def __init__(self, reader: SdfReader, fetch: FetchFuel) -> None:
        self._reader = reader
        self._fetch = fetch
        self.scopes = Scopes(reader)

    def collect(self, model: Element) -> Scopes:
        """Collect all elements of a model.

        Raises:
            ModelError: If the document is invalid, or refers to missing elements.
        """
        pose = model.find("pose")
        if not self._reader.pose(pose).isIdentity(1e-12):
            assert pose is not None
            self._reader.warn(pose, "the model's own pose is ignored: the user places the model")
        placement = model.get("placement_frame", "")
        T = self._reader.pose(None)
        self.scopes.add(MODEL, Frame("model", model, "", T, placement=placement))
        self._inside(model, "", 0)
        return self.scopes

    def _inside(self, model: Element, scope: str, depth: int) -> None:
        self._reader.only(model, _KNOWN)
        for element in model:
            if element.tag == "include":
                self._include(element, scope, depth)
            elif element.tag == "model":
                self._nested(element, element, scope, self._name(element), depth)
            elif element.tag in ("link", "joint", "frame"):
                self._frame(element, scope)

    def _frame(self, element: Element, scope: str) -> None:
        pose = element.find("pose")
        self.scopes.add(
            scope + self._name(element),
            Frame(
                element.tag, element, scope, self._reader.pose(pose),
                relative_to="" if pose is None else pose.get("relative_to", ""),
                attached_to=element.get("attached_to", ""),
            ),
        )  # fmt: skip

    def _nested(self, model: Element, placed: Element, scope: str, name: str, depth: int) -> None:
        """Add a nested model; `placed` is the element with its pose."""
        if depth >= _DEPTH:
            raise self._reader.error(
                placed, f"models inside models, more than {_DEPTH} deep: one may include itself"
            )
        pose = placed.find("pose")
        if pose is None:
            pose = model.find("pose")
        placement = placed.get("placement_frame") or self._reader.text(placed, "placement_frame")
        frame = Frame(
            "model", model, scope, self._reader.pose(pose),
            relative_to="" if pose is None else pose.get("relative_to", ""),
            placement=placement or model.get("placement_frame", ""),
        )  # fmt: skip
        if self._reader.flag(placed, "static"):
            self._reader.warn(placed, "<static> of a model in a model cannot be expressed")
        self.scopes.add(scope + name + SEPARATOR + MODEL, frame)
        self._inside(model, scope + name + SEPARATOR, depth + 1)

    def _include(self, include: Element, scope: str, depth: int) -> None:
        reader = self._reader
        reader.only(include, _KNOWN_INCLUDE)
        if is_true(include.get("merge")):
            reader.warn(include, "merge='true' is read as a model in the model")
        uri = reader.text(include, "uri")
        try:
            found = included_file(uri, reader.document(include), self._fetch)
        except ModelError as error:
            raise reader.error(include, str(error)) from None
        model = reader.open_model(found.path, found.root)
        name = reader.text(include, "name") or self._name(model)
        self._nested(model, include, scope, name, depth)

    def _name(self, element: Element) -> str:
        name = element.get("name", "").strip()
        if not name:
            raise self._reader.error(element, f"<{element.tag}> has no name")
        return name
