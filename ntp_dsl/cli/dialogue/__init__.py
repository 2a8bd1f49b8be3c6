"""What a person is asked on the command line, and what one says."""
