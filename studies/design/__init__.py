"""From a specification to a damper: a search over studies, and its answer."""
