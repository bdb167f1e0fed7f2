"""Are steady answers true? Random design points of the whole cube, each against a plain march that looks for nothing.

`python -m tests.benchmarks.steady [POINTS] [CYCLES]` prints every answer that is off; as part of `make bench` it prints its
table only. What is compared, and how, is in `damperlab.worker.accuracy.steady_answers`.
"""

import argparse
import sys
from itertools import islice
from typing import Any

from damperlab.worker.accuracy.steady_answers import MODELS, every, points, table


def run(count: int = 3000, cycles: int = 10_000, seed: int = 1) -> dict[str, Any]:
    """Three of four points with impacts that take no time, every eighth with a dwell, every eighth with a compliant wall."""
    return table(list(every(islice(points(seed), count), cycles)))


def main() -> None:
    """Print every answer that is off, and the table."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.steady", description=__doc__)
    parser.add_argument("points", nargs="?", type=int, default=300)
    parser.add_argument("cycles", nargs="?", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--models", nargs="+", default=list(MODELS), choices=["instant", "dwell", "compliant", "friction"]
    )
    parser.add_argument("--force", action="store_true", help="a force on the structure, no shaken base")
    asked = parser.parse_args()
    answers = []
    for one in every(
        islice(points(asked.seed, tuple(asked.models)), asked.points), asked.cycles, asked.force
    ):
        answers.append(one)
        if one.verdict != "agrees":
            print(
                one.verdict, one.deviation, tuple(one.point), one.response, one.truth, sep="\n  ", flush=True
            )
    for name, value in table(answers).items():
        print(f"{name}: {value}")


if __name__ == "__main__":
    sys.exit(main())
