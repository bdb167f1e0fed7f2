"""The command `damperlab`, also run by ``python -m damperlab``.

Without the extra `service`, the command only says what to install.
"""

import gc
import sys
from importlib.util import find_spec

NEEDED = ("typer", "pydantic_settings", "sqlalchemy", "distributed", "numba")
"""Packages that every command needs, and that the extra `service` installs."""


def main() -> None:
    """Run the command that the arguments name, and end the process with its exit status."""
    if sys.argv[1:] == ["--version"]:  # works without the extra `service` too
        from damperlab import __version__

        print(f"damperlab {__version__}")
        return
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        print(
            f"damperlab: this installation holds the Python client alone ({', '.join(missing)} not installed). "
            "Commands need the rest: pip install 'damperlab[service]'",
            file=sys.stderr,
        )
        sys.exit(1)
    gc.disable()  # imports leave little garbage, and collecting it takes a sixth of the import time
    from damperlab.service.cli.main import main as run

    gc.enable()
    run()


if __name__ == "__main__":
    main()
