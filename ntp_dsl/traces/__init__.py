"""Execution traces: one schema for scripted and learned programs, written as it happens (docs/traces.md)."""
