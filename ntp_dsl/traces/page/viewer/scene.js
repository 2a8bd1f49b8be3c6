// The scene at one frame from above, the heights of objects over time, and the camera's picture.

const VIEW = 220; // width and height of the view from above
const CHART_HEIGHT = 60; // of the chart of object heights

// Returns the motion of a trace by object: frames and positions, in order. The hand's name is empty.
function tracks(data) {
  const found = new Map();
  for (const [frame, , hand, , moved] of data.motion) {
    follow(found, "", frame, hand);
    for (const [name, position] of Object.entries(moved)) follow(found, name, frame, position);
  }
  return found;
}

function follow(found, name, frame, position) {
  if (!found.has(name)) found.set(name, { frames: [], positions: [] });
  const track = found.get(name);
  track.frames.push(frame);
  track.positions.push(position);
}

function positionAt(track, frame) {
  let low = 0;
  for (let high = track.frames.length - 1; low < high; ) {
    const middle = (low + high + 1) >> 1;
    if (track.frames[middle] <= frame) low = middle;
    else high = middle - 1;
  }
  return track.positions[low];
}

// The robot's base is below; x is ahead of it, y to its left.
function mapping(data) {
  const positions = [...data.tracks.entries()].flatMap(([name, track]) => (data.sizes[name]?.[0] > 0.5 ? [] : track.positions));
  const xs = positions.map((position) => position[0]);
  const ys = positions.map((position) => position[1]);
  const range = (values) => values.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
  const [[x0, x1], [y0, y1]] = [range(xs), range(ys)];
  const scale = (VIEW - 40) / Math.max(x1 - x0, y1 - y0, 0.1);
  return {
    scale,
    u: (position) => VIEW / 2 - (position[1] - (y0 + y1) / 2) * scale,
    v: (position) => VIEW / 2 - (position[0] - (x0 + x1) / 2) * scale,
  };
}

function topView(data) {
  const map = data.mapping;
  const picture = svgElement("svg", { viewBox: `0 0 ${VIEW} ${VIEW}`, role: "img", "aria-label": "from above" });
  picture.append(svgElement("rect", { class: "frame-box", x: 0.5, y: 0.5, width: VIEW - 1, height: VIEW - 1 }));
  const present = [...data.tracks.entries()].filter(([name]) => name && !(data.sizes[name]?.[0] > 0.5));
  for (const [, track] of present) {
    const points = track.positions.map((position) => `${map.u(position).toFixed(1)},${map.v(position).toFixed(1)}`);
    if (points.length > 1) picture.append(svgElement("polyline", { class: "path", points: points.join(" ") }));
  }
  const now = present.map(([name, track]) => [name, positionAt(track, chosen.frame)]);
  now.sort((one, other) => one[1][2] - other[1][2]);
  for (const [name, position] of now) {
    const size = data.sizes[name] || [0.05, 0.05, 0.05];
    const [width, height] = [size[1] * map.scale, size[0] * map.scale];
    const x = map.u(position) - width / 2;
    const y = map.v(position) - height / 2;
    picture.append(svgElement("rect", { class: "object", x, y, width, height }, svgElement("title", {}, name)));
    picture.append(svgElement("text", { x: x + 2, y: y + height / 2 + 3 }, name.replace(/^.*_(?=\d)/, "")));
  }
  const hand = data.tracks.get("");
  if (hand) {
    const at = positionAt(hand, chosen.frame);
    const [u, v] = [map.u(at), map.v(at)];
    picture.append(svgElement("path", { class: "hand", d: `M${u - 7} ${v}h14M${u} ${v - 7}v14` }));
  }
  return picture;
}

function heights(data) {
  const shape = { class: "chart", viewBox: `0 0 ${VIEW} ${CHART_HEIGHT}`, preserveAspectRatio: "none" };
  const chart = svgElement("svg", { ...shape, role: "img", "aria-label": "heights over time" });
  const top = data.top || 0.5;
  const u = (frame) => (VIEW * frame) / Math.max(1, page.frames - 1);
  const v = (position) => CHART_HEIGHT - 2 - ((CHART_HEIGHT - 6) * position[2]) / top;
  chart.append(svgElement("rect", { class: "frame-box", x: 0.5, y: 0.5, width: VIEW - 1, height: CHART_HEIGHT - 1 }));
  for (const [name, track] of data.tracks) {
    if (data.sizes[name]?.[0] > 0.5) continue;
    const points = [];
    track.frames.forEach((frame, index) => {
      if (index) points.push(`${u(frame).toFixed(1)},${v(track.positions[index - 1]).toFixed(1)}`);
      points.push(`${u(frame).toFixed(1)},${v(track.positions[index]).toFixed(1)}`);
    });
    const last = track.positions[track.positions.length - 1];
    points.push(`${u(data.last).toFixed(1)},${v(last).toFixed(1)}`);
    chart.append(svgElement("polyline", { class: "path", points: points.join(" ") }, svgElement("title", {}, name || "hand")));
  }
  chart.append(svgElement("path", { class: "cursor", d: `M${u(chosen.frame)} 0V${CHART_HEIGHT}` }));
  return chart;
}

function cameraPicture(data) {
  const taken = data.pictures.filter(([frame]) => frame <= chosen.frame).pop() || data.pictures[0];
  return taken ? element("img", { src: taken[1], alt: `camera picture at frame ${taken[0]}` }) : null;
}

function prepare() {
  for (const data of page.traces) {
    data.tracks = tracks(data);
    data.mapping = mapping(data);
    data.last = data.motion.length ? data.motion[data.motion.length - 1][0] : 0;
    data.top = Math.max(0.1, ...(data.tracks.get("")?.positions || []).map((position) => position[2]).slice(0, 50000));
  }
}

function drawScene() {
  const boxes = SIDES.filter((side) => trace(side).motion.length).map((side) => {
    const data = trace(side);
    return element("figure", { class: `side-${side}` }, cameraPicture(data), topView(data), heights(data));
  });
  byId("scene").replaceChildren(element("div", { class: "scenes" }, ...boxes));
}
