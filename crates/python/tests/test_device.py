"""Searches on graphics processors: the couples of the processor where there is one, an error elsewhere."""

import numpy as np
import pytest

import fdem

RNG = np.random.default_rng(7)


def has_device() -> bool:
    """Whether there is a graphics processor, as the package sees it."""
    try:
        fdem.contacts(np.zeros((1, 3)), radii=1.0, device="gpu")
    except RuntimeError:
        return False
    return True


CASES = [
    {"radii": 0.4},
    {"radii": RNG.uniform(0.2, 0.5, 500)},
    {"cutoff": 0.8, "box": [8.0, 8.0, 8.0], "periodic": True},
    {"radii": 0.4, "groups": RNG.integers(0, 5, 500)},
]


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("case", CASES, ids=["radius", "radii", "box", "groups"])
def test_a_device_has_the_couples_of_the_processor_or_says_why_not(case, dtype):
    points = RNG.uniform(0.0, 8.0, (500, 3)).astype(dtype)
    if not has_device():
        with pytest.raises(RuntimeError, match="^device: .*(driver|compiler|device|without graphics processors)"):
            fdem.contacts(points, device="gpu", **case)
        return
    expected = fdem.contacts(points, engine="rows", **case)
    found = fdem.contacts(points, device="gpu", **case)
    assert len(expected) > 50
    assert np.array_equal(found.pairs, expected.pairs)
    assert np.array_equal(found.shift, expected.shift)


def test_names_of_devices_and_engines_are_checked():
    points = np.zeros((2, 3))
    with pytest.raises(ValueError, match="there is no device 'tpu': give cpu, gpu, or gpu:N"):
        fdem.contacts(points, radii=1.0, device="tpu")
    with pytest.raises(ValueError, match="a device has the engine rows only, not nbs"):
        fdem.contacts(points, radii=1.0, engine="nbs", device="gpu")
    assert len(fdem.contacts(points, radii=1.0, device="cpu")) == 1


def test_wrong_numbers_are_refused_before_a_device_is_opened():
    with pytest.raises(ValueError, match="element 1: coordinate y is NaN"):
        fdem.contacts([[0.0, 0.0], [1.0, float("nan")]], radii=1.0, device="gpu")
