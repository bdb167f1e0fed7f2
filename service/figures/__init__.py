"""Figures of the answers: resonance map, frequency response, ranked designs, time history.

They use only `matplotlib.figure.Figure`, without pyplot and its global state, so that threads of a service may
draw. Data arrive as arrays with their long names and units in `attrs`, as the queries return them.
"""
