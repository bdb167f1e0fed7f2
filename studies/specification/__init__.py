"""The specification of a design: requirements, ranges of the damper, and tolerances."""
