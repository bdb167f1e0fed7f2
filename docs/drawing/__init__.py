"""Figures of the documentation that the solver computes: `make docs-figures` writes them to `docs/figures`."""
