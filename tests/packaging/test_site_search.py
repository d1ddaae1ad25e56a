"""The search of the site finds the words in names."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("sphinx", reason="the extra [docs] is not installed")

ROOT = Path(__file__).resolve().parents[2]

CONF = f"""
import sys
sys.path.insert(0, {str(ROOT / "tools")!r})
extensions = ["site_search"]
"""

PAGE = """
Nodes
=====

``RetryUntilSuccessful`` has ``num_attempts``; ``MoveToIKTarget`` and words.
"""


@pytest.fixture(scope="module")
def terms(tmp_path_factory) -> set[str]:
    """Build a site of one page, and return the stems in its index."""
    folder = tmp_path_factory.mktemp("site")
    (folder / "conf.py").write_text(CONF)
    (folder / "index.rst").write_text(PAGE)
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "-b", "html", ".", "built"]
    subprocess.run(command, cwd=folder, check=True)
    index = (folder / "built" / "searchindex.js").read_text()
    (found,) = re.findall(r'"terms":\{(.*?)\}', index)
    return set(re.findall(r'"(\w+)":', found))


@pytest.mark.parametrize("query", ["retri", "success", "attempt", "ik", "target"])
def test_a_word_of_a_name_is_found(query, terms):
    assert query in terms  # the stem to which the page reduces what is typed


def test_names_and_other_words_are_found_as_without_it(terms):
    assert {"retryuntilsuccess", "num_attempt", "word"} <= terms
    assert not {"Until", "until", "wo", "rds"} & terms  # a stop word, and no parts
