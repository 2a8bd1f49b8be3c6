"""Export of traces to other viewers."""
