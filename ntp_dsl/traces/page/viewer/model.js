"use strict";
// What is shown, and what of it is chosen. Everything that a file says becomes text, never markup.

const page = JSON.parse(document.getElementById("data").textContent);
const SIDES = page.traces.length === 2 ? ["a", "b"] : ["a"];
const MARKS = { same: "", changed: "≠", "only a": "−", "only b": "+" };
const chosen = { row: 0, frame: 0, folded: new Set(), visible: [], query: "", watchers: [] };

function byId(id) {
  return document.getElementById(id);
}

function element(tag, attributes, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) made.setAttribute(name, value);
  made.append(...children.filter((child) => child !== null));
  return made;
}

function drawn(tag, attributes, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

function trace(side) {
  return page.traces[SIDES.indexOf(side)];
}

function call(row, side) {
  const number = row[side];
  return number === null || number === undefined ? null : trace(side).calls[number];
}

function letter(side) {
  return SIDES.length === 2 ? side.toUpperCase() : "";
}

function words(made) {
  return `${made.name}(${made.arguments})`;
}

function probability(value) {
  return value === null || value === undefined ? "" : value.toFixed(2);
}

function seconds(value) {
  return value >= 1 ? `${value.toFixed(1)} s` : `${Math.round(1000 * value)} ms`;
}

function spent(times) {
  return ["decide", "plan", "move"]
    .map((name, place) => (times[place] >= 0.0005 ? `${name} ${seconds(times[place])}` : ""))
    .filter(Boolean)
    .join(", ");
}

function tell(what) {
  for (const watcher of chosen.watchers) watcher(what);
}

function choose(number) {
  chosen.row = Math.max(0, Math.min(page.rows.length - 1, number));
  const made = SIDES.map((side) => call(page.rows[chosen.row], side)).find((each) => each);
  if (made) chosen.frame = made.frame;
  tell("row");
}

function scrub(frame) {
  chosen.frame = Math.max(0, Math.min(page.frames - 1, frame));
  tell("frame");
}

// The rows that are not folded away, by number.
function unfold() {
  chosen.visible = [];
  for (let number = 0; number < page.rows.length; ) {
    chosen.visible.push(number);
    number = chosen.folded.has(number) ? page.rows[number].end : number + 1;
  }
  tell("folding");
}

function reveal(number) {
  for (let above = page.rows[number].above; above >= 0; above = page.rows[above].above) chosen.folded.delete(above);
  unfold();
  choose(number);
}

function jump(step) {
  const places = page.divergences.map((each) => each.row).filter((row) => row >= 0);
  const sorted = [...new Set(places)].sort((one, other) => one - other);
  const ahead = step > 0 ? sorted.find((row) => row > chosen.row) : sorted.reverse().find((row) => row < chosen.row);
  if (ahead !== undefined) reveal(ahead);
}
