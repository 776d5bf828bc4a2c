"""What the tests share: a small simulated sequence, and trackers of its box."""

import os
import subprocess

import numpy as np
import pytest

import holdfast

FRAMES = 24


@pytest.fixture(scope="session")
def camera():
    return holdfast.Camera(fx=330, fy=330, cx=159.5, cy=119.5, width=320, height=240)


@pytest.fixture(scope="session")
def box():
    return holdfast.textured_box()


@pytest.fixture(scope="session")
def simulation(box, camera):
    return holdfast.Simulation(box, camera, frames=FRAMES, samples=2, seed=3, motion={"speed": 2.0})


@pytest.fixture(scope="session")
def frames(simulation):
    return [simulation[i].image for i in range(len(simulation))]


@pytest.fixture(scope="session")
def device():
    return holdfast.Device()


@pytest.fixture
def tracker(box, camera, device, simulation):
    tracker = holdfast.Tracker(box, camera, device=device)
    tracker.reset(simulation.poses[0])
    return tracker


@pytest.fixture(scope="session")
def program():
    """Runs the program with these arguments; fails where it fails."""
    path = os.environ.get("HOLDFAST_PROGRAM")
    if not path:
        pytest.skip("HOLDFAST_PROGRAM does not name the program")

    def run(*arguments):
        done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr

    return run


def distance(a, b):
    """Largest difference of two poses' entries."""
    return float(np.max(np.abs(np.asarray(a) - np.asarray(b))))
