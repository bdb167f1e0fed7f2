"""The excitation: a harmonic base, a harmonic force or a record, with one interface for the integrator."""
