"""Two traces side by side: alignment, divergences, confidence."""
