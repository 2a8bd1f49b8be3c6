"""A run as it happens: printed, on a page, in a viewer, and stepped."""
