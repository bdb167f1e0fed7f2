"""The web page: plain ES modules, one style sheet, no build step; `files` says what of them is served, and how."""
