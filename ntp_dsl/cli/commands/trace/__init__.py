"""The commands of `ntp trace`."""
