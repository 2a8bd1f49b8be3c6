"""What a demonstration says: the lists of a program's arguments, and the frames of each call."""
