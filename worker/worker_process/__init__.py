"""The process of a worker: how it joins, checks itself, computes blocks and leaves."""
