"""Files, package data, seeds and worker processes."""
