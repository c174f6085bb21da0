"""The one exception that is the user's to mend."""


class UserError(Exception):
    """A mistake in what the user handed in.

    The message is one sentence that names the file, the line or column where there is one, what was found and
    what is expected. Every other exception that leaves this package is a bug of the package.
    """
