"""Contact with a compliant wall: a Kelvin–Voigt element that pushes but never pulls."""
