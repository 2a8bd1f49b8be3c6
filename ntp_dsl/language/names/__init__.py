"""Symbol table, visibility, references and signatures."""
