// The scenes of the demonstration and of each trace at one frame, drawn in parallel projection, each as large as its
// place. The robot's base is behind the viewer: x is ahead, y to the left.

const COLOURS = ["#4c8dd6", "#e08a3c", "#4fa868", "#c76bb0", "#9b86e0", "#c9a227", "#46a6a6", "#d9646b", "#8a9a5b", "#7a8899"];
const VIEWS = [
  { name: "from above", turn: 0, tilt: 90 },
  { name: "at an angle", turn: 25, tilt: 35 },
  { name: "from the side", turn: 0, tilt: 0 },
];
const TOO_WIDE = 0.5; // [m], beyond which an object is not drawn: the table would hide the rest
const NARROW = 260; // [px] of a scene, in which only those are labelled, too
const MOST_LABELS = 24; // objects, beyond which only those that the chosen call names are labelled
const SIDES_OF_ROUND = 18; // faces that stand for a round side
const ROUND = ["cylinder", "bowl", "sphere"];
const HOLLOW = ["bin", "bowl"];
const MOVED = 0.01; // [m] that an object has to move for its path to be drawn
const radians = (degrees) => (degrees * Math.PI) / 180;
const view = { ...VIEWS[1] };

// Motion -----------------------------------------------------------------------------------------------------------

// Returns the motion of a scene by object: frames and places, in order. The hand's name is empty.
function tracks(scene) {
  const found = new Map();
  const follow = (name, frame, place) => {
    if (!found.has(name)) found.set(name, { frames: [], places: [] });
    found.get(name).frames.push(frame);
    found.get(name).places.push(place);
  };
  for (const [frame, , hand, , moved] of scene.motion) {
    follow("", frame, hand);
    for (const [name, place] of Object.entries(moved)) follow(name, frame, place);
  }
  return found;
}

// Returns the index of the last of sorted frames up to a frame.
function indexAt(frames, frame) {
  let low = 0;
  for (let high = frames.length - 1; low < high; ) {
    const middle = (low + high + 1) >> 1;
    if (frames[middle] <= frame) low = middle;
    else high = middle - 1;
  }
  return low;
}

function placeAt(track, frame) {
  return track.places[indexAt(track.frames, frame)];
}

function turnsAt(scene, frame) {
  const turns = {};
  for (const [since, turned] of scene.turns) {
    if (since > frame) break;
    Object.assign(turns, turned);
  }
  return turns;
}

// Shapes -----------------------------------------------------------------------------------------------------------

function rotate([x, y, z, w], [a, b, c]) {
  const [p, q, r] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * p + y * r - z * q, b + w * q + z * p - x * r, c + w * r + x * q - y * p];
}

function outline({ size, shape }) {
  if (!ROUND.includes(shape)) return [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([a, b]) => [(a * size[0]) / 2, (b * size[1]) / 2]);
  const angles = Array.from({ length: SIDES_OF_ROUND }, (_, k) => (2 * Math.PI * k) / SIDES_OF_ROUND);
  return angles.map((angle) => [(Math.cos(angle) * size[0]) / 2, (Math.sin(angle) * size[1]) / 2]);
}

// Returns the faces of an upright prism around the origin: corners, and the normal to the outside.
function faces(object) {
  const base = outline(object);
  const half = object.size[2] / 2;
  const level = (height) => base.map(([x, y]) => [x, y, height]);
  const found = [{ corners: level(half), normal: [0, 0, 1] }, { corners: level(-half), normal: [0, 0, -1] }];
  base.forEach(([x, y], k) => {
    const [p, q] = base[(k + 1) % base.length];
    found.push({ corners: [[x, y, -half], [p, q, -half], [p, q, half], [x, y, half]], normal: [q - y, x - p, 0] });
  });
  return found;
}

// Projection -------------------------------------------------------------------------------------------------------

// Returns how far right, how far up, and how near to the viewer a point or direction is.
function seenFrom([x, y, z]) {
  const [c, s] = [Math.cos(radians(view.turn)), Math.sin(radians(view.turn))];
  const [ahead, left] = [c * x - s * y, s * x + c * y];
  const [ct, st] = [Math.cos(radians(view.tilt)), Math.sin(radians(view.tilt))];
  return [-left, st * ahead + ct * z, st * z - ct * ahead];
}

// Returns a function from points to pixels, so that all places of a scene lie within the size.
function fitted(scene, width, height) {
  const corners = [scene.low, scene.high];
  const seen = Array.from({ length: 8 }, (_, k) => seenFrom([0, 1, 2].map((axis) => corners[(k >> axis) & 1][axis])));
  const range = (axis) => [Math.min(...seen.map((each) => each[axis])), Math.max(...seen.map((each) => each[axis]))];
  const [[u0, u1], [v0, v1]] = [range(0), range(1)];
  const scale = Math.min((width - 60) / Math.max(u1 - u0, 0.1), (height - 44) / Math.max(v1 - v0, 0.1));
  return (point) => {
    const [u, v] = seenFrom(point);
    return [width / 2 + (u - (u0 + u1) / 2) * scale, height / 2 + 6 - (v - (v0 + v1) / 2) * scale];
  };
}

