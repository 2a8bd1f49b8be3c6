"""Motion planning and time parameterisation."""
