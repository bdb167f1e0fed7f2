"""The tuned mass damper as the reference for the hybrid: transfer function, tunings, peaks."""
