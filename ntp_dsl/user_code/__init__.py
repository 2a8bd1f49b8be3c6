"""A user's Python beside a library: loading it, and checking what it returns."""
