"""Output of a figure: written to a file, or displayed by a notebook."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def in_notebook() -> bool:
    """Whether this process is a notebook's kernel."""
    shell: Any = sys.modules.get("IPython")
    return shell is not None and type(shell.get_ipython()).__name__ == "ZMQInteractiveShell"


def finished(figure: "Figure", path: str | Path | None) -> "Figure":
    """Write a figure if a path is given, and make a notebook display it.

    Parameters
    ----------
    figure : Figure
        Drawn by `damperlab.service.figures`.
    path : path, optional
        The suffix gives the format: .png, .svg, .pdf.
    """
    if path is not None:
        from damperlab.service.figures.style import save

        save(figure, Path(path))
    if in_notebook():
        from IPython.core import pylabtools

        # `%matplotlib inline` does this only for figures of pyplot
        shell: Any = sys.modules["IPython"]
        tools: Any = pylabtools
        tools.select_figure_formats(shell.get_ipython(), {"png"})
    return figure
