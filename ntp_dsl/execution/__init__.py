"""The interpreter, and the replay of traces."""
