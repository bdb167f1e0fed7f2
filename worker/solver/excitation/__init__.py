"""The excitation: a harmonic base, a harmonic force or a record, asked alike by the integrator."""
