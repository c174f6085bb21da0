"""`python -m jaxstick`: the lower commands alone."""

from jaxstick.cli import main

if __name__ == "__main__":
    main()
