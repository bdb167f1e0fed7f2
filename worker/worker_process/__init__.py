"""The process of a worker, which joins a cluster, checks its own results, computes blocks and leaves."""
