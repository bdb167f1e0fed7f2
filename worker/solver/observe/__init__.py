"""Observables: peaks, energies and times accumulated along the motion."""
