"""Generations, checksums and revisions of blocks; families of studies, keys of submissions, events."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    """Add columns and tables; what is there keeps its meaning: plain file names, no checksum known."""
    for column in (
        sa.Column("points_reused", sa.BigInteger, nullable=False, server_default="0"),
        sa.Column("revision", sa.Integer, nullable=False, server_default="0"),
        sa.Column("taken_back", sa.Integer, nullable=False, server_default="0"),
        sa.Column("family", sa.String(64), nullable=False, server_default=""),
        sa.Column("reuse", sa.Boolean, nullable=False, server_default=sa.true()),
    ):
        op.add_column("studies", column)
    op.create_index("family", "studies", ["family"])
    # marks that were set before revisions were counted
    op.execute("UPDATE studies SET revision = blocks_done")
    for column in (
        sa.Column("reused", sa.Integer, nullable=False, server_default="0"),
        sa.Column("generation", sa.String, nullable=False, server_default=""),
        sa.Column("checksum", sa.String),
        sa.Column("revision", sa.Integer, nullable=False, server_default="0"),
    ):
        op.add_column("done_blocks", column)
    op.create_table(
        "keys",
        sa.Column("key", sa.String, primary_key=True),
        sa.Column("digest", sa.String(64), nullable=False),
        sa.Column("at", sa.Float, nullable=False),
    )
    op.create_table(
        "events",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("study", sa.String(12), nullable=False),
        sa.Column("at", sa.Float, nullable=False),
        sa.Column("what", sa.Text, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_index("events_of_study", "events", ["study", "number"])
