"""The command line `damperlab`: a thin door to studies, worker and store. Heavy imports wait until a command needs them."""
