"""The physical laws, one per file: structure, friction, impact and compliant wall."""
