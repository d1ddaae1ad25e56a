"""What a client does with the findings of ``--json``."""

import re
from typing import Any


def applied(text: str, finding: dict[str, Any]) -> str:
    """Apply the suggestion of a finding to a text as the documentation says."""
    lines, edit = text.splitlines(keepends=True), finding["suggestion"]
    at = finding | edit  # a suggestion may have a place of its own
    start = sum(map(len, lines[: at["line"] - 1])) + at["column"] - 1
    place = re.compile(rf"(?<!\w){re.escape(edit['replace'])}(?!\w)").search(text, start)
    assert place is not None
    return text[: place.start()] + edit["with"] + text[place.end() :]
