"""Leaves for objects of the planning scene of MoveIt Pro.

Motions are planned around the objects of the cell. Objects that a tree adds to the planning scene
are kept by name for its conditions; they are no obstacles.
"""

from bt_manip.bt import InOut, Input, Output
from bt_manip_moveit_pro.leaf import Leaf, read_dict

SCENE = "{@moveit_pro_scene}"
"""Entry of the planning scene: by the name of an object, the link that it is attached to."""


class SceneLeaf(Leaf):
    """A leaf that reads or changes the planning scene."""

    scene = InOut(default=SCENE, doc="the planning scene")

    @property
    def attachments(self) -> dict[str, str]:
        """The link of each object; empty for one that is not attached."""
        return read_dict(self, "scene")

    def put(self, name: str, link: str = "") -> None:
        """Add an object, or attach it to a link."""
        self.scene = {**self.attachments, name: link}

    def check_known(self, name: str) -> None:
        """Check that an object is in the planning scene.

        Raises:
            ValueError: If it is not.
        """
        if name not in self.attachments:
            raise ValueError(f"'{name}' is not in the planning scene")


class GetCurrentPlanningScene(SceneLeaf):
    """Write the planning scene."""

    planning_scene_msg = Output(doc="the planning scene")

    def _run(self) -> None:
        self.planning_scene_msg = self.attachments


class AddURDF(SceneLeaf):
    """Add an object to the planning scene."""

    ignored = "urdf_pose package_name urdf_file_path"
    urdf_name = Input(str, doc="name of the object")

    def _run(self) -> None:
        self.put(self.urdf_name)


class AttachURDF(SceneLeaf):
    """Attach an object of the planning scene to a link."""

    ignored = "allowed_collision_links"
    urdf_name = Input(str, doc="name of the object")
    parent_link_name = Input(str, doc="name of the link")

    def _run(self) -> None:
        self.check_known(self.urdf_name)
        self.put(self.urdf_name, self.parent_link_name)


class DetachURDF(SceneLeaf):
    """Detach an object of the planning scene."""

    urdf_name = Input(str, doc="name of the object")

    def _run(self) -> None:
        name = self.urdf_name
        if not self.attachments.get(name):
            raise ValueError(f"'{name}' is not attached")
        self.put(name)


class RemoveURDFFromScene(SceneLeaf):
    """Remove an object from the planning scene."""

    urdf_name = Input(str, doc="name of the object")

    def _run(self) -> None:
        name = self.urdf_name
        self.check_known(name)
        self.scene = {known: link for known, link in self.attachments.items() if known != name}


class AddCollisionBox(SceneLeaf):
    """Add a box to the planning scene; it is no obstacle here."""

    ignored = "dimensions pose overwrite"
    object_id = Input(str, doc="name of the object")

    def _run(self) -> None:
        self.put(self.object_id)


class ResetPlanningSceneObjects(SceneLeaf):
    """Remove all objects from the planning scene."""

    ignored = "apply_planning_scene_service"

    def _run(self) -> None:
        self.scene = {}


class IsCollisionObjectInPlanningScene(SceneLeaf):
    """Succeed where the planning scene has an object."""

    ignored = "planning_scene"
    collision_object_name = Input(str, doc="name of the object")

    def _run(self) -> None:
        self.check_known(self.collision_object_name)


class IsAnyObjectAttached(SceneLeaf):
    """Succeed where an object of the planning scene is attached."""

    ignored = "planning_scene"

    def _run(self) -> None:
        if not any(self.attachments.values()):
            self.fail("no object is attached")


class WhichObjectIsAttached(SceneLeaf):
    """Write the name of the attached object."""

    ignored = "planning_scene"
    object_names = Input(list[str], default="", doc="names to look for; all by default")
    object_name = Output(str, doc="the name of the first one that is attached")

    def _run(self) -> None:
        wanted = [name for name in self.object_names if name]
        for name, link in self.attachments.items():
            if link and (not wanted or name in wanted):
                self.object_name = name
                return
        self.fail("no object is attached")
