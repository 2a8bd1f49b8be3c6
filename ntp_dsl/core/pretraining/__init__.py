"""How the one core comes to be: made-up scenes, and what is the case in them."""
