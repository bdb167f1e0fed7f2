"""Figures of the answers: resonance map, frequency response, ranked designs, time history.

Built from `matplotlib.figure.Figure` alone: no pyplot and no state of the process, so that threads of a service may
draw. What is drawn arrives as arrays with their long names and units in `attrs`, as the queries give them.
"""
