"""Maintenance of a store: verification, removal of unused files, backup, and reconstruction of the catalogue."""
