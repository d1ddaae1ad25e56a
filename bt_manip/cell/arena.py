"""The empty room that a cell is built in."""

from dm_control import composer, mjcf

FLOOR = "floor"
OVERVIEW = "overview"


class Arena(composer.Arena):
    """A floor, a sky, soft lights, and the physics options that let fingers hold things.

    Elliptic friction cones and ``impratio`` 10 keep a gripped object from creeping: with MuJoCo's
    pyramidal default, friction is soft and a held cube slides out of the fingers.
    """

    def _build(self, name: str = "arena", timestep: float = 1e-3) -> None:
        """Build the room.

        Args:
            name: Model name.
            timestep: Step of the physics, and of control [s].
        """
        root = mjcf.RootElement(model=name)
        self._mjcf_root = root
        root.compiler.angle = "radian"
        root.option.timestep = timestep
        root.option.cone = "elliptic"
        root.option.impratio = 10
        # A diverged state shall be seen and reported, not silently reset to the start.
        root.option.flag.autoreset = "disable"
        self._build_looks(root)
        self._build_cameras(root)

    @staticmethod
    def _build_looks(root: mjcf.RootElement) -> None:
        root.statistic.center = (0.3, 0.0, 1.1)
        root.statistic.extent = 1.6
        root.visual.headlight.set_attributes(
            ambient=(0.32, 0.32, 0.34), diffuse=(0.25, 0.25, 0.25), specular=(0.0, 0.0, 0.0)
        )
        getattr(root.visual, "global").set_attributes(offwidth=1920, offheight=1080)
        root.visual.quality.set_attributes(shadowsize=4096, offsamples=4)
        root.visual.map.set_attributes(znear=0.01, zfar=30, shadowclip=2.0)
        root.asset.add(
            "texture", name="sky", type="skybox", builtin="gradient",
            rgb1=(0.93, 0.95, 0.97), rgb2=(0.55, 0.64, 0.74), width=256, height=1536,
        )  # fmt: skip
        texture = root.asset.add(
            "texture", name="tiles", type="2d", builtin="checker", mark="edge",
            rgb1=(0.70, 0.71, 0.72), rgb2=(0.66, 0.67, 0.68), markrgb=(0.60, 0.61, 0.62),
            width=512, height=512,
        )  # fmt: skip
        material = root.asset.add(
            "material", name="floor", texture=texture, texrepeat=(1, 1), texuniform=True,
            reflectance=0.0, specular=0.1, shininess=0.1,
        )  # fmt: skip
        root.worldbody.add(
            "geom", name=FLOOR, type="plane", size=(8, 8, 0.1), material=material, friction=(1.0,)
        )
        root.worldbody.add(
            "light", name="key", pos=(1.2, -1.4, 3.6), dir=(-0.35, 0.45, -1.0), directional=True,
            diffuse=(0.55, 0.54, 0.52), specular=(0.15, 0.15, 0.15), castshadow=True,
        )  # fmt: skip
        root.worldbody.add(
            "light", name="fill", pos=(-1.5, 2.0, 3.0), dir=(0.4, -0.5, -1.0), directional=True,
            diffuse=(0.22, 0.23, 0.26), specular=(0.0, 0.0, 0.0), castshadow=False,
        )  # fmt: skip

    @staticmethod
    def _build_cameras(root: mjcf.RootElement) -> None:
        root.worldbody.add(
            "camera", name=OVERVIEW, pos=(1.75, -1.25, 2.05), fovy=42,
            xyaxes=(0.655, 0.755, 0.0, -0.33, 0.286, 0.90),
        )  # fmt: skip

    @property
    def timestep(self) -> float:
        """Step of the physics [s]."""
        return float(self.mjcf_model.option.timestep)
