"""What happens to a figure that was drawn: written to a file, shown by a notebook."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def in_notebook() -> bool:
    """Whether this process is the kernel of a notebook."""
    shell: Any = sys.modules.get("IPython")
    return shell is not None and type(shell.get_ipython()).__name__ == "ZMQInteractiveShell"


def finished(figure: "Figure", path: str | Path | None) -> "Figure":
    """Write a figure where a path is given, and see to it that a notebook shows it.

    Parameters
    ----------
    figure : Figure
        Drawn by `damperlab.service.figures`.
    path : path, optional
        The suffix says how it is written: .png, .svg, .pdf.
    """
    if path is not None:
        from damperlab.service.figures.style import save

        save(figure, Path(path))
    if in_notebook():
        from IPython.core import pylabtools

        # what `%matplotlib inline` does for figures of pyplot, which these are not
        shell: Any = sys.modules["IPython"]
        tools: Any = pylabtools
        tools.select_figure_formats(shell.get_ipython(), {"png"})
    return figure
