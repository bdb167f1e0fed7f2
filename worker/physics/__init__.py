"""One law per file: the structure, friction, impact. No solver, no arrays with labels."""
