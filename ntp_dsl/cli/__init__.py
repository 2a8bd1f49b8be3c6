"""The command `ntp`. A module of `commands` is imported when its command is called."""
