"""One or two traces as a page for a browser."""
