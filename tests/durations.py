"""How long each file of tests takes: what decides the order in which they begin. `make lint` names files never measured."""

import json
import sys
from pathlib import Path

HERE = Path(__file__).parent
FILE = HERE / "durations.json"


def measured() -> dict[str, float]:
    """Read the seconds of each file, by its path below `tests`."""
    seconds: dict[str, float] = json.loads(FILE.read_text())
    return seconds


def main() -> None:
    """Fail where a file has no entry, or an entry no file."""
    there = {file.relative_to(HERE).as_posix() for file in HERE.rglob("test_*.py")}
    known = set(measured())
    for name in sorted(there - known):
        print(
            f"tests/{name} has no entry in tests/durations.json: run it with DAMPERLAB_DURATIONS set to that file"
        )
    for name in sorted(known - there):
        print(f"tests/durations.json names tests/{name}, which is not there")
    sys.exit(there != known)


if __name__ == "__main__":
    main()
