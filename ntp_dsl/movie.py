"""Pictures of an episode: an animation of the arm at work, and a strip of its key moments."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ntp_dsl.files import written_whole

Picture = NDArray[np.uint8]  # (height, width, 3)
SIZE = (400, 300)  # width, height
SPEED_UP = 2.5  # of the animation over real time
FRAME_TIME = 0.1  # [s] between two frames of a world
ROWS, COLUMNS = 2, 3  # of pictures in a strip


class Camera:
    """Takes every so-many-th frame of a world that can render itself."""

    def __init__(self, render: Callable[[int, int], Picture], every: int = 3) -> None:
        self._render, self._every = render, every
        self._seen = 0
        self.pictures: list[Picture] = []

    def frame(self, *_: object) -> None:
        if self._seen % self._every == 0:
            self.take()
        self._seen += 1

    def take(self) -> None:
        self.pictures.append(self._render(*SIZE))

    def write_animation(self, path: Path) -> None:
        """A GIF that rests for two seconds on the result."""
        images = [_paletted(picture) for picture in self.pictures]
        step = 1000 * FRAME_TIME * self._every / SPEED_UP
        durations = [round(step)] * (len(images) - 1) + [2000]
        with written_whole(path) as partial:
            images[0].save(
                partial,
                format="GIF",
                save_all=True,
                append_images=images[1:],
                duration=durations,
                loop=0,
            )

    def write_strip(self, path: Path) -> None:
        """The first picture, the last, and evenly between them, to be read row by row."""
        chosen = np.linspace(0, len(self.pictures) - 1, ROWS * COLUMNS).round().astype(int)
        rows = [[self.pictures[index] for index in row] for row in chosen.reshape(ROWS, COLUMNS)]
        strip = np.concatenate([np.concatenate(row, axis=1) for row in rows])
        with written_whole(path) as partial:
            Image.fromarray(strip).save(partial, format="PNG", optimize=True)


def _paletted(picture: Picture) -> Image.Image:
    return Image.fromarray(picture).quantize(128, dither=Image.Dither.NONE)
