"""Every question to a study's cube: one file each, and one list of them in `every`."""
