"""Images once they are rendered: displayed, written to files, averaged."""
