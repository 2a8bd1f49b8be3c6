"""Traces as a rerun recording: scene, calls, probabilities and pictures over the frames."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.traces.page.page_pictures import pictures
from ntp_dsl.traces.page.page_scene import episode_motion
from ntp_dsl.traces.phrases import format_call
from ntp_dsl.traces.schema import ROOT, Call
from ntp_dsl.traces.trace import Trace

APPLICATION = "ntp_dsl"
FRAME, TIME = "frame", "time"  # timelines: a number, and seconds of the robot's clock
SIDES = ("A", "B")


def write_recording(traces: Sequence[Trace], folders: Sequence[Path], path: Path) -> None:
    """Write each trace below its own entity."""
    import rerun  # of an extra, and slow to import

    recording = rerun.RecordingStream(APPLICATION)
    recording.save(path)
    for side, trace, folder in zip(SIDES, traces, folders, strict=False):
        _Side(rerun, recording, side, trace).write(folder)
    recording.flush()
    recording.disconnect()


class _Side:
    """The entities of one trace. `rerun` is the module, which is imported only when it is needed."""

    def __init__(self, rerun: Any, recording: Any, side: str, trace: Trace) -> None:
        self.rerun, self.recording, self.side, self.trace = rerun, recording, side, trace
        self.moments = [*episode_motion(trace)]
        self.times = {frame: time for frame, time, *_ in self.moments}

    def write(self, folder: Path) -> None:
        self._scene()
        self._calls()
        for picture in pictures(self.trace, folder):
            image = self.rerun.EncodedImage(contents=picture.content, media_type=picture.media_type)
            self._at(picture.frame)
            self.recording.log(self._path("camera"), image)

    def _scene(self) -> None:
        for obj in self.trace.header.objects:
            half = [extent / 2 for extent in obj.size]
            box = self.rerun.Boxes3D(half_sizes=[half], labels=[obj.name])
            self.recording.log(self._path("scene", obj.name), box, static=True)
        hand = self.rerun.Points3D([[0, 0, 0]], radii=[0.01], labels=["hand"])
        self.recording.log(self._path("hand"), hand, static=True)
        for path, positions in self._tracks().items():
            self.recording.send_columns(
                path,
                indexes=self._indexes(list(positions)),
                columns=self.rerun.Transform3D.columns(translation=list(positions.values())),
            )

    def _tracks(self) -> Mapping[str, dict[int, Vector]]:
        """Return entity -> frame -> position."""
        tracks: defaultdict[str, dict[int, Vector]] = defaultdict(dict)
        known = {each.name for each in self.trace.header.objects}
        for frame, _, hand, _, moved in self.moments:
            tracks[self._path("hand")][frame] = hand
            for name, position in moved.items():
                if name in known:
                    tracks[self._path("scene", name)][frame] = position
        return tracks

    def _calls(self) -> None:
        rows = list(self._rows())
        if not rows:
            return
        frames = [frame for frame, *_ in rows]
        log = self.rerun.TextLog.columns(
            text=[text for _, text, _, _ in rows], level=[level for _, _, level, _ in rows]
        )
        self.recording.send_columns(self._path("calls"), indexes=self._indexes(frames), columns=log)
        depths = self.rerun.Scalars.columns(scalars=[float(depth) for *_, depth in rows])
        self.recording.send_columns(self._path("depth"), indexes=self._indexes(frames), columns=depths)
        probabilities = [
            (call.frame, call.decision.probability)
            for call in self.trace.calls
            if call.decision.probability is not None
        ]
        if probabilities:
            scalars = self.rerun.Scalars.columns(scalars=[probability for _, probability in probabilities])
            frames = [frame for frame, _ in probabilities]
            self.recording.send_columns(
                self._path("probability"), indexes=self._indexes(frames), columns=scalars
            )

    def _rows(self) -> Iterator[tuple[int, str, str, int]]:
        """Yield frame, text, level and depth of every call and of every failed return."""
        depths: dict[int, int] = {ROOT: -1}
        for call, returns in self.trace.events():
            depth = depths.setdefault(call.id, depths[call.parent] + 1)
            indent = "  " * min(depth, 40)
            if not returns:
                yield call.frame, f"{indent}{format_call(call)}", "INFO", depth
            elif not call.succeeded:
                text = f"{indent}{format_call(call)}: {call.outcome}"
                yield _end_frame(call), text, "ERROR" if not call.is_program else "WARN", depth

    def _indexes(self, frames: Sequence[int]) -> list[Any]:
        times = [self._time(frame) for frame in frames]
        column = self.rerun.TimeColumn
        return [column(FRAME, sequence=list(frames)), column(TIME, duration=times)]

    def _time(self, frame: int) -> float:
        return self.times.get(frame, frame / 10)

    def _at(self, frame: int) -> None:
        self.recording.set_time(FRAME, sequence=frame)
        self.recording.set_time(TIME, duration=self._time(frame))

    def _path(self, *parts: str) -> str:
        """Return the path of an entity; each part is escaped, whatever an object is named."""
        return str(self.rerun.new_entity_path([self.side, *parts]))


def _end_frame(call: Call) -> int:
    return call.frame if call.end_frame is None else call.end_frame
