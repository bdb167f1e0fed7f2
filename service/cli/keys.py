"""Commands for keys, which give access to a service that other machines can reach."""

import getpass
import os
from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.keep import lasting
from damperlab.service.cli.options import AsJson, DataDir
from damperlab.service.cli.output import note, print_json, print_table, say
from damperlab.service.cli.store import open_store
from damperlab.studies.vocabulary import Scope

if TYPE_CHECKING:
    from damperlab.studies.store.catalogue.access_keys import AccessKey

keys = typer.Typer(help="Keys that give access to a service.", no_args_is_help=True, name="keys")


@keys.command("create")
def create(
    owner: Annotated[
        str | None,
        typer.Option(help="Owner of the studies that are submitted with the key; your user name by default."),
    ] = None,
    scope: Annotated[
        Scope,
        typer.Option(
            help="What the key allows. read: to ask questions; submit: also to submit studies and change "
            "those of its owner; admin: to change everyone's."
        ),
    ] = "submit",
    expires: Annotated[
        str | None, typer.Option(help="Time until the key expires, as in 90d or 12h; never by default.")
    ] = None,
    data_dir: DataDir = None,
    as_json: AsJson = False,
) -> None:
    """Create a key and print it once; only its hash is stored."""
    from damperlab.studies.store.catalogue.access_keys import AccessKeys

    lasts = None if expires is None else lasting(expires, "--expires")
    os.umask(0o077)  # other users must not read a data folder that this command creates
    store = open_store(data_dir)
    try:
        key, secret = AccessKeys(store.catalogue).create(owner or getpass.getuser(), (scope,), lasts)
    finally:
        store.close()
    if as_json:
        print_json({**key.document(), "key": secret})
        return
    note(
        f"Key {key.id} of {key.owner}, scope {scope}. It is shown only this once; keep it in a file of mode 0600:"
    )
    say(secret)


@keys.command("list")
def list_(data_dir: DataDir = None, as_json: AsJson = False) -> None:
    """List the keys, without their secrets."""
    from damperlab.studies.store.catalogue.access_keys import AccessKeys

    store = open_store(data_dir)
    try:
        found = AccessKeys(store.catalogue).all()
    finally:
        store.close()
    if as_json:
        print_json({"keys": [key.document() for key in found]})
        return
    rows = [
        (
            key.id,
            key.owner,
            key.scopes[-1] if key.scopes else "—",
            "—" if key.created is None else f"{key.created:%Y-%m-%d %H:%M}",
            "never" if key.expires is None else f"{key.expires:%Y-%m-%d %H:%M}",
            _state(key),
        )
        for key in found
    ]
    print_table(("id", "owner", "scope", "created (UTC)", "expires (UTC)", "state"), rows)


@keys.command("revoke")
def revoke(
    key_id: Annotated[
        str, typer.Argument(metavar="ID", help="Id of the key, as `damperlab admin keys list` shows it.")
    ],
    data_dir: DataDir = None,
    as_json: AsJson = False,
) -> None:
    """Revoke a key; a running service refuses it within seconds."""
    from damperlab.studies.store.catalogue.access_keys import AccessKeys

    store = open_store(data_dir)
    try:
        key = AccessKeys(store.catalogue).revoke(key_id)
    finally:
        store.close()
    if as_json:
        print_json(key.document())
    else:
        note(f"Key {key.id} of {key.owner} is revoked and no longer gives access.")


def _state(key: "AccessKey") -> str:
    if not key.sound:
        return "damaged"
    return "valid" if key.valid else "revoked" if key.revoked else "expired"
