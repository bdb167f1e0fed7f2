"""The tuned mass damper as the yardstick of the hybrid: transfer function, tunings, peaks."""
