"""What a client gets: the JSON of commands, pictures, prompts, and an end of what is too long."""

import json
import os
import textwrap
import time

from tests.support.program import run_program

PLUGIN = """
    import os
    from bt_manip import hookimpl
    from bt_manip.bt import Action, Status


    class Chatter(Action):
        def update(self):
            print('{"jsonrpc": "2.0", "id": 1, "result": {}}', flush=True)
            os.write(1, b'{"jsonrpc": "2.0", "id": 2, "result": {}}\\n')
            return Status.SUCCESS


    @hookimpl
    def register_behaviours(register):
        register(Chatter)
"""

TREE = """\
<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Sequence>%s</Sequence>
  </BehaviorTree>
</root>
"""


def listening():
    """Return the sockets on which a server, or its worker, listens."""
    inodes = set()
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            words = open(f"/proc/{pid}/cmdline").read()
            if "bt_manip\0mcp" in words or "bt_manip_mcp.worker" in words:
                folder = f"/proc/{pid}/fd"
                inodes |= {os.readlink(f"{folder}/{one}") for one in os.listdir(folder)}
        except OSError:
            continue
    assert inodes
    rows = [
        line.split()
        for name in ("tcp", "tcp6")
        if os.path.exists(f"/proc/net/{name}")
        for line in open(f"/proc/net/{name}").readlines()[1:]
    ]
    return [row for row in rows if row[3] == "0A" and f"socket:[{row[9]}]" in inodes]


def test_tools_return_what_their_commands_print_and_listen_on_no_network(
    served, tmp_path, monkeypatch, capfd
):
    async def client(server):
        offered = {tool.name for tool in (await server.session.list_tools()).tools}
        assert offered >= {"list_parts", "check_tree", "run_tree", "picture_of_end", "stress_tree"}
        await server.call("write_tree", path="a.xml", text=TREE % '<Lift height="15"/>')
        checked = await server.call("check_tree", tree="a.xml")
        assert "15" in await server.call("read_tree", path="a.xml")
        ran = await server.call("run_tree", tree="pick_place", seed=3, report="report.json")
        read = await server.call("read_report", path="report.json")
        listed = await server.call("list_parts", kind="behaviours", name="Grasp")
        await server.call("write_tree", path="b.xml", text=TREE % "<AlwaysFailure/>")
        evaluated = await server.call("evaluate_tree", tree="b.xml", episodes=1)
        assert listening() == []
        return checked, ran, read, listed, evaluated

    checked, ran, read, listed, evaluated = served(client)
    assert ran["report"] == read and read["status"] == "SUCCESS" and read["seed"] == 3
    assert evaluated["evaluations"][0]["points"][0]["successes"] == 0
    monkeypatch.chdir(tmp_path / "folder")
    for words, found in (
        (("tree", "check", "a.xml"), checked),
        (("list", "behaviours", "Grasp"), listed),
    ):
        capfd.readouterr()
        code = run_program(*words, "--json")
        assert {"exit_code": code, **json.loads(capfd.readouterr().out)} == found
    assert checked["findings"][0]["code"] == "implausible-value"


def test_a_run_past_its_limit_is_stopped_and_says_so(served):
    async def client(server):
        start = time.monotonic()
        stopped = await server.call("run_tree", tree="pick_place", cycles=50)
        took = time.monotonic() - start
        text = TREE % "<AlwaysSuccess/>"
        await server.call("write_tree", path="a.xml", text=text)
        return stopped, took, await server.call("check_tree", tree="a.xml")

    stopped, took, after = served(client, "--max-seconds", 2)
    assert stopped["stopped"] == "after 2 s, the limit of this server"
    assert stopped["report"]["status"] == "INTERRUPTED" and took < 60
    assert after["exit_code"] == 0 and "stopped" not in after


def test_what_behaviours_print_does_not_reach_the_client_but_a_picture_of_the_end(served, tmp_path):
    plugins = tmp_path / "plugins"
    plugins.mkdir()
    (plugins / "noisy.py").write_text(textwrap.dedent(PLUGIN))

    async def client(server):
        text = TREE % '<Chatter/><SpawnObject object="{c}"/><IsHolding object="{c}"/>'
        await server.call("write_tree", path="a.xml", text=text)
        prompts = await server.session.list_prompts()
        repair = await server.session.get_prompt("repair_this_tree", {"tree": "a.xml"})
        found = await server.call("picture_of_end", tree="a.xml")
        return [one.name for one in prompts.prompts], repair, found

    prompts, repair, found = served(client, "--plugins-dir", plugins)
    assert prompts == ["write_a_tree", "repair_this_tree"]
    assert "Repair the behaviour tree a.xml" in repair.messages[0].content.text
    if isinstance(found, dict):  # no OpenGL
        assert "nothing can be drawn" in json.dumps(found)
    else:
        report, picture = found
        assert report["report"]["status"] == "FAILURE"
        assert picture.mime_type == "image/png" and len(picture.data) > 10_000
