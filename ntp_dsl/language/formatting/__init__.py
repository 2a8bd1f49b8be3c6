"""The canonical layout, with comments kept, and the Pygments lexer."""
