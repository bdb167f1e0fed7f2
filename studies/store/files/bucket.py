"""A storage location in a bucket of an object store with S3's protocol.

The address of the server and the keys come only from environment variables such as AWS_ENDPOINT_URL, AWS_REGION,
AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY. The keys are not stored, logged or sent to workers.
"""

import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from datetime import timedelta
from functools import lru_cache
from typing import Any
from urllib.parse import urlsplit

from damperlab.studies.faults import describe
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.files.shelf import AT_ONCE, Entry, Shelf, ShelfAway, removed_last

CONNECT_SECONDS = 5
REQUEST_SECONDS = 20
"""Longest duration of one attempt [s]. A request that takes longer is repeated."""
RETRIES = 50
"""Largest number of repetitions of a request. `RETRY_SECONDS` is reached before this number."""
RETRY_SECONDS = 10
"""Time since the first attempt after which a request is not repeated [s]."""
_BACKOFF_SECONDS = (0.1, 5.0)

_KEYS = (
    {"AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"},
    {"AWS_WEB_IDENTITY_TOKEN_FILE", "AWS_ROLE_ARN"},
    {"AWS_CONTAINER_CREDENTIALS_RELATIVE_URI"},
    {"AWS_CONTAINER_CREDENTIALS_FULL_URI"},
    {"AWS_METADATA_ENDPOINT"},
)
"""Sets of environment variables that provide keys. One set is sufficient."""

_ALLOWED = "s3://bucket or s3://bucket/prefix"


class Bucket(Shelf):
    """A bucket, or the objects of a bucket whose names begin with a prefix.

    Parameters
    ----------
    client : obstore's S3Store
        Client of the bucket.
    bucket, prefix : str
        Name of the bucket, and prefix of the objects' names. An empty prefix stands for the complete bucket.
    """

    readers = AT_ONCE
    first_bytes = (
        1 << 16
    )  # large enough for most blocks: a second request costs more than the additional bytes

    def __init__(self, client: Any, bucket: str, prefix: str) -> None:
        super().__init__(f"s3://{bucket}/{prefix}".rstrip("/"))
        self._client = client
        self._bucket = bucket
        self._prefix = prefix

    def __reduce__(self) -> tuple[Callable[[str], "Bucket"], tuple[str]]:
        """Pickle only the address, so that another process opens the bucket with its own keys."""
        return open_bucket, (self.address,)

    def at(self, name: str) -> "Bucket":
        """Return the storage location with the prefix `prefix/name`."""
        return Bucket(self._client, self._bucket, self._full(name))

    def get(self, key: str) -> bytes:
        """Read an object."""
        with _told(self, key):
            return bytes(self._client.get(self._full(key)).bytes())

    def read(self, key: str, start: int, length: int) -> bytes:
        """Read a range of bytes of an object. The result is empty if the range begins after the end of the object."""
        with _told(self, key):
            return _range(self._client, self._full(key), start, length)

    def stamp(self, key: str) -> tuple[int, ...]:
        """Return an empty tuple, because detecting a change of an object would need a request."""
        return ()

    def put(self, key: str, content: bytes) -> None:
        """Write an object. At any time the object is either complete or absent."""
        with _told(self, key):
            # an interrupted upload in several parts could leave parts that no listing shows
            self._client.put(self._full(key), content, use_multipart=False)

    def put_new(self, key: str, content: bytes) -> bool:
        """Write an object if no object has this name. Return whether the object now has this content."""
        from obstore.exceptions import AlreadyExistsError

        with _told(self, key):
            try:
                self._client.put(self._full(key), content, mode="create")
            except AlreadyExistsError:
                # if the answer to the first attempt was lost, this request may itself have written the object
                return self.get(key) == content
        return True

    def fill(self, pieces: Mapping[str, bytes], shelves: Iterable[str] = ()) -> None:
        """Write objects. A prefix need not be created."""
        self._put_all(pieces)

    def make(self, shelves: Mapping[str, Mapping[str, bytes]], below: Iterable[str] = ()) -> None:
        """Write the initial objects of several prefixes in parallel."""
        self._put_all(
            {f"{name}/{key}": content for name, pieces in shelves.items() for key, content in pieces.items()}
        )

    def _put_all(self, pieces: Mapping[str, bytes]) -> None:
        with ThreadPoolExecutor(AT_ONCE) as pool:
            for _ in pool.map(self.put, pieces, pieces.values()):
                pass

    def entries(self) -> Iterator[Entry]:
        """List every object."""
        prefix = self._full("")
        with _told(self, ""):
            for some in self._client.list(prefix or None):
                for found in some:
                    yield Entry(
                        str(found["path"]).removeprefix(prefix),
                        int(found["size"]),
                        found["last_modified"].timestamp(),
                    )

    def shelves(self) -> Iterator[str]:
        """Yield the names of the storage locations directly below this location."""
        with _told(self, ""):
            found = self._client.list_with_delimiter(self._full("") or None)
        for prefix in found["common_prefixes"]:
            yield str(prefix).rstrip("/").rpartition("/")[2]

    def made(self) -> float:
        """Return 0, because a prefix has no time of change."""
        return 0.0

    def remove(self, key: str) -> None:
        """Remove an object."""
        with _told(self, key):
            self._client.delete(self._full(key))

    def clear(self) -> None:
        """Remove every object; the JSON documents are removed last."""
        steps: dict[tuple[bool, bool], list[str]] = {}
        for entry in self.entries():
            steps.setdefault(removed_last(entry.key), []).append(self._full(entry.key))
        with _told(self, ""):
            for step in sorted(steps):
                # a server may remove the objects of one request in any order, so each step is a separate request
                for start in range(0, len(steps[step]), 1000):
                    self._client.delete(steps[step][start : start + 1000])

    def _full(self, key: str) -> str:
        return f"{self._prefix}/{key}" if self._prefix else key


