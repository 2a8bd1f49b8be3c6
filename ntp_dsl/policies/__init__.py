"""What decides: the protocol, the expert and its scripted policy."""
