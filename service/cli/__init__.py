"""The command line `damperlab`. Modules that take long to import are imported only when a command needs them."""
