"""Facts that hold for every bundled model file."""

import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
import pytest
from dm_control import mjcf

MODELS = Path(__file__).parents[2] / "models"
FILES = sorted(MODELS.glob("*/*.xml"))

everywhere = pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)


@everywhere
def test_pymjcf_reads_it_and_compiles_the_same_model(path):
    physics = mjcf.Physics.from_mjcf_model(mjcf.from_path(str(path)))
    alone = mujoco.MjModel.from_xml_path(str(path))
    assert physics.model.ngeom == alone.ngeom and alone.nbody > 1
    np.testing.assert_allclose(physics.model.body_mass, alone.body_mass, rtol=1e-14)
    np.testing.assert_allclose(physics.model.body_inertia, alone.body_inertia, rtol=1e-12)


def test_the_folder_holds_nothing_but_models_and_what_describes_them():
    assert {path.suffix for path in MODELS.rglob("*") if path.is_file()} <= {".xml", ".md", ".toml"}


@everywhere
def test_it_needs_no_other_file_and_brings_no_root_joint_no_option_and_no_equality(path):
    root = ET.parse(path).getroot()
    assert not [element.tag for element in root.iter() if "file" in element.attrib]
    tags = {element.tag for element in root.iter()}
    assert not tags & {
        "include", "freejoint", "option", "equality", "keyframe", "weld", "connect"
    }  # fmt: skip
    (body,) = root.findall("worldbody/body")
    assert body.findall("joint") == []


@everywhere
def test_what_is_seen_neither_touches_nor_weighs(path):
    model = mujoco.MjModel.from_xml_path(str(path))
    seen = model.geom_group == 2
    assert seen.any() and (model.geom_group[~seen] == 3).all()
    assert not model.geom_contype[seen].any() and not model.geom_conaffinity[seen].any()
    weighed = mujoco.MjSpec.from_file(str(path))
    for geom in [g for g in weighed.geoms if g.group == 2]:
        weighed.delete(geom)
    bare = weighed.compile()
    np.testing.assert_allclose(bare.body_mass, model.body_mass, rtol=1e-14)
    np.testing.assert_allclose(bare.body_inertia, model.body_inertia, rtol=1e-12)


@everywhere
def test_only_capsules_and_boxes_collide(path):
    """Coal, Pinocchio's collision library, misses contacts of cylinders."""
    model = mujoco.MjModel.from_xml_path(str(path))
    shapes = set(model.geom_type[model.geom_contype != 0])
    assert shapes <= {int(mujoco.mjtGeom.mjGEOM_CAPSULE), int(mujoco.mjtGeom.mjGEOM_BOX)}
