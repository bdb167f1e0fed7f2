"""Access to a cube for other programs: as a single file, or over a network."""
