"""Renders the training scenes: many small worlds, a few frames of each, far apart in time."""

import pathlib
import subprocess
from typing import Iterable, Iterator, NamedTuple

# More than the network's 640 columns of a street: room for scaling and cropping.
WIDE = (832, 288)
# Sizes of the drone's and the glasses' own cameras, with more rows.
TALL = {"drone": (752, 480), "wearable": (640, 480)}

# Image quality of the simulator, by turns: sensor noise, blur of the lens, vignetting.
LOOKS = ((1.5, 0.35, 0.2), (0.7, 0.35, 0.1), (2.5, 0.35, 0.2), (1.2, 0.7, 0.3))


class Share(NamedTuple):
    """Worlds of a scene: number, first seed, frames of each with rate and size."""

    scene: str
    first_seed: int
    worlds: int
    frames: int
    rate_hz: float
    size: tuple[int, int] = WIDE


# All seeds are above those of the product's own tests and figures.
TRAINING = (
    # Diverse, to generalise to real streets.
    Share("varied", 1000, 200, 16, 10.0),
    # Similar to the product's own recordings.
    Share("street", 1000, 40, 16, 1.7),
    Share("drone", 1000, 14, 16, 1.7),
    Share("wearable", 1000, 10, 16, 1.7),
    Share("drone", 1100, 16, 16, 1.7, TALL["drone"]),
    Share("wearable", 1100, 14, 16, 1.7, TALL["wearable"]),
)
# Never trained on: for choosing thresholds.
VALIDATION = (
    Share("varied", 500, 4, 8, 10.0),
    Share("street", 500, 4, 12, 1.3),
    Share("drone", 500, 2, 12, 1.3),
    Share("wearable", 500, 2, 12, 1.3),
    Share("drone", 510, 2, 12, 1.3, TALL["drone"]),
    Share("wearable", 510, 2, 12, 1.3, TALL["wearable"]),
)


def worlds(shares: Iterable[Share]) -> Iterator[tuple[Share, int]]:
    """Every world of the shares with its seed."""
    for share in shares:
        for seed in range(share.first_seed, share.first_seed + share.worlds):
            yield share, seed


def render(simulator: str, folder: pathlib.Path, share: Share, seed: int) -> pathlib.Path:
    """Renders one world unless it exists, and returns its folder. An interrupted one is rendered again."""
    recording = folder / f"{share.scene}-{seed}"
    done = recording / "rendered"
    if not done.exists():
        noise, blur, vignetting = LOOKS[seed % len(LOOKS)]
        width, height = share.size
        subprocess.run(
            [simulator, share.scene, "--out", recording, "--seed", str(seed), "--frames", str(share.frames),
             "--rate", str(share.rate_hz), "--width", str(width), "--height", str(height), "--degrade", "off",
             "--noise", str(noise), "--blur", str(blur), "--vignetting", str(vignetting), "--quiet"],
            check=True)
        done.touch()
    return recording


def render_all(simulator: str, folder: pathlib.Path, shares: Iterable[Share]) -> list[pathlib.Path]:
    """Renders the missing worlds of the shares; returns the folders of all their worlds."""
    folder.mkdir(parents=True, exist_ok=True)
    return [render(simulator, folder, *world) for world in worlds(shares)]
