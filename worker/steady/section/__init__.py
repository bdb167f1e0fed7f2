"""Points on the section, which a run passes at the start of every (mirrored) half cycle, and how nearly they repeat."""
