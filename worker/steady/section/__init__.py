"""Section points, which are states at the start of mirrored half cycles, and the recurrence of a run."""
