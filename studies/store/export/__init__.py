"""A cube handed to others: as one file, over a network, to Zarr itself."""
