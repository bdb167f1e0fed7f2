"""The command line `damperlab`, a thin interface to studies, worker and store: heavy imports wait until they are
needed.
"""
