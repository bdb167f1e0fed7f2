"""Parameter studies of a hybrid vibration damper: particle impact and Coulomb friction.

The public interface::

    from damperlab import Client, Study, read_study, open_store

``Client``
    A connection to a damperlab service, which computes studies and answers questions about them.
``Study``
    The definition of a study: a grid of design points, how each is computed, and what is stored.
``read_study``
    Read and check a definition from a JSON or YAML file, or a named study such as ``figure-11``.
``open_store``
    Open the studies of a data folder on this machine. Needs ``pip install 'damperlab[service]'``.

What is imported from deeper modules may change between minor versions.
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
"""Where each public name is defined; imported at first use (PEP 562), so that `import damperlab` costs nothing."""


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
