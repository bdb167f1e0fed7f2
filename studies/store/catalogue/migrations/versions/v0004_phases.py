"""What a running study is at: starting workers, or compiling the k-th of n kernels."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    """Add three columns; a study that runs meanwhile computes its blocks, as far as can be told."""
    op.add_column("studies", sa.Column("phase", sa.String))
    op.add_column("studies", sa.Column("phase_done", sa.Integer))
    op.add_column("studies", sa.Column("phase_total", sa.Integer))
