"""Ground motion: records of base acceleration, where they come from, and how they are read and kept."""
