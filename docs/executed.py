"""The notebooks, run from top to bottom and kept with what they print and draw: `python -m docs.executed`."""

import os
import tempfile
from pathlib import Path
from typing import Any

import nbformat
from docs.computed import record
from docs.console import ROOT
from docs.running import service
from nbclient import NotebookClient

NOTEBOOKS = Path(__file__).parent / "notebooks"


def execute(path: Path, url: str, folder: Path) -> Any:
    """Run a notebook against a service.

    Parameters
    ----------
    path : path
        Of the notebook.
    url : str
        Of the service.
    folder : path
        Where it runs.
    """
    notebook = nbformat.read(path, as_version=4)  # type: ignore[no-untyped-call]
    environment = os.environ | {"DAMPERLAB_URL": url, "IPYTHONDIR": str(folder / "ipython")}
    NotebookClient(
        notebook, timeout=600, startup_timeout=600, resources={"metadata": {"path": str(folder)}}
    ).execute(env=environment)
    return notebook


def lasting(notebook: Any) -> Any:
    """Take out what differs from run to run: bars of progress, times, addresses in memory."""
    for number, cell in enumerate(notebook.cells):
        cell.metadata = {}
        cell.id = f"cell-{number}"
        if cell.cell_type != "code":
            continue
        cell.execution_count = None
        cell.outputs = [
            each for each in cell.outputs if "<progress" not in str(each.get("data", {}).get("text/html", ""))
        ]
        for each in cell.outputs:
            each.pop("execution_count", None)
            if each.output_type == "execute_result":
                each.execution_count = None
            if "image/png" in each.get("data", {}):
                each.data = {"image/png": each.data["image/png"]}
                each.metadata = {}
    notebook.metadata.pop("widgets", None)
    return notebook


def main() -> None:
    """Run every notebook, and write it with its outputs."""
    with service() as url, tempfile.TemporaryDirectory() as folder:
        for path in sorted(NOTEBOOKS.glob("*.ipynb")):
            nbformat.write(lasting(execute(path, url, Path(folder))), path)  # type: ignore[no-untyped-call]
            record([path.relative_to(ROOT).as_posix()])
            print(path.name, path.stat().st_size)


if __name__ == "__main__":
    main()
