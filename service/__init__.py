"""The interfaces: HTTP, the command line, the Python client, the web page, and figures."""
