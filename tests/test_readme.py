"""The Python example of the README runs as it stands."""

from __future__ import annotations

import textwrap
from pathlib import Path

import jax
import numpy as np


def test_the_readme_example_runs() -> None:
    """All of it but the fit, which the demo runs."""
    text = (Path(__file__).parent.parent / "README.md").read_text()
    begin = text.index("    import jax, jax.numpy as jnp")
    example = textwrap.dedent(text[begin : text.index("    from pathlib import Path", begin)])
    names: dict = {}
    with jax.numpy_dtype_promotion("standard"), jax.numpy_rank_promotion("allow"):
        exec(example, names)
    assert names["lanes"].shape == (64, 2000)
    assert np.ptp(np.asarray(names["run"].x)) > 0.01
    assert np.isfinite(names["slope"]) and names["slope"] != 0
