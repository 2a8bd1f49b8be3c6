"""Pictures of an episode: those that its trace refers to, an animation, and a strip of six."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ntp_dsl.common.files import written_whole

Picture = NDArray[np.uint8]  # (height, width, 3)
SIZE = (400, 300)  # width, height
SPEED_UP = 2.5  # of the animation over real time
FRAME_TIME = 0.1  # [s] between two frames of a world
ROWS, COLUMNS = 2, 3  # of pictures in a strip


class Camera:
    """Takes pictures at regular frames of a world that can render itself, and writes them below a folder."""

    def __init__(self, render: Callable[[int, int], Picture], folder: Path, every: int = 3) -> None:
        self._render, self._folder, self._every = render, folder, every
        self._seen = 0
        self.pictures: list[Picture] = []

    def frame(self, *_: object) -> str | None:
        """Take a picture where it is due, and return its path relative to the folder."""
        number, self._seen = self._seen, self._seen + 1
        if number % self._every:
            return None
        self.take()
        path = self._folder / "frames" / f"{number:05d}.jpg"
        with written_whole(path) as partial:
            Image.fromarray(self.pictures[-1]).save(partial, format="JPEG", quality=80)
        return str(path.relative_to(self._folder))

    def take(self) -> None:
        """Take a picture."""
        self.pictures.append(self._render(*SIZE))

    def write_animation(self, path: Path) -> None:
        """Write a GIF that shows the last picture for two seconds."""
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
        """Write the first picture, the last, and evenly spaced ones between them, row by row."""
        chosen = np.linspace(0, len(self.pictures) - 1, ROWS * COLUMNS).round().astype(int)
        rows = [[self.pictures[index] for index in row] for row in chosen.reshape(ROWS, COLUMNS)]
        strip = np.concatenate([np.concatenate(row, axis=1) for row in rows])
        with written_whole(path) as partial:
            Image.fromarray(strip).save(partial, format="PNG", optimize=True)


def _paletted(picture: Picture) -> Image.Image:
    return Image.fromarray(picture).quantize(128, dither=Image.Dither.NONE)
