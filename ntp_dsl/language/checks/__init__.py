"""The static checks, one file a family."""
