"""A report of many episodes, from their traces."""
