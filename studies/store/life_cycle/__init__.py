"""What becomes of a study in a store: entered, looked up, claimed, its blocks marked, remarked on, deleted."""
