"""Storage of a store's files in a folder, or in a bucket of an object store."""
