"""Images once they are rendered: displayed and written to files."""
