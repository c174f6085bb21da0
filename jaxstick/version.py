"""Which version of jaxstick wrote a result."""

from importlib.metadata import PackageNotFoundError, metadata


def version() -> str:
    """The installed distribution's version; "unknown" where the source runs without being installed."""
    try:
        return metadata("jaxstick")["Version"]
    except PackageNotFoundError:
        return "unknown"
