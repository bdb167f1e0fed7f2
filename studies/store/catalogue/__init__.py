"""The catalogue of a store: its tables, rows, owners, and quotas."""
