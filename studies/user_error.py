"""Errors that a user can correct: a notebook shows the user's own lines and the message, without internal frames."""

import traceback
from pathlib import Path

_PACKAGE = Path(__file__).parents[1]


class UserError(Exception):
    """An error whose message alone tells the user what to do.

    In a script Python prints the usual traceback, with the same message as its last lines.
    """

    def _render_traceback_(self) -> list[str]:
        """Give the lines that IPython prints instead of its own; IPython looks for a method of this name."""
        frames = [
            frame for frame in traceback.extract_tb(self.__traceback__) if _of_user(Path(frame.filename))
        ]
        lines = "".join(traceback.format_list(frames)).splitlines()
        return [*lines, f"{type(self).__name__}: {self}"]


def _of_user(file: Path) -> bool:
    """Tell whether a frame belongs to the user: neither to this package nor to an installed one."""
    return _PACKAGE not in file.parents and "site-packages" not in file.parts
