"""The variational equations: the propagation of a small change of the state, in every contact model."""
