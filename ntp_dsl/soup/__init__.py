"""Random sound libraries as text, to train on and to test with: `random_library(seed)`."""

from ntp_dsl.soup.library import library_name, random_library

__all__ = ["library_name", "random_library"]
