"""Submission, lookup, claims, done-marks, remarks and deletion of studies."""
