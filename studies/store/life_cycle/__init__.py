"""Life of a study in a store: entered, found, claimed, marked, annotated, deleted."""