function points(corners, project) {
  return corners.map((corner) => project(corner).map((each) => each.toFixed(1)).join(",")).join(" ");
}

// Drawing ----------------------------------------------------------------------------------------------------------

function drawn(scene, frame, interval, width, height) {
  const project = fitted(scene, width, height);
  const picture = svgElement("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `the ${scene.title}, ${view.name}` });
  picture.append(floor(scene, project));
  const named = new Set(chosenCalls().flatMap((each) => (each ? each.names : [])));
  const turns = turnsAt(scene, frame);
  const now = scene.small.map((name) => ({ name, place: placeAt(scene.tracks.get(name), frame), object: scene.objects[name] }));
  const nearness = ({ place, object }) => seenFrom(place)[2] - (HOLLOW.includes(object.shape) ? 0.05 : 0);
  now.sort((one, other) => nearness(one) - nearness(other));
  for (const each of now) picture.append(solid(each, turns[each.name] || [0, 0, 0, 1], project, named.has(each.name)));
  for (const each of now) {
    if ((now.length <= MOST_LABELS && width > NARROW) || named.has(each.name)) picture.append(label(each, project));
  }
  picture.append(...paths(scene, interval, named, project), ...hand(scene, frame, project));
  return picture;
}

function floor(scene, project) {
  const [[x0, y0, z], [x1, y1]] = [scene.low, scene.high];
  return svgElement("polygon", { class: "floor", points: points([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]], project) });
}

function solid({ name, place, object }, turn, project, isNamed) {
  const hollow = HOLLOW.includes(object.shape);
  const group = svgElement("g", { class: `object${isNamed ? " named" : ""}`, fill: colour(object.type) }, svgElement("title", {}, `${name}, ${object.type}`));
  for (const { corners, normal } of faces(object)) {
    const towards = seenFrom(rotate(turn, normal))[2];
    if (towards <= 1e-9 && !hollow) continue;
    const at = corners.map((corner) => rotate(turn, corner).map((each, axis) => each + place[axis]));
    const opacity = hollow ? 0.15 : normal[2] > 0 ? 0.95 : 0.7;
    group.append(svgElement("polygon", { points: points(at, project), "fill-opacity": opacity }));
  }
  return group;
}

function label({ name, place, object }, project) {
  const [u, v] = project([place[0], place[1], place[2] + object.size[2] / 2]);
  return svgElement("text", { x: u.toFixed(1), y: (v - 3).toFixed(1) }, name);
}

// The paths of the hand, and of what the chosen call names, while it was running.
function paths(scene, [begin, end], named, project) {
  const found = [];
  for (const [name, track] of scene.tracks) {
    if (name && !named.has(name)) continue;
    const places = track.places.slice(indexAt(track.frames, begin), indexAt(track.frames, end) + 1);
    const way = places.length > 1 ? Math.hypot(...places[0].map((each, axis) => each - places[places.length - 1][axis])) : 0;
    if (way > MOVED) found.push(svgElement("polyline", { class: name ? "path" : "path of-hand", points: points(places, project) }));
  }
  return found;
}

function hand(scene, frame, project) {
  const track = scene.tracks.get("");
  if (!track) return [];
  const at = placeAt(track, frame);
  const moment = scene.motion[indexAt(track.frames, frame)];
  const [[u, v], [p, q]] = [project(at), project([at[0], at[1], at[2] + 0.12])];
  const ring = svgElement("circle", { class: moment[3] ? "hand closed" : "hand", cx: u.toFixed(1), cy: v.toFixed(1), r: 5 });
  ring.append(svgElement("title", {}, moment[3] ? "the hand, closed" : "the hand, open"));
  return [svgElement("path", { class: "hand", d: `M${u.toFixed(1)} ${v.toFixed(1)}L${p.toFixed(1)} ${q.toFixed(1)}` }), ring];
}

// The panel --------------------------------------------------------------------------------------------------------

const scenes = []; // {scene, side, frame(), interval()}
let zoomed = -1; // the scene that has the whole panel, or -1

function colour(type) {
  return COLOURS[prepare.types.indexOf(type) % COLOURS.length];
}

