"""The tuned mass damper, the reference for the hybrid damper: transfer function, tunings and peaks."""
