"""Limits count a network of IPv6 that one host has whole as one address."""

import pytest

from damperlab.service.security.address import counted_address
from damperlab.service.security.caller import ANYBODY, Caller, counted_under


@pytest.mark.parametrize(
    ("address", "counted"),
    [
        ("192.0.2.7", "192.0.2.7"),
        ("::ffff:192.0.2.7", "192.0.2.7"),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"),
        ("2001:db8:1:2::9", "2001:db8:1:2::/64"),
        ("2001:db8:1:3::9", "2001:db8:1:3::/64"),
        ("fe80::1%eth0", "fe80::/64"),
        ("testclient", "testclient"),
        ("", ""),
    ],
)
def test_an_address_is_counted_by_its_network(address: str, counted: str) -> None:
    assert counted_address(address) == counted
    scope = {"caller": ANYBODY, "client_address": address}
    assert counted_under(scope) == (counted or ANYBODY.name)
    assert counted_under({**scope, "caller": Caller("", (), "key", "one")}) == "one"
