"""Parameter studies of a hybrid vibration damper: particle impact and Coulomb friction.

The public interface::

    from damperlab import Client, Study, read_study, open_store

``Client``
    A connection to a damperlab service, which computes studies and answers questions about them.
``Study``
    The definition of a study: the grid of design points, the method of computation, and the results to store.
``read_study``
    Read and check a definition from a JSON or YAML file, or a named study such as ``figure-11``.
``open_store``
    Open the store of studies in a data folder of this machine. Needs ``pip install 'damperlab[service]'``.

Names in deeper modules may change between minor versions.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from damperlab.service.client import Client
    from damperlab.studies.definition import Study
    from damperlab.studies.reading import read_study
    from damperlab.studies.store.opening import open_store

__all__ = ["Client", "Study", "__version__", "open_store", "read_study"]

_PLACES = {
    "Client": "damperlab.service.client",
    "Study": "damperlab.studies.definition",
    "open_store": "damperlab.studies.store.opening",
    "read_study": "damperlab.studies.reading",
}
"""Module of each public name, imported at the first use of the name (PEP 562), so that `import damperlab` is fast."""


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        value: Any = version("damperlab")
    elif name in _PLACES:
        value = getattr(import_module(_PLACES[name]), name)
    else:
        raise AttributeError(f"module 'damperlab' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
