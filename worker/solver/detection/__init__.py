"""What proves that a span is free of events, and the first event where one is not."""
