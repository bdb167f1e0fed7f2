"""Changes of the catalogue's schema, in order; run as `damperlab.studies.store.catalogue.catalogue` opens an older one."""

HEAD = "0011"
"""The newest revision, which `damperlab.studies.store.catalogue.tables` describes."""
