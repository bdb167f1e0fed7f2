"""What runs in the process of a worker: how it joins, checks itself, computes blocks and leaves."""
