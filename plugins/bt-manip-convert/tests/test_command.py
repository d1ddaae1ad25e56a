"""``bt-manip tree convert``: to Python and back."""

import pytest

GOOD = """\
<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <Sequence name="s">
      <AlwaysSuccess/>
    </Sequence>
  </BehaviorTree>
</root>
"""
FOREIGN = """\
<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <TryTwice number_of_retries="2">
      <FollowPath path="{path}"/>
      <SubTree ID="ClearThings"/>
    </TryTwice>
  </BehaviorTree>
</root>
"""


@pytest.fixture
def convert(bt_manip, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def convert(text, *options):
        (tmp_path / "tree.xml").write_text(text)
        assert bt_manip("tree", "convert", "tree.xml", "-o", "made.py", *options).code == 0

    return convert


def test_it_leads_to_python_and_back(bt_manip, convert):
    convert(GOOD)
    assert bt_manip("tree", "convert", "made.py:document").out == GOOD
    assert '<BehaviorTree ID="MainTree">' in bt_manip("tree", "convert", "made.py:main").out
    assert "python" in bt_manip("list", "conversions").out


def test_trees_with_stubs_run_and_lead_back(bt_manip, convert):
    convert(FOREIGN, "--stub-unknown", "--stub", "TryTwice=Fallback")
    assert bt_manip("tree", "convert", "made.py:document").out == FOREIGN
    assert bt_manip("run", "made.py:document", "--quiet").code == 0
