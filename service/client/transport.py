"""Requests to a service. A failed request is repeated with growing pauses, as long as repeating may help."""

import json
import logging
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from http import HTTPStatus
from typing import Any

import httpx
import numpy as np
import stamina

from damperlab.service.client.credentials import key_from_environment
from damperlab.service.client.faults import ClientFault, Problem, Unavailable, Unreachable, problem
from damperlab.service.client.faults import refused as refused_here
from damperlab.studies.faults import Fault, describe
from damperlab.studies.spacing import evenly_spaced

PATIENCE_SECONDS = 60.0
"""Longest time for which a failed request is repeated [s], if the service has answered any earlier request.
A restart of the service takes less time.
"""
FIRST_SECONDS = 4.0
"""Longest time for which a failed request is repeated [s], if the service has never answered a request, for
example because the address is wrong.
"""
LONGEST_PAUSE_SECONDS = 5.0
PREFERRED = "respond-async, wait=20"
"""Header `Prefer`: an answer that takes longer than 20 s is deferred, so that no proxy closes the silent connection."""
PROMISED_AT = "/api/v1/answers/"
PROMISE_PAUSE_SECONDS = 0.5
LONGEST_REFUSAL = 1 << 20
"""Largest number of bytes that are read from a refusal."""

# Without this handler, the standard library prints a message about each pause into the progress bar.
logging.getLogger("stamina").addHandler(logging.NullHandler())


class Transport:
    """Requests to one service.

    Parameters
    ----------
    url : str
        Address of the service.
    api_key : str, optional
        Key of the service, sent as ``Authorization: Bearer …``; by default the key from `key_from_environment`.
    timeout_seconds : float
        Longest wait for one answer.

    Raises
    ------
    Refused
        If `url` is not an address.
    """

    def __init__(self, url: str, api_key: str | None, timeout_seconds: float) -> None:
        self.url = _checked(url)
        api_key = api_key or key_from_environment()
        self.headers = {"Authorization": f"Bearer {api_key}"} if api_key else {}
        self._http = httpx.Client(
            base_url=f"{self.url}/api/v1",
            headers={"User-Agent": "damperlab-client", "Prefer": PREFERRED, **self.headers},
            timeout=httpx.Timeout(timeout_seconds, connect=min(10.0, timeout_seconds)),
        )
        self._timeout_seconds = timeout_seconds
        self._met = False

    def close(self) -> None:
        """Close the connections."""
        self._http.close()

    def ask(self, method: str, path: str, **how: Any) -> Any:
        """Send a request and return the answer, read from JSON; None if the answer is empty.

        Every request can safely be sent twice. Studies and follow-ups are identified by their content. A simulation
        changes nothing. A second request to stop or delete a study has no further effect.

        Parameters
        ----------
        method, path : str
            Method and path, for example ``GET`` and ``/studies``.
        **how
            Arguments of `httpx.Client.request`; parameters that are None are omitted.

        Raises
        ------
        Problem
            If the service refuses the request.
        Unreachable
            If no service answers.
        """
        how["params"] = written(how.get("params") or {})
        try:
            response = self._answer(method, path, how)
        except ClientFault as fault:
            # raised here without the traceback of the retries, which would hide the message
            refusal = fault.with_traceback(None)
        else:
            return None if response is None or response.status_code == 204 else _json(response)
        raise refusal from None

    def _answer(self, method: str, path: str, how: Mapping[str, Any]) -> httpx.Response | None:
        """Send a request, and repeat the request as long as repeating may help.

        Return None if the request deletes something that an earlier attempt has already deleted.
        """
        for attempt in self.attempts():
            with attempt, self._translated():
                response = self._http.request(method, path, **how)
                if method == "DELETE" and response.status_code == 404 and attempt.num > 1:
                    return None
                _check(response)
                if response.headers.get("Location", "").startswith(PROMISED_AT):
                    response = self._fetched(response)
        return response

    def _fetched(self, promise: httpx.Response) -> httpx.Response:
        """Wait for a deferred answer. If the wait is interrupted, the deferred answer is cancelled."""
        give_up = time.monotonic() + self._timeout_seconds
        where = f"{self.url}{promise.headers['Location']}"
        response = promise
        try:
            while response.status_code == 202:
                if time.monotonic() > give_up:
                    raise httpx.ReadTimeout(f"{where} was not ready in time")
                time.sleep(PROMISE_PAUSE_SECONDS)
                response = self._http.get(where)
        except BaseException:
            with suppress(httpx.HTTPError):
                self._http.delete(where)
            raise
        if response.status_code == 404:
            # the service was restarted; status 503 makes `attempts` send the request again
            detail = "The service no longer has the deferred answer."
            raise problem({"status": 503, "title": "Service Unavailable", "detail": detail})
        _check(response)
        return response

    @contextmanager
    def stream(self, path: str, **how: Any) -> Iterator[httpx.Response]:
        """Open an answer, to read it piece by piece. The request is not repeated."""
        how["params"] = written(how.get("params") or {})
        with self._translated(), self._http.stream("GET", path, **how) as response:
            if response.is_error:
                response.read()
            _check(response)
            yield response

    def attempts(self) -> Iterable[Any]:
        """Return an iterator over attempts at a request, with pauses between them.

        It ends when repeating cannot help.
        """
        seconds = PATIENCE_SECONDS if self._met else FIRST_SECONDS
        give_up = time.monotonic() + seconds

        def pause(error: Exception) -> bool | float:
            if isinstance(error, Unavailable):
                asked = _retry_after(error)
                if asked is None:
                    return True
                # if the requested pause is longer than the remaining time, the request is not repeated
                return asked if time.monotonic() + asked < give_up else False
            return isinstance(error, Unreachable) and isinstance(error.__cause__, httpx.TransportError)

        return stamina.retry_context(
            pause, attempts=None, timeout=seconds, wait_max=LONGEST_PAUSE_SECONDS, wait_jitter=0.1
        )

    @contextmanager
    def _translated(self) -> Iterator[None]:
        try:
            yield
            self._met = True
        except Problem:
            self._met = True
            raise
        except httpx.ReadTimeout as error:
            # The service is still computing the answer; a repeated request would start the computation again.
            message = f"{self.url} took longer than {self._timeout_seconds:g} s to answer; wait longer with Client(timeout=…)."
            raise Unreachable(message) from RuntimeError(str(error))
        except httpx.TransportError as error:
            advice = "Is `damperlab serve` running there?"
            raise Unreachable(f"No service answers at {self.url}: {error}. {advice}") from error
        except (httpx.InvalidURL, httpx.DecodingError) as error:
            raise Unreachable(f"No answer from {self.url} that can be read: {error}.") from None


