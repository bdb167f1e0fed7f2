"""Cubes of studies: description, files of the blocks, encoding, and reading."""
