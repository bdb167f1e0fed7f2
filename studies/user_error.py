"""Errors that a user can correct. A notebook shows only the user's lines and the message, without internal frames."""

import traceback
from pathlib import Path

_PACKAGE = Path(__file__).parents[1]


class UserError(Exception):
    """An error whose message tells the user how to correct it."""

    def _render_traceback_(self) -> list[str]:
        """Return the lines that IPython prints instead of the full traceback."""
        frames = [
            frame for frame in traceback.extract_tb(self.__traceback__) if _of_user(Path(frame.filename))
        ]
        lines = "".join(traceback.format_list(frames)).splitlines()
        return [*lines, f"{type(self).__name__}: {self}"]


def _of_user(file: Path) -> bool:
    """Return whether a frame is the user's code, and not code of this package or of an installed package."""
    return _PACKAGE not in file.parents and "site-packages" not in file.parts
