"""Which of the studies that wait comes first, where somebody has said so."""

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"


def upgrade() -> None:
    """Add the column; what waits is read in its order."""
    op.add_column("studies", sa.Column("priority", sa.Integer, nullable=False, server_default="0"))
    op.drop_index("waiting", "studies")
    waiting = sa.text("state IN ('queued', 'running') AND deleted IS NULL")
    columns = (sa.text("priority DESC"), sa.text("created"), sa.text("number"))
    op.create_index("waiting", "studies", columns, sqlite_where=waiting, postgresql_where=waiting)
