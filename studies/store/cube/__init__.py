"""The cube of one study: its description, its blocks, their bytes, and how it is read."""
