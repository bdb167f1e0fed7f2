"""The web page: plain ES modules and one style sheet, without a build step. `files` prepares the files for sending."""
