"""The hierarchy of a library as a picture: who calls whom, and what each promises."""
