"""Clusters to compute on: processes of our own, jobs of a batch system, or a scheduler that is there already."""
