"""A prototype identified: what was measured, what is known of it, what is to be estimated, and what came out."""