function prepare() {
  const episodeInterval = (place) => () => {
    const found = chosenCalls()[place];
    return found ? [found.frame, found.end_frame ?? page.frames] : [0, 0];
  };
  scenes.length = 0;
  if (page.demonstration.scene) {
    scenes.push({ scene: page.demonstration.scene, side: "", frame: () => chosen.shown, interval: () => nearestScope() || [0, 0] });
  }
  SIDES.forEach((side, place) => {
    if (trace(side).scene.motion.length) scenes.push({ scene: trace(side).scene, side, frame: () => chosen.frame, interval: episodeInterval(place) });
  });
  for (const { scene } of scenes) {
    scene.tracks = tracks(scene);
    scene.small = [...scene.tracks.keys()].filter((name) => name && Object.hasOwn(scene.objects, name) && Math.max(scene.objects[name].size[0], scene.objects[name].size[1]) < TOO_WIDE);
    [scene.low, scene.high] = bounds(scene);
  }
  prepare.types = [...new Set(scenes.flatMap(({ scene }) => scene.small.map((name) => scene.objects[name].type)))].sort();
}

function bounds(scene) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const name of scene.small) {
    for (const place of scene.tracks.get(name).places) {
      for (let axis = 0; axis < 3; axis += 1) {
        low[axis] = Math.min(low[axis], place[axis] - scene.objects[name].size[axis] / 2);
        high[axis] = Math.max(high[axis], place[axis] + scene.objects[name].size[axis] / 2);
      }
    }
  }
  return low[0] < Infinity ? [low, high] : [[0, 0, 0], [0.1, 0.1, 0.1]];
}

function cameraPicture(scene, frame) {
  const taken = scene.pictures.filter(([at]) => at <= frame).pop() || scene.pictures[0];
  return taken ? element("img", { src: taken[1], alt: `camera picture at frame ${taken[0]}` }) : null;
}

function zoom() {
  zoomed = zoomed + 1 >= scenes.length ? -1 : zoomed + 1;
  document.body.classList.toggle("zoomed", zoomed >= 0);
  drawScene();
}

function changeView() {
  const next = VIEWS[(VIEWS.findIndex((each) => each.name === view.name) + 1) % VIEWS.length];
  Object.assign(view, next);
  drawScene();
}

function drawScene() {
  const shown = zoomed < 0 ? scenes : [scenes[zoomed]];
  if (byId("scenes").childElementCount !== shown.length) {
    byId("scenes").replaceChildren(...shown.map(() => element("figure", {}, element("figcaption", {}), element("div", { class: "drawing" }))));
  }
  byId("types").replaceChildren(...prepare.types.map(typeKey));
  shown.forEach(({ scene, side, frame, interval }, place) => {
    const figure = byId("scenes").children[place];
    figure.className = side ? `side-${side}` : "";
    figure.firstChild.textContent = `${side ? letter(side) : ""} ${scene.title}, ${side ? "" : "frame "}${side ? `${(frame() / 10).toFixed(1)} s` : frame()}`;
    const drawing = figure.lastChild;
    const image = cameraPicture(scene, frame());
    drawing.classList.toggle("pictured", image !== null);
    const height = drawing.clientHeight / (image ? 2 : 1);
    drawing.replaceChildren(...[image, drawn(scene, frame(), interval(), Math.max(drawing.clientWidth, 80), Math.max(height, 80))].filter(Boolean));
  });
}

function typeKey(type) {
  const swatch = svgElement("svg", { viewBox: "0 0 10 10", "aria-hidden": "true" }, svgElement("rect", { width: 10, height: 10, fill: colour(type) }));
  return element("span", {}, swatch, type);
}

function drag(event) {
  if (event.buttons !== 1) return;
  view.name = "turned by hand";
  view.turn += event.movementX / 3;
  view.tilt = Math.max(0, Math.min(90, view.tilt + event.movementY / 3));
  drawScene();
}

// Plays the chosen call: its frames in each trace, and what it reads of the demonstration.
const playing = { timer: null };

function play() {
  if (playing.timer) return stop();
  if (!chosenCalls().some(Boolean)) return;
  const begins = chosenCalls().filter(Boolean).map((each) => each.frame);
  const ends = chosenCalls().filter(Boolean).map((each) => each.end_frame ?? page.frames);
  const scope = nearestScope() || [0, 0];
  const last = Math.max(...ends, 0);
  if (chosen.frame >= last && chosen.shown >= scope[1] - 1) {
    chosen.frame = Math.min(...begins);
    chosen.shown = scope[0];
  }
  playing.timer = setInterval(() => {
    const before = [chosen.frame, chosen.shown];
    chosen.frame = Math.min(Math.max(chosen.frame, last), chosen.frame + 1);
    chosen.shown = Math.max(chosen.shown, Math.min(scope[1] - 1, chosen.shown + 1));
    if (before[0] === chosen.frame && before[1] === chosen.shown) stop();
    notify("frame");
  }, 100);
  notify("frame");
}

function stop() {
  clearInterval(playing.timer);
  playing.timer = null;
  notify("frame");
}
