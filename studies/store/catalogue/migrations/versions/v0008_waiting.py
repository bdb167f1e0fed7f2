"""An index of the studies that wait or run: who looks for work reads those alone, in their order."""

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"


def upgrade() -> None:
    """Add the index."""
    waiting = sa.text("state IN ('queued', 'running') AND deleted IS NULL")
    op.create_index(
        "waiting", "studies", ["created", "number"], sqlite_where=waiting, postgresql_where=waiting
    )
