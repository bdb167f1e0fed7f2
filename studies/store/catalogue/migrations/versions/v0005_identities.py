"""Versions of studies; which solver computed each block; the box that a study's grid fills."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"


def upgrade() -> None:
    """Add columns. What computed the blocks that are there was not recorded, so no study takes points of theirs."""
    op.add_column("done_blocks", sa.Column("identity", sa.String, nullable=False, server_default=""))
    op.add_column("studies", sa.Column("box", sa.Text, nullable=False, server_default="[]"))
    op.execute("UPDATE studies SET family = ''")
    op.add_column("studies", sa.Column("version", sa.Integer, nullable=False, server_default="1"))
    op.create_index("digest", "studies", ["digest"])
    # SQLite minds no length, and could not change it without copying the table
    if op.get_bind().dialect.name == "postgresql":
        op.alter_column("studies", "id", type_=sa.String(24))
        op.alter_column("events", "study", type_=sa.String(24))
