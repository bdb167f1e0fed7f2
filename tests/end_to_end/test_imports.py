"""What imports what, over the whole package."""

import subprocess
import sys
from graphlib import TopologicalSorter

from grimp import build_graph


def test_no_module_comes_back_to_itself_through_its_imports() -> None:
    """Imports inside functions count; those for types alone do not. CycleError names the modules of a circle."""
    graph = build_graph("damperlab", exclude_type_checking_imports=True)
    assert "damperlab.worker.solver.integrate" in graph.modules
    TopologicalSorter(
        {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    ).prepare()


def test_a_worker_loads_no_catalogue_no_labelled_arrays_and_no_web() -> None:
    """What it needs to be examined and to compute a block."""
    others = ("sqlalchemy", "xarray", "pandas", "zarr", "fastapi", "typer", "matplotlib")
    asked = f"print([name for name in {others} if name in sys.modules])"
    program = f"import sys, damperlab.worker.worker_process.examination; {asked}"
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"
