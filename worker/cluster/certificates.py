"""Makes and checks the TLS certificates of a cluster, which has a private certificate authority."""

import os
import ssl
from datetime import UTC, datetime, timedelta
from pathlib import Path

from distributed import Security
from distributed.comm import CommClosedError

from damperlab.worker.outcomes import ClusterUnusable

CA, CERTIFICATE, KEY = "ca.pem", "cert.pem", "key.pem"
"""Files in a certificate folder: the authority's certificate, and the members' shared certificate and key."""
VARIABLE = "DAMPERLAB_CLUSTER_TLS"
"""Environment variable with the path of the folder of certificates."""
ROLES = ("client", "scheduler", "worker")
DAYS = 3650


def security(folder: Path | None = None, address: str = "") -> Security:
    """Return the TLS settings of a client, worker or scheduler.

    Parameters
    ----------
    folder : Path, optional
        Folder with certificates, made by `make_certificates`. By default, the environment variable
        DAMPERLAB_CLUSTER_TLS names the folder. If the variable is not set, Dask's own settings are used.
    address : str
        Address of the scheduler. If the address begins with tls:, certificates are required.

    Raises
    ------
    ClusterUnusable
        If a file is missing or is no valid certificate, or the address begins with tls: and no certificate is found.
    """
    if folder is None:
        named = os.environ.get(VARIABLE)
        if not named:
            shown = Security()
            encrypts = any(shown.get_connection_args(role).get("ssl_context") for role in ROLES)
            if address.startswith("tls:") and not encrypts:
                raise ClusterUnusable(
                    "tls",
                    f"no certificates for {address!r}",
                    "certificates that the scheduler accepts",
                    f"name their folder in {VARIABLE}, or with --tls if the command has this option",
                    f"There are no certificates to show to {address}.",
                )
            return shown
        folder = Path(named)
    files = [folder / name for name in (CA, CERTIFICATE, KEY)]
    for file in files:
        if not os.access(file, os.R_OK):
            raise ClusterUnusable(
                "tls",
                f"{str(folder)!r} without a readable {file.name}",
                f"a folder with {CA}, {CERTIFICATE} and {KEY}",
                "make one with `damperlab admin certificates DIR` and copy it to every machine of the cluster",
                f"The folder {folder} holds no {file.name} that can be read; it must hold {CA}, {CERTIFICATE} and {KEY}.",
            )
    for file in files[:2]:
        _require_valid(file)
    ca, certificate, key = map(str, files)
    files_of = {f"tls_{role}_cert": certificate for role in ROLES} | {
        f"tls_{role}_key": key for role in ROLES
    }
    return Security(require_encryption=True, tls_ca_file=ca, **files_of)


def _require_valid(file: Path) -> None:
    """Raise `ClusterUnusable` if a file contains no certificate, or a certificate that is not valid now."""
    from cryptography import x509

    now = datetime.now(UTC)
    advice = (
        "make others with `damperlab admin certificates DIR` and copy them to every machine of the cluster"
    )
    try:
        found = x509.load_pem_x509_certificates(file.read_bytes())
    except ValueError as error:
        raise ClusterUnusable(
            "tls",
            f"{str(file)!r}, which is not a certificate ({error})",
            "a certificate in PEM",
            advice,
            f"The file {file} holds no certificate.",
        ) from error
    for one in found:
        begins, ends = one.not_valid_before_utc, one.not_valid_after_utc
        if not begins <= now <= ends:
            ended = (
                f"ended on {ends:%Y-%m-%d at %H:%M}"
                if now > ends
                else f"begins on {begins:%Y-%m-%d at %H:%M}"
            )
            here = f"it is {now:%Y-%m-%d %H:%M} by the clock of this machine"
            raise ClusterUnusable(
                "tls",
                f"{str(file)!r}, whose certificate {ended} UTC",
                "certificates that are valid now",
                advice,
                f"The certificate {file} {ended} UTC; {here}.",
            )


def refusal(error: BaseException) -> str:
    """Return the reason why a server refused a connection; empty if the server did not answer.

    The reason is a clause without capital letter and full stop.
    """
    closed = False
    seen: BaseException | None = error
    while seen is not None:
        if isinstance(seen, ssl.SSLCertVerificationError):
            return f"its certificate is not trusted here ({seen.verify_message})"
        if isinstance(seen, ssl.SSLError):
            return (
                f"the two sides do not agree on TLS ({(seen.reason or str(seen)).lower().replace('_', ' ')})"
            )
        closed = closed or isinstance(seen, CommClosedError)
        seen = seen.__cause__ or seen.__context__
    return f"it closes the connection; perhaps it requires certificates ({VARIABLE})" if closed else ""


def make_certificates(folder: Path, days: int = DAYS) -> None:
    """Make a certificate authority for one cluster, and the certificate that all members of the cluster use.

    The authority's key is not stored, so the certificate can be replaced only together with the authority.

    Parameters
    ----------
    folder : Path
        Folder for the files, created if it is missing.
    days : int
        Number of days for which the certificates are valid.

    Raises
    ------
    FileExistsError
        If the folder already contains one of the files.
    """
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.x509.oid import NameOID

    def name(text: str) -> x509.Name:
        return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, text)])

    now = datetime.now(UTC)
    authority, member = (ec.generate_private_key(ec.SECP256R1()) for _ in range(2))
    signed = {}
    for file, subject, key, is_authority in (
        (CA, "damperlab cluster authority", authority, True),
        (CERTIFICATE, "damperlab cluster member", member, False),
    ):
        builder = (
            x509.CertificateBuilder()
            .subject_name(name(subject))
            .issuer_name(name("damperlab cluster authority"))
            .public_key(key.public_key())
            .serial_number(x509.random_serial_number())
            # a machine's clock may be slow
            .not_valid_before(now - timedelta(days=1))
            .not_valid_after(now + timedelta(days=days))
            .add_extension(
                x509.BasicConstraints(ca=is_authority, path_length=0 if is_authority else None), critical=True
            )
            .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
            .add_extension(
                x509.AuthorityKeyIdentifier.from_issuer_public_key(authority.public_key()), critical=False
            )
        )
        signed[file] = builder.sign(authority, hashes.SHA256()).public_bytes(serialization.Encoding.PEM)
    secret = member.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
    folder.mkdir(parents=True, exist_ok=True)
    for file, content in (*signed.items(), (KEY, secret)):
        handle = os.open(folder / file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600 if file == KEY else 0o644)
        with os.fdopen(handle, "wb") as out:
            out.write(content)
