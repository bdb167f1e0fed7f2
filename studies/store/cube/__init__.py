"""The cube of one study: its description, its blocks, their bytes, and reading."""
