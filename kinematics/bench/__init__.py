"""How fast and how sure the arm is, beside the peers that are installed: same queries, same run."""
