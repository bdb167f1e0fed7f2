"""Write every figure of the documentation, or those that are named."""

import sys
from pathlib import Path

from docs.computed import record
from docs.drawing.figures import FIGURES, key_of, write

FOLDER = Path(__file__).parents[1] / "figures"

for name in sys.argv[1:] or FIGURES:
    write(name, FOLDER)
    record([key_of(name)])
    print(f"{name}.svg", (FOLDER / f"{name}.svg").stat().st_size)
