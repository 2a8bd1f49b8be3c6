"""Sentences: what is to be done, in English, as evidence for the lists that a program is called with."""
