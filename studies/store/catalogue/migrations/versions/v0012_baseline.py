"""The catalogue of 0.2.0, from which every later one is made."""

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = None


def upgrade() -> None:
    """Make the tables; what their columns hold stands in `damperlab.studies.store.catalogue.tables`."""
    alive = sa.text("deleted IS NULL")
    op.create_table(
        "studies",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("id", sa.String(24), nullable=False),
        sa.Column("digest", sa.String(64), nullable=False),
        sa.Column("version", sa.Integer, nullable=False),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("state", sa.String, nullable=False),
        sa.Column("message", sa.Text),
        sa.Column("definition", sa.Text, nullable=False),
        sa.Column("provenance", sa.Text, nullable=False),
        sa.Column("submitted_by", sa.Text),
        sa.Column("purpose", sa.String),
        sa.Column("purpose_of", sa.String),
        sa.Column("shape", sa.Text, nullable=False),
        sa.Column("chunk", sa.Text, nullable=False),
        # integers of 64 bit where the database has shorter ones; SQLite makes no difference
        sa.Column("points_total", sa.BigInteger, nullable=False),
        sa.Column("blocks_total", sa.Integer, nullable=False),
        sa.Column("bytes_total", sa.BigInteger, nullable=False),
        sa.Column("points_done", sa.BigInteger, nullable=False),
        sa.Column("points_failed", sa.BigInteger, nullable=False),
        sa.Column("points_reused", sa.BigInteger, nullable=False),
        sa.Column("blocks_done", sa.Integer, nullable=False),
        sa.Column("seconds", sa.Float, nullable=False),
        sa.Column("kernel_seconds", sa.Float, nullable=False),
        sa.Column("revision", sa.Integer, nullable=False),
        sa.Column("taken_back", sa.Integer, nullable=False),
        sa.Column("family", sa.String(64), nullable=False),
        sa.Column("box", sa.Text, nullable=False),
        sa.Column("reuse", sa.Boolean, nullable=False),
        sa.Column("priority", sa.Integer, nullable=False),
        sa.Column("tags", sa.Text, nullable=False),
        sa.Column("note", sa.Text, nullable=False),
        sa.Column("created", sa.Float, nullable=False),
        sa.Column("started", sa.Float),
        sa.Column("finished", sa.Float),
        sa.Column("run_began", sa.Float),
        sa.Column("run_points", sa.BigInteger),
        sa.Column("last_mark", sa.Float),
        sa.Column("phase", sa.String),
        sa.Column("phase_done", sa.Integer),
        sa.Column("phase_total", sa.Integer),
        sa.Column("claim_owner", sa.String),
        sa.Column("claim_expires", sa.Float),
        sa.Column("deleted", sa.Float),
        sa.Column("crc", sa.BigInteger),
        sqlite_autoincrement=True,
    )
    op.create_index("live_id", "studies", ["id"], unique=True, sqlite_where=alive, postgresql_where=alive)
    op.create_index("family", "studies", ["family"])
    op.create_index("digest", "studies", ["digest"])
    waiting = sa.text("state IN ('queued', 'running') AND deleted IS NULL")
    order = (sa.text("priority DESC"), sa.text("created"), sa.text("number"))
    op.create_index("waiting", "studies", order, sqlite_where=waiting, postgresql_where=waiting)
    op.create_table(
        "done_blocks",
        sa.Column("study", sa.Integer, sa.ForeignKey("studies.number", ondelete="CASCADE"), primary_key=True),
        sa.Column("block", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("points", sa.Integer, nullable=False),
        sa.Column("failed", sa.Integer, nullable=False),
        sa.Column("reused", sa.Integer, nullable=False),
        sa.Column("seconds", sa.Float, nullable=False),
        sa.Column("kernel_seconds", sa.Float, nullable=False),
        sa.Column("message", sa.Text),
        sa.Column("at", sa.Float, nullable=False),
        sa.Column("generation", sa.String, nullable=False),
        sa.Column("checksum", sa.String),
        sa.Column("revision", sa.Integer, nullable=False),
        sa.Column("identity", sa.String, nullable=False),
        sa.Column("crc", sa.BigInteger),
        sqlite_with_rowid=False,
    )
    op.create_table(
        "keys",
        sa.Column("key", sa.String, primary_key=True),
        sa.Column("digest", sa.String(64), nullable=False),
        sa.Column("at", sa.Float, nullable=False),
        sa.Column("crc", sa.BigInteger),
    )
    op.create_table(
        "events",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("study", sa.String(24), nullable=False),
        sa.Column("at", sa.Float, nullable=False),
        sa.Column("what", sa.Text, nullable=False),
        sa.Column("crc", sa.BigInteger),
        sqlite_autoincrement=True,
    )
    op.create_index("events_of_study", "events", ["study", "number"])
    op.create_table(
        "facts",
        sa.Column("key", sa.String, primary_key=True),
        sa.Column("value", sa.Text, nullable=False),
    )
    op.create_table(
        "access_keys",
        sa.Column("id", sa.String(16), primary_key=True),
        sa.Column("hash", sa.String(64), nullable=False),
        sa.Column("owner", sa.Text, nullable=False),
        sa.Column("scopes", sa.Text, nullable=False),
        sa.Column("created", sa.Float, nullable=False),
        sa.Column("expires", sa.Float),
        sa.Column("revoked", sa.Float),
        sa.Column("crc", sa.BigInteger),
    )
    lacking = sa.text("crc IS NULL")
    for table in ("studies", "done_blocks", "keys", "events", "access_keys"):
        op.create_index(f"unsealed_{table}", table, ["crc"], sqlite_where=lacking, postgresql_where=lacking)
