"""The web page: plain ES modules, one style sheet, no build step; `files` defines which files are served, and how."""
