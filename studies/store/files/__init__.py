"""Location of a store's bytes: a folder, or a bucket of an object store."""
