"""What imports what, over the whole package."""

from graphlib import TopologicalSorter

from grimp import build_graph


def test_no_module_comes_back_to_itself_through_its_imports() -> None:
    """Imports inside functions count; those for types alone do not. CycleError names the modules of a circle."""
    graph = build_graph("damperlab", exclude_type_checking_imports=True)
    assert "damperlab.worker.solver.integrate" in graph.modules
    TopologicalSorter(
        {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    ).prepare()
