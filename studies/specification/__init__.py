"""The specification of a design: what must be quiet, what may be chosen, how far what is built may be off."""
