"""The excitation: a harmonic base motion, a harmonic force or a ground-motion record."""
