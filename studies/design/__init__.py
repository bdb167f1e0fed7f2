"""Design of a damper for a specification: the search over studies, and the answer."""
