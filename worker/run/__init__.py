"""Runs of single studies: a run claims a study, computes its blocks and sets its final state."""
