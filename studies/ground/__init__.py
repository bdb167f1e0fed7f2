"""Ground motion: records of base acceleration, their sources, reading and storage."""
