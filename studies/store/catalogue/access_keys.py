"""Access keys of a service. The catalogue stores only the hashes of the keys."""

import hmac
import re
import secrets
import time
from dataclasses import dataclass
from datetime import datetime
from hashlib import sha256
from typing import Any, cast

from sqlalchemy import Row, insert, select, update

from damperlab.studies.faults import NOTHING, describe, listing, printable
from damperlab.studies.store.catalogue.catalogue import Catalogue
from damperlab.studies.store.catalogue.rowsum import is_sound
from damperlab.studies.store.catalogue.tables import access_keys
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.record import utc
from damperlab.studies.vocabulary import SCOPES, Scope

_KEY = re.compile(r"dlk_([0-9a-f]{12})_([A-Za-z0-9_-]{43})")
_OWNER = re.compile(r"[^\s\x00-\x1f\x7f](?:[^\x00-\x1f\x7f]{0,98}[^\s\x00-\x1f\x7f])?")


class KeyFault(StoreFault):
    """An access key cannot be created or does not exist."""


@dataclass(frozen=True)
class AccessKey:
    """An access key as the catalogue stores it, without the secret part.

    Parameters
    ----------
    id : str
        Public part of the key.
    owner : str
        Owner of the key and of the studies that are submitted with it.
    scopes : tuple of str
        Scopes of the key, in the order of `SCOPES`.
    created, expires, revoked : datetime
        Times of creation, expiry and revocation in UTC; None if the key does not expire or was not revoked.
    hash : str
        SHA-256 hash of the secret, 64 hex digits. A session stores the hash, to recognise the key.
    sound : bool
        Whether the row in the catalogue is intact. A key with a damaged row is not valid.
    """

    id: str
    owner: str
    scopes: tuple[Scope, ...]
    created: datetime | None
    expires: datetime | None
    revoked: datetime | None
    hash: str
    sound: bool = True

    @property
    def valid(self) -> bool:
        """Whether the key can be used now."""
        lasts = self.expires is None or self.expires.timestamp() > time.time()
        return self.sound and self.revoked is None and lasts

    def document(self) -> dict[str, Any]:
        """Return the public fields, with values that JSON can represent."""
        times = {
            name: None if (at := getattr(self, name)) is None else at.isoformat()
            for name in ("created", "expires", "revoked")
        }
        return {
            "id": self.id,
            "owner": self.owner,
            "scopes": list(self.scopes),
            **times,
            "valid": self.valid,
        }


class AccessKeys:
    """The access keys in a catalogue.

    Parameters
    ----------
    catalogue : Catalogue
        The catalogue.
    """

    def __init__(self, catalogue: Catalogue) -> None:
        self._catalogue = catalogue

    def create(
        self, owner: str, scopes: tuple[Scope, ...], lasts_seconds: float | None = None
    ) -> tuple[AccessKey, str]:
        """Create an access key.

        Parameters
        ----------
        owner : str
            Owner of the key: one line of 1 to 100 characters.
        scopes : tuple of str
            One or more of `SCOPES`. The key also gets all lower scopes.
        lasts_seconds : float, optional
            Time until the key expires [s]; by default it does not expire.

        Returns
        -------
        key : AccessKey
            The new key without the secret part.
        secret : str
            The key with its secret part, which is not stored and cannot be shown again.

        Raises
        ------
        KeyFault
            If the owner or a scope is invalid.
        """
        if not _OWNER.fullmatch(owner):
            raise KeyFault(
                "owner", describe(owner), "a line of 1 to 100 characters", "name a person or a program"
            )
        strange = [scope for scope in scopes if scope not in SCOPES]
        if strange or not scopes:
            found = describe(strange[0]) if strange else NOTHING
            raise KeyFault("scope", found, f"one of {listing(SCOPES)}", "choose one of these")
        highest = max(SCOPES.index(scope) for scope in scopes)
        key_id, secret = secrets.token_hex(6), secrets.token_urlsafe(32)
        now = time.time()
        with self._catalogue.writing() as connection:
            connection.execute(
                insert(access_keys).values(
                    id=key_id,
                    hash=_hashed(secret),
                    owner=owner,
                    scopes=",".join(SCOPES[: highest + 1]),
                    created=now,
                    expires=None if lasts_seconds is None else now + lasts_seconds,
                )
            )
        made = self.find(key_id)
        assert made is not None
        return made, f"dlk_{key_id}_{secret}"

    def all(self) -> list[AccessKey]:
        """Return all keys, the oldest first."""
        with self._catalogue.reading() as connection:
            rows = connection.execute(select(access_keys).order_by(access_keys.c.created)).all()
        return [_key(row) for row in rows]

    def find(self, key_id: str) -> AccessKey | None:
        """Return the key with this id; None if there is no such key."""
        with self._catalogue.reading() as connection:
            row = connection.execute(select(access_keys).where(access_keys.c.id == key_id)).one_or_none()
        return None if row is None else _key(row)

    def revoke(self, key_id: str) -> AccessKey:
        """Revoke a key. If the key is already revoked, nothing changes.

        Raises
        ------
        KeyFault
            If there is no such key.
        """
        c = access_keys.c
        with self._catalogue.writing() as connection:
            live = update(access_keys).where(c.id == key_id, c.revoked.is_(None))
            connection.execute(live.values(revoked=time.time()))
        found = self.find(key_id)
        if found is None:
            raise KeyFault(
                "key",
                describe(key_id),
                "the id of a key",
                "`damperlab admin keys list` shows the keys and their ids",
                f"There is no key with the id {printable(key_id)}.",
            )
        return found

    def recognise(self, secret: str) -> AccessKey | None:
        """Return the valid key that a caller has sent; None if the text is not a valid key."""
        parts = _KEY.fullmatch(secret)
        found = None if parts is None else self.find(parts[1])
        # compare a hash also for an unknown id, so that the duration does not reveal which ids exist
        known = found.hash if found else "0" * 64
        same = hmac.compare_digest(known, _hashed(parts[2] if parts else ""))
        return found if found is not None and same and found.valid else None


def _hashed(secret: str) -> str:
    # a fast hash is sufficient, because 256 random bits cannot be guessed
    return sha256(secret.encode()).hexdigest()


def _key(row: Row[Any]) -> AccessKey:
    if not is_sound(access_keys, row):
        # use no value of a damaged row except the id: a time may be invalid, and the owner wrong
        return AccessKey(row.id, "damaged", (), None, None, None, "0" * 64, sound=False)
    return AccessKey(
        row.id,
        row.owner,
        cast("tuple[Scope, ...]", tuple(row.scopes.split(","))),
        utc(row.created),
        utc(row.expires),
        utc(row.revoked),
        row.hash,
    )
