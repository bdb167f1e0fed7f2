"""Checksums of rows; the catalogue fills them in as the migration ends."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    """Add a column to each table, and an index of the rows that lack a checksum."""
    for table in ("studies", "done_blocks", "keys", "events"):
        op.add_column(table, sa.Column("crc", sa.BigInteger))
        lacking = sa.text("crc IS NULL")
        op.create_index(f"unsealed_{table}", table, ["crc"], sqlite_where=lacking, postgresql_where=lacking)
