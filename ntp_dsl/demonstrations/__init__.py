"""Demonstrations: what a learned program is shown."""
