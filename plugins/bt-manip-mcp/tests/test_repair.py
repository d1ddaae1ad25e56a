"""Ten broken trees, repaired by a client that applies suggestions of findings and knows no more."""

import pytest

from tests.support.findings import applied

GOOD = """\
<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main" _goal="IsIn object={c} container=basket">
    <Sequence>
      <SpawnObject object="{c}"/>
      <OpenGripper/>
      <Hover object="{c}"/>
      <Reach object="{c}"/>
      <Grasp object="{c}"/>
      <Lift/>
      <Drop container="basket"/>
    </Sequence>
  </BehaviorTree>
</root>
"""

HOVER = '      <Hover object="{c}"/>\n'
SPAWN = '      <SpawnObject object="{c}"/>\n'
OPEN = "<OpenGripper/>"
ENDLESS = (
    '<ForceSuccess><RetryUntilSuccessful num_attempts="-1"><AlwaysFailure/>'
    "</RetryUntilSuccessful></ForceSuccess>"
)
BROKEN = {
    "a behaviour misspelt": ("<Hover", "<Hovr"),
    "a port misspelt": ('Reach object="', 'Reach objct="'),
    "a container misspelt": ('<Drop container="basket"', '<Drop container="bakset"'),
    "the goal of another entry": ("object={c}", "object={cube}"),
    "no Reach": ('      <Reach object="{c}"/>\n', ""),
    "a closed gripper": (OPEN, "<CloseGripper/>"),
    "centimetres": ("<Lift/>", '<Lift height="15"/>'),
    "too short a timeout": (OPEN, f'{OPEN}<Timeout msec="100"><Sleep msec="500"/></Timeout>'),
    "an endless loop": (OPEN, ENDLESS + OPEN),
    "read before written": (f"{SPAWN}      {OPEN}\n{HOVER}", f"      {OPEN}\n{HOVER}{SPAWN}"),
}


async def _repair(server, text):
    """Apply suggestions until there are none; return whether a run then meets the goal."""
    cell = {"tree": "tree.xml", "scene": "table_and_basket"}
    for _ in range(6):
        await server.call("write_tree", path="tree.xml", text=text)
        findings = (await server.call("check_tree", **cell))["findings"]
        suggested = [one for one in findings if "suggestion" in one]
        if not suggested:
            break
        text = applied(text, suggested[0])
    ran = await server.call("run_tree", **cell)
    return ran["exit_code"] == 0 and ran["report"]["cycles"][0]["goal"] is True


@pytest.mark.soak
def test_a_client_that_applies_suggestions_repairs_most_broken_trees(served):
    async def client(server):
        before, after = {}, {}
        for name, (right, wrong) in BROKEN.items():
            text = GOOD.replace(right, wrong, 1)
            assert text != GOOD
            await server.call("write_tree", path="tree.xml", text=text)
            checked = await server.call("check_tree", tree="tree.xml", scene="table_and_basket")
            before[name] = len(checked["findings"])
            after[name] = await _repair(server, text)
        return before, after

    before, after = served(client)
    assert all(before.values()), before
    assert sum(after.values()) >= 7, after
