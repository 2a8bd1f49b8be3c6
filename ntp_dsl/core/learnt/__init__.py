"""What is learnt of one program from traces, all else being as it is: its calls, and which it prefers."""
