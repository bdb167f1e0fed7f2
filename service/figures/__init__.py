"""Figures of the answers, drawn without pyplot, because threads would share its global state."""
