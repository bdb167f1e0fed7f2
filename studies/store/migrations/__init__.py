"""Changes of the catalogue's schema, in order; run by `damperlab.studies.store.catalogue` as it opens an older one."""

HEAD = "0011"
"""The newest revision, which `damperlab.studies.store.tables` describes."""
