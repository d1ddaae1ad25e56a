"""Extension of Sphinx: the search of the site finds the words in names.

A search for "retry" finds ``RetryUntilSuccessful``, one for "attempts" ``num_attempts``. Searches
for the whole names find them as without this.
"""

import re
from typing import Any

from sphinx.search.en import SearchEnglish

PARTS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
"""Words in CamelCase and snake_case, and abbreviations as in ``MoveToIKTarget``."""


class SearchNames(SearchEnglish):
    """English, with the words of names in the index beside the names."""

    def split(self, input: str) -> list[str]:
        """Return the words of a text, and after each name the words in it."""
        words = []
        for word in super().split(input):
            parts = [part.lower() for part in PARTS.findall(word)]
            words += [word, *parts] if len(parts) > 1 else [word]
        return words


def setup(app: Any) -> dict[str, bool]:
    """Replace the search for English."""
    app.add_search_language(SearchNames)
    return {"parallel_read_safe": True}
