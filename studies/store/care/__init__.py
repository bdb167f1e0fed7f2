"""A store kept whole: verified, swept, copied, made again."""
