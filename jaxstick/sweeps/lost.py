"""The exception of a sweep whose cluster failed on the way."""


class ClusterLostError(Exception):
    """The cluster failed while it computed; the message is a clause that says how.

    Neither the user's mistake nor a bug: what was finished is kept, and the same command goes on from there.
    """
