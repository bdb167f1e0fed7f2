"""Which worker computes which block, and what becomes of the blocks of those that leave or fail."""
