"""Policies: the protocol, the expert and its scripted policy."""
