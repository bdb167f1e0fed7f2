"""The doors: HTTP, the command line and figures."""
