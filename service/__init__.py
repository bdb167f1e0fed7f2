"""User interfaces of damperlab: HTTP, the command line, the Python client, the web page, and figures."""
