"""``python -m fpnav``."""

from fpnav.cli.main import main

main()