def _range(client: Any, path: str, start: int, length: int) -> bytes:
    from obstore.exceptions import BaseError

    try:
        return bytes(client.get_range(path, start=start, length=length))
    except FileNotFoundError:
        raise
    except (BaseError, ValueError) as error:
        # servers (status 416) and the library refuse a range beyond the end of the object
        if "range" not in str(error).lower():
            raise
    return bytes(client.get(path).bytes())[start : start + length]


def open_bucket(address: str) -> Bucket:
    """Return the storage location at an address, `s3://bucket` or `s3://bucket/prefix`.

    Raises
    ------
    StoreFault
        If the address is invalid, the library for S3 is not installed, the environment has no keys, or the
        server's address begins with `http:` and plain HTTP is not allowed.
    """
    found = re.fullmatch(r"s3://([a-z0-9][a-z0-9.-]{1,61}[a-z0-9])(?:/([A-Za-z0-9!_.*'()/-]*))?", address)
    prefix = (found[2] or "").strip("/") if found else ""
    if found is None or (prefix and not {"", ".", ".."}.isdisjoint(prefix.split("/"))):
        raise StoreFault(
            "store", _without_secrets(address), _ALLOWED, "use lower-case letters, digits and hyphens"
        )
    variables = tuple(sorted(item for item in os.environ.items() if item[0].startswith("AWS_")))
    return Bucket(_client(found[1], variables), found[1], prefix)


@lru_cache(maxsize=8)
def _client(bucket: str, variables: tuple[tuple[str, str], ...]) -> Any:
    # all threads share one client, which reuses connections
    try:
        from obstore.store import S3Store
    except ImportError:
        found = "an address of an object store, for which the library is not installed"
        told = "The library that reads object stores is not installed."
        raise StoreFault("store", found, _ALLOWED, "install damperlab[s3]", told) from None
    _require_keys()
    shortest, longest = _BACKOFF_SECONDS
    try:
        return S3Store(
            bucket,
            client_options={
                "allow_http": _plain_http_allowed(),
                "connect_timeout": timedelta(seconds=CONNECT_SECONDS),
                "timeout": timedelta(seconds=REQUEST_SECONDS),
            },
            retry_config={
                "max_retries": RETRIES,
                "retry_timeout": timedelta(seconds=RETRY_SECONDS),
                "backoff": {
                    "init_backoff": timedelta(seconds=shortest),
                    "max_backoff": timedelta(seconds=longest),
                    "base": 2,
                },
            },
        )
    except Exception as error:  # the library raises various exceptions for an invalid AWS_… variable
        raise StoreFault(
            "AWS_…",
            _first_line(error),
            "variables that describe an S3 server",
            "correct the AWS_… variables of the environment",
            f"The object store cannot be opened with these settings: {_first_line(error).rstrip('.')}.",
        ) from error


