"""Addresses of models in SDFormat and on Fuel."""

import pytest

from bt_manip.models import ModelError, find_model, load_model


def test_a_file_is_what_its_name_or_its_content_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("a.sdf", "a.SDF", "a.world", "d.xml"):
        (tmp_path / name).write_text("<sdf/>")
        assert find_model(name).format == "sdf"


def test_a_folder_of_gazebo_is_a_model(tmp_path):
    (tmp_path / "my ball").mkdir()
    (tmp_path / "my ball" / "model.config").write_text("<model><sdf>m.sdf</sdf></model>")
    (tmp_path / "my ball" / "m.sdf").write_text("<sdf/>")
    found = find_model(str(tmp_path / "my ball"))
    assert (found.name, found.path.name) == ("my_ball", "m.sdf")


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("nobody.sdf", "there is no such file"),
        ("fuell:a/b", "unknown kind of address 'fuell:'; did you mean 'fuel:'?"),
        ("https://example.com/x.sdf", "is not the address of a model"),
    ],
)
def test_a_wrong_address_is_one_clear_error(address, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ModelError) as caught:
        load_model(address)
    assert words in str(caught.value)
