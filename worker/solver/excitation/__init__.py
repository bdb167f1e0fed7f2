"""The base excitation: harmonic, or a record, asked alike by the integrator."""
