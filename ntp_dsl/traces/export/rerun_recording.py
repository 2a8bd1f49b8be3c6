"""Traces as a rerun recording, in a file or streamed: scene, calls, probabilities and pictures."""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.traces.page.document import Moment
from ntp_dsl.traces.page.page_pictures import pictures
from ntp_dsl.traces.page.page_scene import episode_motion
from ntp_dsl.traces.phrases import format_call
from ntp_dsl.traces.schema import ROOT, Call
from ntp_dsl.traces.trace import Trace

APPLICATION = "ntp_dsl"
FRAME, TIME = "frame", "time"  # timelines: a number, and seconds of the robot's clock
SIDES = ("A", "B")
PATIENCE = 10.0  # [s] that a viewer has for taking what is sent


def write_recording(traces: Sequence[Trace], folders: Sequence[Path], path: Path) -> None:
    """Write each trace below its own entity."""
    import rerun  # of an extra, and slow to import

    recording = rerun.RecordingStream(APPLICATION)
    recording.save(path)
    for side, trace, folder in zip(SIDES, traces, folders, strict=False):
        Entities(rerun, recording, side).send(trace, folder)
    recording.flush()
    recording.disconnect()


class Viewer:
    """A viewer that is sent a trace while that grows. Raises `ConnectionError` where none answers."""

    def __init__(self, address: str) -> None:
        os.environ.setdefault("RUST_LOG", "off")  # else it writes to the terminal while it looks for one
        import rerun  # of an extra, and slow to import

        self._recording = rerun.RecordingStream(APPLICATION)
        try:
            self._recording.connect_grpc(address)
            self._recording.flush(timeout_sec=PATIENCE)
        except RuntimeError as error:
            raise ConnectionError(str(error)) from error
        self._entities = Entities(rerun, self._recording, SIDES[0])

    def send(self, trace: Trace, folder: Path) -> None:
        """Send what has been added to the trace; its pictures lie in the folder."""
        self._entities.send(trace, folder)

    def close(self) -> bool:
        """Return whether the viewer has taken all that was sent."""
        try:
            self._recording.flush(timeout_sec=PATIENCE)
        except RuntimeError:
            return False
        finally:
            self._recording.disconnect()
        return True


class Entities:
    """The entities of one trace, which may still be growing: what was sent is not sent again.

    Args:
        rerun: the module, which is imported only where it is needed.
        recording: a stream of it.
        side: the entity below which they are.
    """

    def __init__(self, rerun: Any, recording: Any, side: str) -> None:
        self.rerun, self.recording, self.side = rerun, recording, side
        self._times: dict[int, float] = {}  # of frames
        self._last = self._last_picture = -1  # frames that were sent
        self._said: set[tuple[int, bool]] = set()  # calls, and returns, that were sent

    def send(self, trace: Trace, folder: Path) -> None:
        """Send what has been added to the trace; its pictures lie in the folder."""
        moments = [*episode_motion(trace)]
        self._times |= {frame: time for frame, time, *_ in moments}
        if self._last < 0:
            self._scene(trace)
        self._tracks(trace, [each for each in moments if each[0] > self._last])
        self._last = max([self._last, *self._times])
        self._calls(trace)
        for picture in pictures(trace, folder, self._last_picture):
            image = self.rerun.EncodedImage(contents=picture.content, media_type=picture.media_type)
            self._at(picture.frame)
            self.recording.log(self._path("camera"), image)
            self._last_picture = picture.frame

    def _scene(self, trace: Trace) -> None:
        for obj in trace.header.objects:
            half = [extent / 2 for extent in obj.size]
            box = self.rerun.Boxes3D(half_sizes=[half], labels=[obj.name])
            self.recording.log(self._path("scene", obj.name), box, static=True)
        hand = self.rerun.Points3D([[0, 0, 0]], radii=[0.01], labels=["hand"])
        self.recording.log(self._path("hand"), hand, static=True)

    def _tracks(self, trace: Trace, moments: Sequence[Moment]) -> None:
        """Send the positions of the hand and of objects, as columns."""
        tracks: defaultdict[str, dict[int, Vector]] = defaultdict(dict)
        known = {each.name for each in trace.header.objects}
        for frame, _, hand, _, moved in moments:
            tracks[self._path("hand")][frame] = hand
            for name, position in moved.items():
                if name in known:
                    tracks[self._path("scene", name)][frame] = position
        for path, positions in tracks.items():
            columns = self.rerun.Transform3D.columns(translation=list(positions.values()))
            self.recording.send_columns(path, indexes=self._indexes(list(positions)), columns=columns)

    def _calls(self, trace: Trace) -> None:
        rows = list(self._rows(trace))
        if not rows:
            return
        frames = [frame for frame, *_ in rows]
        log = self.rerun.TextLog.columns(
            text=[text for _, text, *_ in rows], level=[level for _, _, level, *_ in rows]
        )
        self.recording.send_columns(self._path("calls"), indexes=self._indexes(frames), columns=log)
        depths = self.rerun.Scalars.columns(scalars=[float(depth) for *_, depth, _ in rows])
        self.recording.send_columns(self._path("depth"), indexes=self._indexes(frames), columns=depths)
        sure = [(frame, probability) for frame, *_, probability in rows if probability is not None]
        if sure:
            scalars = self.rerun.Scalars.columns(scalars=[probability for _, probability in sure])
            indexes = self._indexes([frame for frame, _ in sure])
            self.recording.send_columns(self._path("probability"), indexes=indexes, columns=scalars)

    def _rows(self, trace: Trace) -> Iterator[tuple[int, str, str, int, float | None]]:
        """Yield frame, text, level, depth and probability of new calls and failed returns."""
        depths: dict[int, int] = {ROOT: -1}
        for call, returns in trace.events():
            depth = depths.setdefault(call.id, depths[call.parent] + 1)
            if (call.id, returns) in self._said:
                continue
            self._said.add((call.id, returns))
            indent = "  " * min(depth, 40)
            if not returns:
                yield call.frame, f"{indent}{format_call(call)}", "INFO", depth, call.decision.probability
            elif not call.succeeded:
                text = f"{indent}{format_call(call)}: {call.outcome}"
                yield _end_frame(call), text, "ERROR" if not call.is_program else "WARN", depth, None

    def _indexes(self, frames: Sequence[int]) -> list[Any]:
        times = [self._time(frame) for frame in frames]
        column = self.rerun.TimeColumn
        return [column(FRAME, sequence=list(frames)), column(TIME, duration=times)]

    def _time(self, frame: int) -> float:
        return self._times.get(frame, frame / 10)

    def _at(self, frame: int) -> None:
        self.recording.set_time(FRAME, sequence=frame)
        self.recording.set_time(TIME, duration=self._time(frame))

    def _path(self, *parts: str) -> str:
        """Return the path of an entity; each part is escaped, whatever an object is named."""
        return str(self.rerun.new_entity_path([self.side, *parts]))


def _end_frame(call: Call) -> int:
    return call.frame if call.end_frame is None else call.end_frame
