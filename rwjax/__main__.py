"""`python -m rwjax`: the command line."""

from rwjax.cli.main import main

main()
