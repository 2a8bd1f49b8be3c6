"""Diagnostics: their codes, how they are shown, and how their fixes are applied."""
