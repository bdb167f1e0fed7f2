"""What imports what, over the whole package."""

import subprocess
import sys
from graphlib import TopologicalSorter

import pytest
from grimp import build_graph


def test_no_module_comes_back_to_itself_through_its_imports() -> None:
    """Imports inside functions count; those for types alone do not. CycleError names the modules of a circle."""
    graph = build_graph("damperlab", exclude_type_checking_imports=True)
    assert "damperlab.worker.solver.integrate" in graph.modules
    TopologicalSorter(
        {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    ).prepare()


@pytest.mark.parametrize(
    ("module", "others"),
    [
        # what a worker needs to be examined and to compute a block
        ("worker.worker_process.examination", "sqlalchemy xarray pandas zarr fastapi typer matplotlib"),
        (
            "service.cli.main",
            "numba dask distributed xarray zarr matplotlib fastapi sqlalchemy pydantic numpy",
        ),
        ("service.app", "numba dask distributed xarray scipy h5py matplotlib weasyprint"),
    ],
)
def test_what_begins_often_loads_no_more_than_it_needs(module: str, others: str) -> None:
    asked = f"print([name for name in {others.split()} if name in sys.modules])"
    program = f"import sys, damperlab.{module}; {asked}"
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"
