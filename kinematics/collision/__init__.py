"""The collision checker."""
