"""Description of a steady response: its measures, and their errors."""
