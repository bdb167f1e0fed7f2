"""Figures of the answers, drawn without pyplot, whose state is global and would be shared by threads."""
