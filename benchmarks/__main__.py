"""Measure, and print tables: ``python -m benchmarks [NAME ...]``."""

import importlib
import os
import sys
from pathlib import Path

os.environ.setdefault("MUJOCO_GL", "disable")


def main(names: list[str]) -> None:
    """Print the tables of the benchmarks called so, or of all."""
    from rich.console import Console
    from rich.table import Table

    found = sorted(
        path.stem.removeprefix("bench_") for path in Path(__file__).parent.glob("bench_*.py")
    )
    unknown = [name for name in names if name not in found]
    if unknown:
        sys.exit(f"no benchmark '{unknown[0]}'; there are: {', '.join(found)}")
    console = Console(width=None if sys.stdout.isatty() else 140)
    for name in names or found:
        module = importlib.import_module(f"benchmarks.bench_{name}")
        table = Table("what", "measured", "beside", title=(module.__doc__ or name).splitlines()[0])
        for row in module.rows():
            table.add_row(*row)
        console.print(table)


if __name__ == "__main__":
    main(sys.argv[1:])
