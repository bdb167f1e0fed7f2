"""The tables of the catalogue. If a table is changed, `REVISION` in `.catalogue` must be increased."""

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    Connection,
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
    # serial number of the study; it is never used again, so that no study gets the files of a deleted study
    Column("number", Integer, primary_key=True),
    # the first digits of the digest, followed by the version if the version is above 1
    Column("id", String(24), nullable=False),
    Column("digest", String(64), nullable=False),
    # 1 for the submitted study; each computation by a later solver is a new version
    Column("version", Integer, nullable=False, default=1),
    Column("name", Text, nullable=False),
    Column("state", String, nullable=False),
    Column("message", Text),
    Column("definition", Text, nullable=False),
    Column("provenance", Text, nullable=False),
    # copied from the provenance: the submitter, and the design or the refinement for which the study was submitted
    Column("submitted_by", Text),
    Column("purpose", String),
    Column("purpose_of", String),
    Column("shape", Text, nullable=False),
    Column("chunk", Text, nullable=False),
    Column("points_total", BigInteger, nullable=False),
    Column("blocks_total", Integer, nullable=False),
    # number of bytes of the complete study before compression, for the quota
    Column("bytes_total", BigInteger, nullable=False, default=0),
    # sums over the study's rows in done_blocks
    Column("points_done", BigInteger, nullable=False, default=0),
    Column("points_failed", BigInteger, nullable=False, default=0),
    Column("points_reused", BigInteger, nullable=False, default=0),
    Column("blocks_done", Integer, nullable=False, default=0),
    Column("seconds", Float, nullable=False, default=0.0),
    Column("kernel_seconds", Float, nullable=False, default=0.0),
    # number that increases with every change of the study's rows in done_blocks
    Column("revision", Integer, nullable=False, default=0),
    # revision at which blocks were last invalidated; earlier revisions are no longer available
    Column("taken_back", Integer, nullable=False, default=0),
    # digest of the family, whose studies differ only in their grids; an empty text if points cannot be reused
    Column("family", String(64), nullable=False, default=""),
    # lowest and highest value along every numeric dimension, to find studies that may share points
    Column("box", Text, nullable=False, default="[]"),
    Column("reuse", Boolean, nullable=False, default=True),
    # the waiting study with the highest priority starts first
    Column("priority", Integer, nullable=False, default=0),
    # the user's remarks: tags as a JSON list of distinct texts, and a note
    Column("tags", Text, nullable=False, default="[]"),
    Column("note", Text, nullable=False, default=""),
    Column("created", Float, nullable=False),
    Column("started", Float),
    Column("finished", Float),
    # time of the latest start of the study, and points done at that time, to measure the speed
    Column("run_began", Float),
    Column("run_points", BigInteger),
    Column("last_mark", Float),
    # phase of a running study that does not compute blocks yet; null for all other studies
    Column("phase", String),
    Column("phase_done", Integer),
    Column("phase_total", Integer),
    Column("claim_owner", String),
    Column("claim_expires", Float),
    Column("deleted", Float),
    # checksum of the row's other columns; null while a transaction writes the row
    Column("crc", BigInteger),
    sqlite_autoincrement=True,
)
Index(
    "live_id",
    studies.c.id,
    unique=True,
    sqlite_where=studies.c.deleted.is_(None),
)
WAITING = and_(text("state IN ('queued', 'running')"), studies.c.deleted.is_(None))
"""Condition for studies that have not ended, which is also the condition of the index `waiting`."""
Index(
    "waiting",
    studies.c.priority.desc(),
    studies.c.created,
    studies.c.number,
    sqlite_where=WAITING,
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
    # generation in the name of the block's valid file, and checksum of the block's values
    Column("generation", String, nullable=False, default=""),
    Column("checksum", String),
    Column("revision", Integer, nullable=False, default=0),
    # identity of the solver and the processor that computed the block
    Column("identity", String, nullable=False, default=""),
    Column("crc", BigInteger),
    # rows are stored in the order of the primary key, because the marks of a study are read together
    sqlite_with_rowid=False,
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
    # data about the catalogue itself, for example its revision, its id, and the location of its cubes
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

SUMMED = (studies, done_blocks, events, access_keys)
"""The tables whose rows have a checksum."""

for _table in SUMMED:
    Index(f"unsealed_{_table.name}", _table.c.crc, sqlite_where=_table.c.crc.is_(None))


def create_tables(connection: Connection) -> None:
    """Create the tables and indexes in an empty database.

    The conditions of the partial indexes are set here for PostgreSQL. If the definitions of the indexes
    contained these conditions, a process that needs only SQLite would import SQLAlchemy's dialect of
    PostgreSQL.
    """
    if connection.dialect.name == "postgresql":
        for index in (index for table in metadata.sorted_tables for index in table.indexes):
            index.dialect_options["postgresql"]["where"] = index.dialect_options["sqlite"]["where"]
    metadata.create_all(connection, checkfirst=False)
