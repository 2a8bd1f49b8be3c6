"""Pictures of a library's hierarchy: who calls whom, and what each promises."""
