"""The command line `damperlab`, a thin door to studies, worker and store: heavy imports wait until they are needed."""
