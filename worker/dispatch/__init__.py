"""Assignment of blocks to workers, also after a worker leaves or fails."""
