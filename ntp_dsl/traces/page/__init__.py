"""Traces as one page for a browser."""
