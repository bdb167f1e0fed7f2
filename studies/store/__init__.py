"""Storage of studies: the catalogue in SQL, the cubes in Zarr, under one data directory."""
