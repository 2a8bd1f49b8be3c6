"""Episodes, success, and the statistics of both."""
