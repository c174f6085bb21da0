"""What a worker of a cluster is asked to do; light to import, since its scheduler reads it too."""

import pickle
from collections.abc import Sequence
from typing import Any

from jaxstick.deferred import deferred
from jaxstick.errors import UserError
from jaxstick.version import version

compute = deferred("jaxstick.sweep", "compute")


def compute_pickled(points: bytes, derivatives: Sequence[str], wanted: str) -> Any:
    """The columns of the pickled lanes, `jaxstick.sweep.compute` of them.

    Raises UserError where this process runs another version of jaxstick than `wanted`.
    """
    if version() != wanted:
        raise UserError(f"a worker of the cluster runs jaxstick {version()}, and this is {wanted}.")
    return compute(pickle.loads(points), derivatives=derivatives)
