"""A client that asks for what is outside of the folder, or for code."""

import os
import textwrap

SECRET = "<mujoco><worldbody><geom name='secret_7' size='1'/></worldbody></mujoco>"
TREE = '<root BTCPP_format="4">%s<BehaviorTree ID="Main"><AlwaysSuccess/></BehaviorTree></root>'
SCENE = """
    [[robots]]
    robot = "panda"

    [[objects]]
    name = "thing"
    model = "%s"
    pose = [0.5, 0.0, 0.1]
"""
CODE = """
    import pathlib
    pathlib.Path("loaded").touch()
    from bt_manip.bt import Sleep


    def quick():
        return Sleep("rest", msec=20)
"""


def _write(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "tree.xml").write_text(TREE % "<!-- secret_7 -->")
    (outside / "model.xml").write_text(SECRET)
    (outside / "report.json").write_text('{"secret_7": 1}')
    (folder / "link.xml").symlink_to(outside / "tree.xml")
    (folder / "linked").symlink_to(outside)
    (folder / "evil.py").write_text(textwrap.dedent(CODE))
    include = '<include path="../outside/tree.xml"/>'
    (folder / "includes.xml").write_text(TREE % include)
    (folder / "inner.xml").write_text(TREE % '<include path="linked/tree.xml"/>')
    (folder / "scene.toml").write_text(textwrap.dedent(SCENE) % "../outside/model.xml")
    (folder / "mine.xml").write_text('<mujoco><include file="../outside/model.xml"/></mujoco>')
    (folder / "nested.toml").write_text(textwrap.dedent(SCENE) % "mine.xml")
    (folder / "remote.toml").write_text(textwrap.dedent(SCENE) % "http://127.0.0.1:9/a.xml")
    return folder, outside


def test_files_outside_of_the_folder_and_code_are_refused(served, tmp_path):
    folder, outside = _write(tmp_path)
    before = sorted(path.name for path in outside.iterdir())
    good = str(outside / "tree.xml")

    async def client(server):
        for tree in (
            "../outside/tree.xml", good, "link.xml", "linked/tree.xml", "evil.py:quick",
            "os.path:join", "evil:quick", "--plugins-dir=.", "-h", "", "a\0.xml",
            "linked/tree.xml:Main", "includes.xml:../x",
        ):  # fmt: skip
            assert (await server.refusal("check_tree", tree=tree)).find("refused") >= 0, tree
            assert "refused" in await server.refusal("run_tree", tree=tree)
        for tool, arguments in (
            ("run_tree", {"tree": "pick_place", "report": "../report.json"}),
            ("run_tree", {"tree": "pick_place", "report": "linked/report.json"}),
            ("run_tree", {"tree": "pick_place", "report": "evil.py"}),
            ("run_tree", {"tree": "pick_place", "cycles": 0}),
            ("run_tree", {"tree": "pick_place", "scene": "../outside/scene.toml"}),
            ("run_tree", {"tree": "pick_place", "robot": "--plugins-dir=."}),
            ("run_tree", {"tree": "pick_place", "settings": {"--report": "x"}}),
            ("evaluate_tree", {"tree": "pick_place", "episodes": 101}),
            ("stress_tree", {"tree": "pick_place", "seeds": 101}),
            ("read_report", {"path": "linked/report.json"}),
            ("read_tree", {"path": good}),
            ("write_tree", {"path": "linked/new.xml", "text": "x"}),
            ("write_tree", {"path": "new.py", "text": "x"}),
            ("picture_of_end", {"tree": "pick_place", "camera": "a video=b.mp4"}),
            ("list_parts", {"kind": "--plugins-dir=."}),
        ):  # fmt: skip
            assert "refused" in await server.refusal(tool, **arguments), (tool, arguments)
        found = []
        for arguments in (
            {"tree": "includes.xml"}, {"tree": "inner.xml"},
            {"tree": "pick_place", "scene": "scene.toml"},
            {"tree": "pick_place", "scene": "nested.toml"},
        ):  # fmt: skip
            found.append(await server.call("check_tree", **arguments))
            found.append(await server.call("run_tree", **arguments))
        remote = await server.call("run_tree", tree="pick_place", scene="remote.toml")
        return found, remote

    found, remote = served(client)
    for one in found:
        assert one["exit_code"] == 2 and "outside of the folder" in str(one["findings"]), one
        assert "secret_7" not in str(one)
    assert remote["exit_code"] == 2
    assert sorted(path.name for path in outside.iterdir()) == before
    assert not os.path.exists(folder / "loaded") and not (tmp_path / "report.json").exists()


def test_code_of_the_folder_runs_only_if_the_user_allows_it(served, tmp_path):
    folder, _ = _write(tmp_path)

    async def client(server):
        return await server.call("run_tree", tree="evil.py:quick")

    assert served(client, "--allow-python")["report"]["status"] == "SUCCESS"
    assert (folder / "loaded").exists()
