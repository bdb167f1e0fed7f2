"""Computes for requests in processes that can be ended, in turns, and with a time limit."""
