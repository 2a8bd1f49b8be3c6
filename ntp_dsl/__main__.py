"""`python -m ntp_dsl` is `ntp`."""

from ntp_dsl.cli.app import main

main()
