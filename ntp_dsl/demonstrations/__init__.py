"""What a learned program is shown."""
