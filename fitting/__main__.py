"""`python -m fitting`: the whole command."""

from fitting.cli import main

if __name__ == "__main__":
    main()
