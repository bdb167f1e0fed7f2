"""The tables of the catalogue. A change needs another revision in `.catalogue`."""

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    Float,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    and_,
    text,
)

metadata = MetaData()

studies = Table(
    "studies",
    metadata,
    # never reused: it orders the pages and names the cube's folder, so no study gets a deleted one's files
    Column("number", Integer, primary_key=True),
    # the digest's first digits, and the version if there are several
    Column("id", String(24), nullable=False),
    Column("digest", String(64), nullable=False),
    # 1 for a study as submitted; each computation by a later solver gets the next number
    Column("version", Integer, nullable=False, default=1),
    Column("name", Text, nullable=False),
    Column("state", String, nullable=False),
    Column("message", Text),
    Column("definition", Text, nullable=False),
    Column("provenance", Text, nullable=False),
    # from the provenance: the submitter; if a program submitted it, its purpose and the study or specification
    Column("submitted_by", Text),
    Column("purpose", String),
    Column("purpose_of", String),
    Column("shape", Text, nullable=False),
    Column("chunk", Text, nullable=False),
    Column("points_total", BigInteger, nullable=False),
    Column("blocks_total", Integer, nullable=False),
    # size of the complete study before compression, as counted by a quota
    Column("bytes_total", BigInteger, nullable=False, default=0),
    # running sums over done_blocks: a record needs only one row, for any number of blocks
    Column("points_done", BigInteger, nullable=False, default=0),
    Column("points_failed", BigInteger, nullable=False, default=0),
    Column("points_reused", BigInteger, nullable=False, default=0),
    Column("blocks_done", Integer, nullable=False, default=0),
    Column("seconds", Float, nullable=False, default=0.0),
    Column("kernel_seconds", Float, nullable=False, default=0.0),
    # counts the changes of done_blocks, so a reading at one revision is valid until the next
    Column("revision", Integer, nullable=False, default=0),
    # when blocks were last invalidated: earlier revisions cannot be shown any more
    Column("taken_back", Integer, nullable=False, default=0),
    # studies of one family differ only in their grids; empty if points may be neither reused nor shared
    Column("family", String(64), nullable=False, default=""),
    # lowest and highest value along every numeric dimension, to find studies that may share points
    Column("box", Text, nullable=False, default="[]"),
    Column("reuse", Boolean, nullable=False, default=True),
    # of waiting studies the one with the highest priority starts first
    Column("priority", Integer, nullable=False, default=0),
    # the user's remarks: tags as a JSON list of different texts, and a note
    Column("tags", Text, nullable=False, default="[]"),
    Column("note", Text, nullable=False, default=""),
    Column("created", Float, nullable=False),
    Column("started", Float),
    Column("finished", Float),
    # the pace is measured from the latest start of the study
    Column("run_began", Float),
    Column("run_points", BigInteger),
    Column("last_mark", Float),
    # activity of a running study before its blocks: null while it computes them, and in every other state
    Column("phase", String),
    Column("phase_done", Integer),
    Column("phase_total", Integer),
    Column("claim_owner", String),
    Column("claim_expires", Float),
    Column("deleted", Float),
    # checksum of the row's other columns; none while a transaction writes the row
    Column("crc", BigInteger),
    sqlite_autoincrement=True,
)
Index(
    "live_id",
    studies.c.id,
    unique=True,
    sqlite_where=studies.c.deleted.is_(None),
    postgresql_where=studies.c.deleted.is_(None),
)
WAITING = and_(text("state IN ('queued', 'running')"), studies.c.deleted.is_(None))
"""The studies that have not ended. The index below has the same condition, so that the database uses it."""
Index(
    "waiting",
    studies.c.priority.desc(),
    studies.c.created,
    studies.c.number,
    sqlite_where=WAITING,
    postgresql_where=WAITING,
)
Index("family", studies.c.family)
Index("digest", studies.c.digest)

done_blocks = Table(
    "done_blocks",
    metadata,
    Column("study", ForeignKey("studies.number", ondelete="CASCADE"), primary_key=True),
    Column("block", Integer, primary_key=True, autoincrement=False),
    Column("points", Integer, nullable=False),
    Column("failed", Integer, nullable=False),
    Column("reused", Integer, nullable=False, default=0),
    Column("seconds", Float, nullable=False),
    Column("kernel_seconds", Float, nullable=False),
    Column("message", Text),
    Column("at", Float, nullable=False),
    # the generation names the block's valid file among those written; the checksum is that of the block's values
    Column("generation", String, nullable=False, default=""),
    Column("checksum", String),
    Column("revision", Integer, nullable=False, default=0),
    # solver and processor of the block
    Column("identity", String, nullable=False, default=""),
    Column("crc", BigInteger),
    # clustered by its key: the marks of one study are read together
    sqlite_with_rowid=False,
)

keys = Table(
    "keys",
    metadata,
    Column("key", String, primary_key=True),
    Column("digest", String(64), nullable=False),
    Column("at", Float, nullable=False),
    Column("crc", BigInteger),
)

events = Table(
    "events",
    metadata,
    Column("number", Integer, primary_key=True),
    Column("study", String(24), nullable=False),
    Column("at", Float, nullable=False),
    Column("what", Text, nullable=False),
    Column("crc", BigInteger),
    sqlite_autoincrement=True,
)
Index("events_of_study", events.c.study, events.c.number)

facts = Table(
    "facts",
    metadata,
    # facts about the catalogue itself: its revision, its id, and the location of its cubes
    Column("key", String, primary_key=True),
    Column("value", Text, nullable=False),
)

access_keys = Table(
    "access_keys",
    metadata,
    # the public part of the key, and the SHA-256 of the secret part
    Column("id", String(16), primary_key=True),
    Column("hash", String(64), nullable=False),
    Column("owner", Text, nullable=False),
    Column("scopes", Text, nullable=False),
    Column("created", Float, nullable=False),
    Column("expires", Float),
    Column("revoked", Float),
    Column("crc", BigInteger),
)

for _table in (studies, done_blocks, keys, events, access_keys):
    _lacking = _table.c.crc.is_(None)
    Index(f"unsealed_{_table.name}", _table.c.crc, sqlite_where=_lacking, postgresql_where=_lacking)
