"""Points on the section, at the start of every (mirrored) half cycle, and their recurrence."""
