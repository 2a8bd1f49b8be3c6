"""What is the case, as far as a robot can tell: states estimated from looks, and facts from states."""
