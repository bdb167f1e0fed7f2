"""Keys in a damaged catalogue: what is not as it was written opens nothing."""

import pytest
from tests.filling import write_behind

from damperlab.studies.store.care.rebuild import rebuild
from damperlab.studies.store.care.verify import check_catalogue
from damperlab.studies.store.catalogue.access_keys import AccessKeys


@pytest.mark.parametrize(
    "damage",
    [
        "owner = 'bob'",
        "scopes = 'read,submit,admin'",
        "expires = 1e300",
        "revoked = NULL",
        "hash = hash || '0'",
    ],
)
def test_a_key_whose_row_is_damaged_opens_nothing(store, damage):
    keys = AccessKeys(store.catalogue)
    good, secret = keys.create("alice", ("read",), lasts_seconds=3600.0)
    bad, damaged = keys.create("rob", ("read",), lasts_seconds=60.0)
    if damage.startswith("revoked"):
        bad = keys.revoke(bad.id)
    write_behind(store.data_dir, f"UPDATE access_keys SET {damage} WHERE id = '{bad.id}'")
    assert keys.recognise(damaged) is None
    assert keys.recognise(secret) == good
    assert {key.id: (key.sound, key.valid) for key in keys.all()} == {
        good.id: (True, True),
        bad.id: (False, False),
    }
    for key in keys.all():
        assert key.document()["valid"] == (key.id == good.id)
    (told,) = check_catalogue(store)
    assert bad.id in told
    rebuild(store.data_dir)
    assert keys.all() == [good]
    assert list(check_catalogue(store)) == []
