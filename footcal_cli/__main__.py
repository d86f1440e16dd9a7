"""``python -m footcal_cli``."""

from footcal_cli.app import main

main()
