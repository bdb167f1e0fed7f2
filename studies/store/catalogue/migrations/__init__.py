"""Changes of the catalogue's schema, in order; run as `damperlab.studies.store.catalogue.catalogue` opens an older one."""

HEAD = "0012"
"""The newest revision, which `damperlab.studies.store.catalogue.tables` describes."""
FIRST = "0012"
"""The oldest revision that is brought up to date: that of 0.2.0."""
