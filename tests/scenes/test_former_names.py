"""Former names of stable parts keep their meaning, with a warning."""

from dataclasses import replace

import pytest

from bt_manip.scenes import Fixture, Scene, SceneObject, table_and_basket


def test_objects_of_a_scene_are_still_accepted_and_read_as_fixtures():
    scene = table_and_basket()
    table = scene.objects[:1]
    assert Fixture is SceneObject
    with pytest.warns(DeprecationWarning, match="'fixtures' of Scene is now 'objects'"):
        assert Scene(scene.robots, fixtures=table).objects == table
    with pytest.warns(DeprecationWarning, match="'fixtures' of Scene is now 'objects'"):
        assert replace(scene, fixtures=table).objects == table
    with pytest.warns(DeprecationWarning, match=r"Scene.fixtures is now Scene.objects"):
        assert scene.fixtures == scene.objects