def _require_keys() -> None:
    """Raise `StoreFault` if the environment neither names keys nor allows access without keys."""
    given = {name for name, value in os.environ.items() if value}
    unsigned = os.environ.get("AWS_SKIP_SIGNATURE", "").lower() in ("true", "1")
    asked = os.environ.get("AWS_EC2_METADATA_DISABLED", "").lower() == "false"
    if unsigned or asked or any(way <= given for way in _KEYS):
        return
    raise StoreFault(
        "AWS_ACCESS_KEY_ID",
        "no keys for the object store",
        "AWS_ACCESS_KEY_ID with AWS_SECRET_ACCESS_KEY, or an identity that the environment names",
        "set both; or set AWS_EC2_METADATA_DISABLED=false to get keys from the cloud's metadata address, "
        "or AWS_SKIP_SIGNATURE=true to send unsigned requests",
        "There are no keys for the object store: AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY are not "
        "both set, and the environment names no identity.",
    )


def _plain_http_allowed() -> bool:
    endpoint = os.environ.get("AWS_ENDPOINT_URL_S3") or os.environ.get("AWS_ENDPOINT_URL") or ""
    parts = urlsplit(endpoint)
    if parts.scheme != "http":
        return False
    loopback = parts.hostname in ("localhost", "::1") or (parts.hostname or "").startswith("127.")
    if loopback or os.environ.get("AWS_ALLOW_HTTP", "").lower() in ("true", "1"):
        return True
    raise StoreFault(
        "AWS_ENDPOINT_URL",
        f"http://{parts.hostname}, over which data would travel unencrypted",
        "https://…, or http:// on this machine",
        "use https, or set AWS_ALLOW_HTTP=true in a network that you trust",
        f"The object store is at http://{parts.hostname}, where data would travel unencrypted; http:// is allowed on "
        "this machine only.",
    )


@contextmanager
def _told(shelf: Bucket, key: str) -> Iterator[None]:
    """Convert an error of the library to an OSError whose message has one line and no text for developers."""
    from obstore.exceptions import BaseError, PermissionDeniedError, UnauthenticatedError

    where = f"{shelf.address}/{key}".rstrip("/")
    try:
        yield
    except FileNotFoundError as error:
        if "NoSuchBucket" in str(error):
            raise ShelfAway(f"{where}: there is no such bucket") from None
        raise FileNotFoundError(f"{where}: there is no such object") from None
    except (PermissionDeniedError, UnauthenticatedError) as error:
        raise PermissionError(
            f"{where}: the server refuses ({_first_line(error)}); check AWS_ACCESS_KEY_ID and "
            "AWS_SECRET_ACCESS_KEY here and on every worker"
        ) from None
    except BaseError as error:
        raise ShelfAway(f"{where}: {_first_line(error)}") from None


def _first_line(error: BaseException) -> str:
    """Return a short description of the library's error, which may contain addresses but no keys."""
    text = str(error).partition("\n")[0]
    text = re.sub(r", max_retries: \d+, retry_timeout: \S+", "", text)
    code = re.search(r"<Code>(\w+)</Code>", str(error))
    text = re.sub(r"^.*?Error performing", "error performing", text).partition("<?xml")[0].strip(" :-")
    return f"{text} ({code[1]})" if code else text


def _without_secrets(address: str) -> str:
    return describe(re.sub(r"//[^/@]*@", "//…@", address))
