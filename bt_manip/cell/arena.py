"""The arena of a cell."""

from dm_control import composer, mjcf

from bt_manip.spatial import quat_wxyz

from .objects.camera import looking_at

FLOOR = "floor"
OVERVIEW = "overview"


class Arena(composer.Arena):
    """A floor, a sky, soft lights, and physics options for gripping.

    Elliptic friction cones and ``impratio`` 10 keep a gripped object from creeping: with the softer
    friction of MuJoCo's pyramidal default, a held cube slides out of a gripper.
    """

    def _build(self, name: str = "arena", timestep: float = 1e-3) -> None:
        """Build the arena.

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
        # Report an unstable simulation instead of silently resetting it.
        root.option.flag.autoreset = "disable"
        self._build_visuals(root)

    @staticmethod
    def _build_visuals(root: mjcf.RootElement) -> None:
        # Shadows are cast within shadowclip * extent of the light's axis. A larger value makes the
        # shadow map coarser, with dark specks on round surfaces.
        root.statistic.set_attributes(center=(0.3, 0.0, 1.1), extent=1.6)
        root.visual.map.set_attributes(znear=0.01, zfar=30, shadowclip=1.15, haze=0.4)
        root.visual.quality.set_attributes(shadowsize=8192, offsamples=8)
        root.visual.rgba.haze = (0.90, 0.92, 0.94, 1.0)
        root.visual.headlight.set_attributes(
            ambient=(0.28, 0.28, 0.28), diffuse=(0.28, 0.28, 0.28), specular=(0.05, 0.05, 0.05)
        )
        getattr(root.visual, "global").set_attributes(offwidth=1920, offheight=1200)
        root.asset.add(
            "texture", name="sky", type="skybox", builtin="gradient",
            rgb1=(0.88, 0.92, 0.96), rgb2=(0.60, 0.69, 0.79), width=64, height=384,
        )  # fmt: skip
        texture = root.asset.add(
            "texture", name="tiles", type="2d", builtin="checker", mark="edge",
            rgb1=(0.80, 0.81, 0.82), rgb2=(0.77, 0.78, 0.79), markrgb=(0.70, 0.71, 0.73),
            width=256, height=256,
        )  # fmt: skip
        material = root.asset.add(
            "material", name="floor", texture=texture, texrepeat=(1, 1), texuniform=True,
            reflectance=0.06, specular=0.1, shininess=0.1,
        )  # fmt: skip
        root.worldbody.add(
            "geom", name=FLOOR, type="plane", size=(8, 8, 0.1), material=material, friction=(1.0,)
        )
        root.worldbody.add(
            "light", name="key", pos=(0.8, -0.55, 2.8), dir=(-0.36, 0.38, -1.0), directional=True,
            diffuse=(0.62, 0.60, 0.57), specular=(0.25, 0.25, 0.25), castshadow=True,
        )  # fmt: skip
        root.worldbody.add(
            "light", name="fill", pos=(-1.5, 2.0, 3.0), dir=(0.4, -0.5, -1.0), directional=True,
            diffuse=(0.20, 0.21, 0.24), specular=(0.0, 0.0, 0.0), castshadow=False,
        )  # fmt: skip

        T_wc = looking_at((1.44, -1.70, 1.86), target=(0.17, -0.07, 1.25))
        root.worldbody.add(
            "camera", name=OVERVIEW, pos=T_wc.translation, quat=quat_wxyz(T_wc), fovy=36
        )
