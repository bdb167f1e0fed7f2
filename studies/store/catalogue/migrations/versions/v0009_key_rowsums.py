"""Checksums of access keys; the catalogue fills them in as the migration ends."""

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"


def upgrade() -> None:
    """Add the column, and an index of the rows that lack a checksum."""
    op.add_column("access_keys", sa.Column("crc", sa.BigInteger))
    lacking = sa.text("crc IS NULL")
    op.create_index(
        "unsealed_access_keys", "access_keys", ["crc"], sqlite_where=lacking, postgresql_where=lacking
    )
