"""Distributes the blocks of a study to workers, and reassigns the blocks of workers that leave or fail."""
