"""Traces in the formats of other viewers."""
