// The scene at one frame, seen from above; how high things were over time; and what the camera saw.

const VIEW = 220; // of the drawing, square
const TALL = 60; // of the chart of heights

// Everything of a trace's motion by thing: frames and places, in order.
function tracks(made) {
  const found = new Map();
  for (const [frame, , hand, , moved] of made.motion) {
    follow(found, "", frame, hand);
    for (const [name, place] of Object.entries(moved)) follow(found, name, frame, place);
  }
  return found;
}

function follow(found, name, frame, place) {
  if (!found.has(name)) found.set(name, { frames: [], places: [] });
  const track = found.get(name);
  track.frames.push(frame);
  track.places.push(place);
}

function placeAt(track, frame) {
  let low = 0;
  for (let high = track.frames.length - 1; low < high; ) {
    const middle = (low + high + 1) >> 1;
    if (track.frames[middle] <= frame) low = middle;
    else high = middle - 1;
  }
  return track.places[low];
}

// The robot's base is below; x is ahead of it, y to its left.
function mapping(made) {
  const places = [...made.tracks.entries()].flatMap(([name, track]) => (made.sizes[name]?.[0] > 0.5 ? [] : track.places));
  const xs = places.map((place) => place[0]);
  const ys = places.map((place) => place[1]);
  const range = (values) => values.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
  const [[x0, x1], [y0, y1]] = [range(xs), range(ys)];
  const scale = (VIEW - 40) / Math.max(x1 - x0, y1 - y0, 0.1);
  return {
    scale,
    u: (place) => VIEW / 2 - (place[1] - (y0 + y1) / 2) * scale,
    v: (place) => VIEW / 2 - (place[0] - (x0 + x1) / 2) * scale,
  };
}

function fromAbove(made) {
  const map = made.mapping;
  const picture = drawn("svg", { viewBox: `0 0 ${VIEW} ${VIEW}`, role: "img", "aria-label": "from above" });
  picture.append(drawn("rect", { class: "frame-box", x: 0.5, y: 0.5, width: VIEW - 1, height: VIEW - 1 }));
  const present = [...made.tracks.entries()].filter(([name]) => name && !(made.sizes[name]?.[0] > 0.5));
  for (const [, track] of present) {
    const points = track.places.map((place) => `${map.u(place).toFixed(1)},${map.v(place).toFixed(1)}`);
    if (points.length > 1) picture.append(drawn("polyline", { class: "path", points: points.join(" ") }));
  }
  const now = present.map(([name, track]) => [name, placeAt(track, chosen.frame)]);
  now.sort((one, other) => one[1][2] - other[1][2]);
  for (const [name, place] of now) {
    const size = made.sizes[name] || [0.05, 0.05, 0.05];
    const [width, height] = [size[1] * map.scale, size[0] * map.scale];
    const x = map.u(place) - width / 2;
    const y = map.v(place) - height / 2;
    picture.append(drawn("rect", { class: "thing", x, y, width, height }, drawn("title", {}, name)));
    picture.append(drawn("text", { x: x + 2, y: y + height / 2 + 3 }, name.replace(/^.*_(?=\d)/, "")));
  }
  const hand = made.tracks.get("");
  if (hand) {
    const at = placeAt(hand, chosen.frame);
    const [u, v] = [map.u(at), map.v(at)];
    picture.append(drawn("path", { class: "hand", d: `M${u - 7} ${v}h14M${u} ${v - 7}v14` }));
  }
  return picture;
}

function heights(made) {
  const shape = { class: "chart", viewBox: `0 0 ${VIEW} ${TALL}`, preserveAspectRatio: "none" };
  const chart = drawn("svg", { ...shape, role: "img", "aria-label": "heights over time" });
  const top = made.top || 0.5;
  const u = (frame) => (VIEW * frame) / Math.max(1, page.frames - 1);
  const v = (place) => TALL - 2 - ((TALL - 6) * place[2]) / top;
  chart.append(drawn("rect", { class: "frame-box", x: 0.5, y: 0.5, width: VIEW - 1, height: TALL - 1 }));
  for (const [name, track] of made.tracks) {
    if (made.sizes[name]?.[0] > 0.5) continue;
    const points = [];
    track.frames.forEach((frame, place) => {
      if (place) points.push(`${u(frame).toFixed(1)},${v(track.places[place - 1]).toFixed(1)}`);
      points.push(`${u(frame).toFixed(1)},${v(track.places[place]).toFixed(1)}`);
    });
    const last = track.places[track.places.length - 1];
    points.push(`${u(made.last).toFixed(1)},${v(last).toFixed(1)}`);
    chart.append(drawn("polyline", { class: "path", points: points.join(" ") }, drawn("title", {}, name || "hand")));
  }
  chart.append(drawn("path", { class: "cursor", d: `M${u(chosen.frame)} 0V${TALL}` }));
  return chart;
}

function photograph(made) {
  const taken = made.pictures.filter(([frame]) => frame <= chosen.frame).pop() || made.pictures[0];
  return taken ? element("img", { src: taken[1], alt: `what the camera saw at frame ${taken[0]}` }) : null;
}

function prepare() {
  for (const made of page.traces) {
    made.tracks = tracks(made);
    made.mapping = mapping(made);
    made.last = made.motion.length ? made.motion[made.motion.length - 1][0] : 0;
    made.top = Math.max(0.1, ...(made.tracks.get("")?.places || []).map((place) => place[2]).slice(0, 50000));
  }
}

function drawScene() {
  const boxes = SIDES.filter((side) => trace(side).motion.length).map((side) => {
    const made = trace(side);
    return element("figure", { class: `side-${side}` }, photograph(made), fromAbove(made), heights(made));
  });
  byId("scene").replaceChildren(element("div", { class: "scenes" }, ...boxes));
}
