"""Compare with the engine: ``python -m tests.conformance PATH...``.

A path is a folder with trees and their traces, one such tree, or a ``.jsonl`` file of trees.
"""

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.conformance.compare import differences
from tests.conformance.options import options_in, parse_options
from tests.conformance.runner import run


class InputError(Exception):
    """A file is not a tree with its trace."""


@contextmanager
def naming(where: str) -> Iterator[None]:
    """Turn errors of reading a case into an `InputError` that says where it is."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{error.filename}: {error.strerror}") from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        what = f"{type(error).__name__}: {' '.join(str(error).split())}"
        raise InputError(f"{where}: not a tree with its trace: {what}") from error


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
            for number, line in enumerate(lines):
                if line.strip():
                    with naming(where := f"{path}:{number + 1}"):
                        case = json.loads(line)
                        name = f"{path.name}:{case.get('seed', number)}"
                        trace = case.get("trace", case)
                        options = parse_options(trace.get("options") or options_in(case["xml"]))
                        text = str(case["xml"])
                    ours = run(text, options)
                    with naming(where):
                        found = differences(ours, trace)
                    yield name, found
    else:
        with naming(str(path)):
            trace = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
            text = path.read_text(encoding="utf-8", errors="replace")
            options = parse_options(options_in(text) or trace.get("options", {}))
        ours = run(path, options)
        with naming(str(path)):
            found = differences(ours, trace)
        yield path.name, found


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
        try:
            for name, found in cases(path):
                total += 1
                agreed += not found
                for difference in found[:1]:
                    print(f"{name}: {difference}")
        except InputError as error:
            print(error, file=sys.stderr)
            return 2
    print(f"{agreed} of {total} agree")
    return 0 if agreed == total else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
