"""Studies and the done-marks of their blocks."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Make the two tables."""
    op.create_table(
        "studies",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("id", sa.String(12), nullable=False),
        sa.Column("digest", sa.String(64), nullable=False),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("state", sa.String, nullable=False),
        sa.Column("message", sa.Text),
        sa.Column("definition", sa.Text, nullable=False),
        sa.Column("provenance", sa.Text, nullable=False),
        sa.Column("shape", sa.Text, nullable=False),
        sa.Column("chunk", sa.Text, nullable=False),
        # integers of 64 bit where the database has shorter ones; SQLite makes no difference
        sa.Column("points_total", sa.BigInteger, nullable=False),
        sa.Column("blocks_total", sa.Integer, nullable=False),
        sa.Column("points_done", sa.BigInteger, nullable=False),
        sa.Column("points_failed", sa.BigInteger, nullable=False),
        sa.Column("blocks_done", sa.Integer, nullable=False),
        sa.Column("seconds", sa.Float, nullable=False),
        sa.Column("kernel_seconds", sa.Float, nullable=False),
        sa.Column("created", sa.Float, nullable=False),
        sa.Column("started", sa.Float),
        sa.Column("finished", sa.Float),
        sa.Column("run_began", sa.Float),
        sa.Column("run_points", sa.BigInteger),
        sa.Column("last_mark", sa.Float),
        sa.Column("claim_owner", sa.String),
        sa.Column("claim_expires", sa.Float),
        sa.Column("deleted", sa.Float),
        sqlite_autoincrement=True,
    )
    alive = sa.text("deleted IS NULL")
    op.create_index("live_id", "studies", ["id"], unique=True, sqlite_where=alive, postgresql_where=alive)
    op.create_table(
        "done_blocks",
        sa.Column("study", sa.Integer, sa.ForeignKey("studies.number", ondelete="CASCADE"), primary_key=True),
        sa.Column("block", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("points", sa.Integer, nullable=False),
        sa.Column("failed", sa.Integer, nullable=False),
        sa.Column("seconds", sa.Float, nullable=False),
        sa.Column("kernel_seconds", sa.Float, nullable=False),
        sa.Column("message", sa.Text),
        sa.Column("at", sa.Float, nullable=False),
        sqlite_with_rowid=False,
    )
