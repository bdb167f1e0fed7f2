"""Read the client's key from the environment, or from a file that other users cannot read."""

import os
import stat
from pathlib import Path

from damperlab.service.client.faults import refused
from damperlab.studies.faults import Fault

KEY = "DAMPERLAB_KEY"
KEY_FILE = "DAMPERLAB_KEY_FILE"


def key_from_environment() -> str | None:
    """Return the key from ``DAMPERLAB_KEY``, or from the file that ``DAMPERLAB_KEY_FILE`` names.

    Return None if neither variable is set.

    Raises
    ------
    Refused
        If the file cannot be read, holds no key, or is readable by other users.
    """
    key = os.environ.get(KEY, "").strip()
    if key:
        return key
    named = os.environ.get(KEY_FILE, "").strip()
    if not named:
        return None
    path = Path(named).expanduser()
    try:
        with path.open(encoding="ascii") as file:
            mode = stat.S_IMODE(os.fstat(file.fileno()).st_mode)
            key = file.read(1000).strip()
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or "it holds no key"
        raise refused(
            (
                Fault(
                    KEY_FILE,
                    f"{path}: {reason}",
                    "a file that holds a key",
                    "name another file",
                    f"The key cannot be read from {path}, which {KEY_FILE} names: {reason}.",
                ),
            )
        ) from None
    if os.name == "posix" and mode & 0o077:
        found = f"{path}, which others can read (mode {mode:04o})"
        told = f"Others can read {path}, which holds a key (mode {mode:04o})."
        raise refused((Fault(KEY_FILE, found, "a file of mode 0600", f"run `chmod 600 {path}`", told),))
    if not key or "\n" in key:
        raise refused(
            (
                Fault(
                    KEY_FILE,
                    f"no key in {path}",
                    "one key, on one line",
                    "write one key into it, on one line",
                    f"{path}, which {KEY_FILE} names, does not hold one key.",
                ),
            )
        )
    return key
