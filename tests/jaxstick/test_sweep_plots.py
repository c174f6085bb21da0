"""Stop regions, a sweep's outcomes over its axes, and the figures made of them."""

from __future__ import annotations

import io
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from jaxstick.output import OutputFolder
from jaxstick.plots.sweep import amplitude_curves, amplitude_map, draw_sweep, stop_colours
from jaxstick.record import AssumedConstants, KnownRig
from jaxstick.sweeps.field import Field, FieldBuilder, curves, said
from jaxstick.sweeps.plan import Plan
from jaxstick.sweeps.regions import Region, bridged, regions

NAN = np.nan


def test_regions_end_halfway_to_the_next_value():
    axis = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    found = regions(axis, np.array([4.0, 4.0, NAN, 2.0, 2.0]))
    assert found == [
        Region(4.0, 0, 1, 1.0, 2.5),
        Region(None, 2, 2, 2.5, 3.5),
        Region(2.0, 3, 4, 3.5, 5.0),
    ]
    assert regions(np.array([0.3]), np.array([2.0])) == [Region(2.0, 0, 0, 0.3, 0.3)]


def test_a_gap_within_one_region_is_bridged():
    stops = np.array([NAN, 4.0, NAN, NAN, 4.0, NAN, 2.0, NAN])
    np.testing.assert_array_equal(bridged(stops), [NAN, 4, 4, 4, 4, NAN, 2, NAN])
    nothing = np.full(3, NAN)
    np.testing.assert_array_equal(bridged(nothing), nothing)


def plan(**axes: tuple[float, ...]) -> Plan:
    rig = KnownRig(2.38, 1986.0, 1986.0, 4.53, 0.0)
    return Plan(rig, AssumedConstants(1.0, 100.0, 6.0, 0.0, 1e5), "loaded", axes)


def lanes(rng: np.random.Generator, **axes: tuple[float, ...]) -> dict[str, np.ndarray]:
    """Columns of all combinations in any order; the stops say where on the axes a lane lies."""
    ratios, amplitudes, levels = (np.asarray(axes[name]) for name in ("ratios", "amplitudes", "level"))
    i, j, k = (index.ravel() for index in np.indices((len(ratios), len(amplitudes), len(levels))))
    order = rng.permutation(len(i))
    i, j, k = i[order], j[order], k[order]
    return {
        "frequency_ratio": ratios[i] * (1 + 1e-15),
        "base_amplitude_m": amplitudes[j],
        "A_n": 0.2 * levels[k],
        "C_n": levels[k] - 0.2 * levels[k],
        "amplitude_ratio": 1.0 + i,
        "stops": (100 * i + 10 * j + k).astype(float),
        "period": np.where((i == 1) & (j == 0), 0, 1),
    }


def test_a_field_is_filled_chunk_by_chunk_and_is_in_ascending_order():
    axes = {"ratios": (0.3, 0.1, 0.2), "amplitudes": (0.01, 0.02), "level": (7.0, 5.0)}
    columns = lanes(np.random.default_rng(1), **axes)
    builder = FieldBuilder(plan(**axes))
    for part in (slice(0, 5), slice(5, None)):
        builder.add({name: column[part] for name, column in columns.items()})
    field = builder.field()
    assert list(field.axes) == ["amplitudes", "level", "ratios"]
    np.testing.assert_array_equal(field.axes["ratios"], [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(field.outcomes["stops"][1, 1], [110, 210, 10])
    np.testing.assert_array_equal(field.outcomes["stops"][0, 0], [NAN, 201, 1])
    chosen, curve = list(curves(field, "ratios"))[1]
    assert said(field, chosen) == "base amplitude 10 mm, static friction A + C 7 N"
    np.testing.assert_array_equal(curve.outcomes["stops"], [NAN, 200, 0])


def made_up(*shape: int) -> Field:
    """A field with stop regions, lanes that are not periodic, and as many axes as the shape has."""
    names = ("C", "level", "ratios")[-len(shape) :]
    axes = {name: np.linspace(0.1, 1.0, n) for name, n in zip(names, shape, strict=True)}
    x = np.broadcast_to(axes["ratios"], shape)
    stops = np.where(np.abs(x - 0.6) < 0.05, NAN, 2 * np.floor(0.5 / x))
    period = np.where(np.isfinite(stops), 1.0, 0.0)
    return Field(axes, {"amplitude_ratio": 1 / (1.1 - x), "stops": stops, "period": period})


@pytest.mark.parametrize(
    ("field", "names"),
    [
        (made_up(40), ["amplitude.png"]),
        (made_up(3, 40), ["amplitude.png"]),
        (made_up(9, 40), ["map.png"]),
        (made_up(2, 9, 40), ["map-01.png", "map-02.png"]),
        (made_up(1), ["amplitude.png"]),
        (
            Field({"ratios": np.array([0.5])}, dict.fromkeys(("amplitude_ratio", "stops"), np.array([NAN]))),
            None,
        ),
        (Field({"level": np.array([5.0, 6.0])}, made_up(2).outcomes), ["amplitude.png"]),
    ],
)
def test_every_kind_of_sweep_is_drawn(tmp_path, field, names):
    with OutputFolder(tmp_path / "out") as output:
        draw_sweep(field, output)
    found = sorted(path.name for path in (tmp_path / "out" / "plots").iterdir())
    assert found == (names or ["amplitude.png"])
    for name in found:
        assert np.ptp(matplotlib.image.imread(tmp_path / "out" / "plots" / name)[..., :3]) > 0.5


def test_the_same_sweep_is_the_same_picture(tmp_path):
    for name in ("a.png", "b.png"):
        amplitude_map(made_up(9, 30)).savefig(tmp_path / name, metadata={"Software": None})
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_a_curve_shows_its_regions_by_name():
    figure = amplitude_curves(made_up(60))
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert texts[-1] == "stops" and "2" in texts and "0" in texts
    colours = stop_colours(np.array([0.0, 2.0, NAN]))
    assert list(colours) == [0.0, 2.0]
    assert tuple(colours[0.0]) != tuple(colours[2.0])
    figure.savefig(io.BytesIO())


def test_plots_leave_the_users_matplotlib_alone(tmp_path: Path):
    before = dict(matplotlib.rcParams)
    amplitude_map(made_up(9, 30))
    assert dict(matplotlib.rcParams) == before
