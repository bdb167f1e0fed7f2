"""Storage of studies in a data directory: a catalogue in an SQL database, and result cubes in Zarr's format."""
