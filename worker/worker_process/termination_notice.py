"""An address that says when this machine is about to be taken away, as those of spot markets do."""

from http.client import HTTPConnection, HTTPException, HTTPSConnection
from urllib.parse import urlsplit

ASK_SECONDS = 5.0
"""Between two questions: notices come 30 to 120 s ahead."""
ANSWER_SECONDS = 2.0
"""Longest time that one may take."""
_NOT_YET = (b"false", b"none", b"")


def faulty(url: str) -> str | None:
    """Say what is wrong with an address that is to be asked; None where it can be."""
    try:
        parts = urlsplit(url)
        usable = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
    except ValueError:
        usable = False
    return None if usable else f"{url!r} is no address such as http://169.254.169.254/…"


def announced(url: str) -> bool:
    """Ask whether this machine is to go.

    Parameters
    ----------
    url : str
        Answers 200 once it is, and something else before; FALSE, NONE or nothing in a body of 200 is no notice either.
        Redirects are not followed, and no proxy is used.

    Returns
    -------
    bool
        False too where nobody answers: a notice is a courtesy.
    """
    parts = urlsplit(url)
    kind = HTTPSConnection if parts.scheme == "https" else HTTPConnection
    connection = kind(str(parts.hostname), parts.port, timeout=ANSWER_SECONDS)
    path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
    try:
        # without it Google's address refuses
        connection.request("GET", path, headers={"Metadata-Flavor": "Google"})
        answer = connection.getresponse()
        return answer.status == 200 and answer.read(64).strip().lower() not in _NOT_YET
    except (OSError, HTTPException):
        return False
    finally:
        connection.close()