def written(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Write query parameters as the routes read them: None is left out, and a pair becomes `lower,higher`."""
    texts: dict[str, Any] = {}
    for name, value in parameters.items():
        if isinstance(value, bool):
            texts[name] = str(value).lower()
        elif isinstance(value, list | tuple):
            texts[name] = ",".join(_spelled(each) for each in value)
        elif value is not None:
            texts[name] = _spelled(value)
    return texts


def _spelled(value: Any) -> str:
    # a NumPy scalar is first converted into a Python number
    return str(value.item() if hasattr(value, "dtype") else value)


def body(document: Mapping[str, Any] | Sequence[Any]) -> dict[str, Any]:
    """Return the arguments of `Transport.ask` that send a document as JSON. NumPy arrays become ranges or lists."""
    text = json.dumps(document, default=_axis)
    return {"content": text.encode(), "headers": {"Content-Type": "application/json"}}


def _axis(value: Any) -> Any:
    """Write a NumPy array as a range if its values are evenly spaced up to rounding errors, otherwise as a list."""
    values = value.tolist()
    if np.ndim(value) == 1 and len(values) > 2 and np.isfinite(value).all():
        start, stop, num = values[0], values[-1], len(values)
        if np.abs(value - evenly_spaced(start, stop, num)).max() <= 4 * np.spacing(np.abs(value).max()):
            return {"start": start, "stop": stop, "num": num}
    return values


def _checked(url: str) -> str:
    advice = "write it as http://HOST:PORT"
    try:
        parsed = httpx.URL(url)
    except (httpx.InvalidURL, TypeError):
        raise refused_here((Fault("url", describe(url), "an address", advice),)) from None
    if parsed.scheme not in ("http", "https") or not parsed.host:
        raise refused_here((Fault("url", describe(url), "an address with http:// or https://", advice),))
    return url.rstrip("/").removesuffix("/api/v1")


def _check(response: httpx.Response) -> None:
    if response.is_success:
        return
    try:
        document = json.loads(response.content[:LONGEST_REFUSAL])
    except ValueError:
        document = None
    if not (isinstance(document, dict) and isinstance(document.get("status"), int)):
        known = {status.value: status.phrase for status in HTTPStatus}
        title = known.get(response.status_code, "unknown status")
        if response.status_code == 404 or response.is_redirect:
            what = response.headers.get("content-type", "nothing").partition(";")[0]
            raise Unreachable(
                f"{response.url} answers {response.status_code} {title} with {what}, which is not an answer "
                "of a damperlab service. Is the address right?"
            )
        document = {"status": response.status_code, "title": title, "detail": f"From {response.url}."}
    error = problem(document)
    if "retry-after" in response.headers:
        error.document["retry_after"] = response.headers["retry-after"]
    raise error


def _retry_after(error: Problem) -> float | None:
    try:
        return max(0.0, float(error.document.get("retry_after", "")))
    except ValueError:
        return None  # the header is missing or holds a date; the usual pause is used


def _json(response: httpx.Response) -> Any:
    try:
        return response.json()
    except ValueError:
        what = response.headers.get("content-type", "nothing").partition(";")[0]
        raise Unreachable(
            f"{response.url} answers with {what}, which is not an answer of a damperlab service. Is the "
            "address right?"
        ) from None
