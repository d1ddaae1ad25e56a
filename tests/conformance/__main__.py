"""Compare with the engine: ``python -m tests.conformance PATH...``.

A path is a folder with trees and their traces, one such tree, or a ``.jsonl`` file of trees.
"""

import json
import sys
from collections.abc import Iterator
from pathlib import Path

from tests.conformance.compare import differences
from tests.conformance.options import options_in, parse_options
from tests.conformance.runner import run


def cases(path: Path) -> Iterator[tuple[str, list[str]]]:
    """Run all trees of a path, and give the name and the differences of each.

    Args:
        path: A folder, an ``.xml`` file with its ``.json`` beside it, or a ``.jsonl`` file.
    """
    if path.is_dir():
        for file in sorted(path.glob("*.xml")):
            if not file.name.startswith("quirk_") and file.with_suffix(".json").exists():
                yield from cases(file)
    elif path.suffix == ".jsonl":
        with path.open(encoding="utf-8", errors="replace") as lines:
            for number, case in enumerate(map(json.loads, lines)):
                trace = case.get("trace", case)
                options = parse_options(trace.get("options") or options_in(case["xml"]))
                found = differences(run(case["xml"], options), trace)
                yield f"{path.name}:{case.get('seed', number)}", found
    else:
        trace = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
        text = path.read_text(encoding="utf-8", errors="replace")
        options = parse_options(options_in(text) or trace.get("options", {}))
        yield path.name, differences(run(path, options), trace)


def main(arguments: list[str]) -> int:
    """Run all trees of all paths; print what differs, and how many agree."""
    if not arguments:
        print(__doc__, file=sys.stderr)
        return 2
    agreed = total = 0
    for argument in arguments:
        path = Path(argument)
        if not path.exists():
            print(f"{argument}: no such file or folder", file=sys.stderr)
            return 2
        for name, found in cases(path):
            total += 1
            agreed += not found
            for difference in found[:1]:
                print(f"{name}: {difference}")
    print(f"{agreed} of {total} agree")
    return 0 if agreed == total else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
