"""The catalogue of a store: database, tables, quotas, access keys, and location of the cubes."""
