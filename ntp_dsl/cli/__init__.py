"""The command `ntp`. The module of a command is imported when the command is called."""
