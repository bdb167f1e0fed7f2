"""Where the cubes are, and how much a study takes before compression."""

import json

import numpy as np
import sqlalchemy as sa
from alembic import op

from damperlab.studies.variables import VARIABLES

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Add a table and a column; the studies that are there are counted by their definitions."""
    op.create_table(
        "facts",
        sa.Column("key", sa.String, primary_key=True),
        sa.Column("value", sa.Text, nullable=False),
    )
    op.add_column("studies", sa.Column("bytes_total", sa.BigInteger, nullable=False, server_default="0"))
    connection = op.get_bind()
    rows = connection.execute(
        sa.text("SELECT number, points_total, definition FROM studies WHERE definition <> ''")
    ).all()
    for number, points, definition in rows:
        names = {*json.loads(definition).get("metrics", ()), "status"}
        size = sum(np.dtype(v.dtype).itemsize for v in VARIABLES.values() if v.name in names)
        connection.execute(
            sa.text("UPDATE studies SET bytes_total = :size WHERE number = :number"),
            {"size": points * size, "number": number},
        )
