"""`python -m ntp_dsl` is `ntp`."""

from ntp_dsl.cli import main

main()
