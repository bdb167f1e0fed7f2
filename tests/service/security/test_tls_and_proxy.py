"""TLS by the service itself, and a reverse proxy whose word counts: over real sockets, from addresses that differ."""

import ipaddress
import json
import ssl
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import httpx
import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID
from tests.service.conftest import CURVE, TRUSTED, ended, serving, wait_for
from tests.service.security.conftest import Guarded, make_key

STUDIES = "/api/v1/studies"
SESSION = "/api/v1/session"
PROXY = "127.0.0.2"
"""Where the trusted proxy asks from; the whole of 127/8 is this machine."""


def _certify(folder: Path) -> tuple[Path, Path]:
    """Make a certificate for this machine's address that stands for itself, and its key."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "damperlab test")])
    now = datetime.now(UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(hours=1))
        .not_valid_after(now + timedelta(days=1))
        .add_extension(
            x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address("127.0.0.1"))]), False
        )
        .sign(key, hashes.SHA256())
    )
    chain, private = folder / "chain.pem", folder / "key.pem"
    chain.write_bytes(certificate.public_bytes(serialization.Encoding.PEM))
    private.write_bytes(
        key.private_bytes(
            serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
        )
    )
    return chain, private


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Guarded]:
    """A service behind a proxy that ends TLS."""
    folder = tmp_path_factory.mktemp("proxied")
    data = folder / "data"
    keys = {"reader": make_key(data, "reader", "read")}
    with serving(
        folder,
        DAMPERLAB_ACCESS="keys",
        DAMPERLAB_TRUSTED_PROXIES=PROXY,
        DAMPERLAB_PROXY_USER_HEADER="X-Forwarded-User",
        DAMPERLAB_HOSTS=".example.org",
    ) as running:
        yield Guarded(running, data, keys)


def _from(guarded: Guarded, address: str, user: str | None = None, **headers: str) -> httpx.Client:
    sent = {name.replace("_", "-"): value for name, value in headers.items()}
    if user is not None:
        sent["X-Forwarded-User"] = user
    transport = httpx.HTTPTransport(local_address=address, verify=TRUSTED)
    return httpx.Client(base_url=guarded.url, headers=sent, transport=transport, timeout=300)


def test_a_proxys_user_owns_what_he_submits(guarded: Guarded) -> None:
    with (
        _from(guarded, PROXY, "ann", Host="damper.example.org", X_Forwarded_For="6.6.6.6, 192.0.2.7") as ann,
        _from(guarded, PROXY, "bob") as bob,
    ):
        assert ann.get(SESSION).json() == {
            "needed": True, "signed_in": True, "owner": "ann", "scopes": ["read", "submit"],
        }  # fmt: skip
        made = ann.post(STUDIES, json=CURVE)
        assert made.status_code == 201
        url = f"{STUDIES}/{made.json()['id']}"
        wait_for(bob, made.json()["id"], ended)
        refused = bob.delete(url)
        assert (refused.status_code, refused.json()["type"]) == (403, "urn:damperlab:problem:not-yours")
        assert ann.delete(url).status_code == 204
    lines = [json.loads(line) for line in (guarded.data_dir / "audit.jsonl").read_text().splitlines()]
    told = [(each["who"], each["how"], each["method"], each["status"], each["address"]) for each in lines]
    # the last address is the one that the proxy saw; what its client wrote before it counts for nothing
    assert told == [
        ("ann", "proxy", "POST", 201, "192.0.2.7"),
        ("bob", "proxy", "DELETE", 403, PROXY),
        ("ann", "proxy", "DELETE", 204, "192.0.2.7"),
    ]


def test_the_header_counts_from_the_proxy_alone_and_only_once(guarded: Guarded) -> None:
    with _from(guarded, "127.0.0.1", "ann") as stranger:
        assert stranger.get(STUDIES).status_code == 401
    with _from(guarded, PROXY) as nobody:
        assert nobody.get(STUDIES).status_code == 401
        twice = [("X-Forwarded-User", "ann"), ("X-Forwarded-User", "operator")]
        assert nobody.get(STUDIES, headers=twice).status_code == 401
        assert nobody.get(STUDIES, headers={"X-Forwarded-User": "a" * 101}).status_code == 401
        # a name that the service does not have is refused from there too
        assert nobody.get("/health/live", headers={"Host": "example.net"}).status_code == 421
    # a key counts before the header
    with _from(guarded, PROXY, "ann") as ann:
        key = {"Authorization": f"Bearer {guarded.keys['reader']['key']}"}
        assert ann.get(SESSION, headers=key).json()["owner"] == "reader"
        assert ann.get(STUDIES, headers={"Authorization": "Bearer dlk_wrong"}).status_code == 401


@pytest.mark.parametrize(("address", "secure"), [(PROXY, True), ("127.0.0.1", False)])
def test_cookies_are_secure_where_a_believed_proxy_says_tls(
    guarded: Guarded, address: str, secure: bool
) -> None:
    with _from(guarded, address, X_Forwarded_Proto="https") as client:
        answer = client.post(SESSION, json={"key": guarded.keys["reader"]["key"]})
    assert answer.status_code == 200
    assert ("Secure" in answer.headers["set-cookie"]) is secure
    assert ("strict-transport-security" in answer.headers) is secure


def test_the_service_speaks_tls_itself(tmp_path: Path) -> None:
    chain, private = _certify(tmp_path)
    key = make_key(tmp_path / "data", "ann", "submit")["key"]
    files = {"DAMPERLAB_TLS_CERTIFICATE": str(chain), "DAMPERLAB_TLS_KEY": str(private)}
    with serving(tmp_path, DAMPERLAB_ACCESS="keys", **files) as running:
        assert running.url.startswith("https://127.0.0.1:")
        trusting = ssl.create_default_context(cafile=str(chain))
        with httpx.Client(base_url=running.url, verify=trusting, timeout=300) as client:
            answer = client.post(SESSION, json={"key": key})
            assert answer.status_code == 200
            assert "Secure" in answer.headers["set-cookie"]
            assert answer.headers["strict-transport-security"] == "max-age=31536000"
            # the session's cookie, by the browser's own rules
            assert client.get(STUDIES).status_code == 200
            origin = {"Origin": running.url, "Sec-Fetch-Site": "same-origin"}
            dry = client.post(f"{STUDIES}?dry_run=true", json=CURVE, headers=origin)
            assert dry.status_code == 200, dry.text
        with pytest.raises(httpx.ConnectError, match="CERTIFICATE_VERIFY_FAILED"):
            httpx.get(f"{running.url}/health/live")
        with pytest.raises(httpx.HTTPError):
            httpx.get(f"{running.url.replace('https', 'http')}/health/live", timeout=300)
