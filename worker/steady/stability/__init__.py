"""The variational equations: what becomes of a small change of the state, in every contact model."""
