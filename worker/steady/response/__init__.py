"""What is told of a steady response: its measures, and how well they are known."""
