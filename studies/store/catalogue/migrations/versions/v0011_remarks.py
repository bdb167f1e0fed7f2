"""What people say of a study: tags to find it by, and a note."""

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0010"


def upgrade() -> None:
    """Add the columns; nothing is said of the studies that are there."""
    op.add_column("studies", sa.Column("tags", sa.Text, nullable=False, server_default="[]"))
    op.add_column("studies", sa.Column("note", sa.Text, nullable=False, server_default=""))
