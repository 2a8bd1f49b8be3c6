"""What a library means at one moment: observations, predicates, states."""
