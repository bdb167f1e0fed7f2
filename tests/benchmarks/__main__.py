"""Runs benchmarks by name, or all of them: `python -m tests.benchmarks [NAME …] [--json]`.

A benchmark is a module of this folder with a function `run() -> dict` of JSON-able figures; none is asserted.
"""

import argparse
import importlib
import json
import os
import platform
import sys
from pathlib import Path
from typing import Any


def names() -> list[str]:
    """Every benchmark of this folder."""
    return sorted(path.stem for path in Path(__file__).parent.glob("*.py") if not path.stem.startswith("_"))


def machine() -> dict[str, Any]:
    """On what the figures were measured."""
    return {"processor": platform.processor() or platform.machine(), "cores": os.cpu_count()}


def main() -> int:
    """Run what the command line names."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(names())}; all by default")
    parser.add_argument("--json", action="store_true", help="one JSON document on standard output")
    arguments = parser.parse_args()
    if unknown := sorted(set(arguments.names) - set(names())):
        parser.error(f"no benchmark {', '.join(unknown)}; there are {', '.join(names())}")
    figures: dict[str, Any] = {"machine": machine()}
    for name in arguments.names or names():
        print(f"{name} …", file=sys.stderr, flush=True)
        figures[name] = importlib.import_module(f"tests.benchmarks.{name}").run()
        if not arguments.json:
            for key, value in figures[name].items():
                print(
                    f"  {key}: {value:.6g}" if isinstance(value, float) else f"  {key}: {value}", flush=True
                )
    if arguments.json:
        print(json.dumps(figures, indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
