"""`python -m rwjax`: the command line."""

from rwjax.cli import main

main()
