"""Parameter studies of a hybrid vibration damper: particle impact and Coulomb friction."""
