"""From text to syntax tree, in spite of mistakes in it."""
