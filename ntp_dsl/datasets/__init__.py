"""Recording of demonstrations and labelled episodes, and reading them back."""
