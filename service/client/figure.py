"""Output of a figure to a file or in a notebook."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def in_notebook() -> bool:
    """Return whether this process is the kernel of a notebook."""
    shell: Any = sys.modules.get("IPython")
    return shell is not None and type(shell.get_ipython()).__name__ == "ZMQInteractiveShell"


def finished(figure: "Figure", path: str | Path | None) -> "Figure":
    """Write a figure if a path is given, and make a notebook display it.

    Parameters
    ----------
    figure : Figure
        Figure from `damperlab.service.figures`.
    path : path, optional
        File to write; the suffix gives the format: .png, .svg or .pdf.
    """
    if path is not None:
        from damperlab.service.figures.style import save

        save(figure, Path(path))
    if in_notebook():
        from IPython.core import pylabtools

        # `%matplotlib inline` selects a format only for figures of pyplot
        shell: Any = sys.modules["IPython"]
        tools: Any = pylabtools
        tools.select_figure_formats(shell.get_ipython(), {"png"})
    return figure
