"use strict";
// The data of the page and the state of its views. Text from a trace is inserted as text, never as markup.

const page = JSON.parse(document.getElementById("data").textContent);
const SIDES = page.traces.length === 2 ? ["a", "b"] : ["a"];
const MARKS = { same: "", changed: "≠", "only a": "−", "only b": "+" };
const SURE = 0.995; // probabilities from here on are not worth showing
const chosen = { row: 0, frame: 0, shown: 0, folded: new Set(), visible: [], query: "", watchers: [] };

function byId(id) {
  return document.getElementById(id);
}

function element(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) node.setAttribute(name, value);
  node.append(...children.filter((child) => child !== null));
  return node;
}

function svgElement(tag, attributes, ...children) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

function trace(side) {
  return page.traces[SIDES.indexOf(side)];
}

function call(row, side) {
  const number = row[side];
  return number === null || number === undefined ? null : trace(side).calls[number];
}

// The calls that are looked at: those of the divergence at the chosen row, else the row's own.
function chosenCalls() {
  const row = page.rows[chosen.row] || {};
  const divergence = page.divergences.find((each) => each.row === chosen.row);
  return SIDES.map((side) => call(divergence || row, side));
}

function outcome(callData) {
  return callData.outcome || (page.goes_on ? "running" : "cut off");
}

function letter(side) {
  return SIDES.length === 2 ? side.toUpperCase() : "";
}

function callText(callData) {
  return `${callData.name}(${callData.arguments})`;
}

function percentage(value) {
  return value === null || value === undefined ? "" : `${(100 * value).toFixed(value > 0.1 && value < 0.9 ? 0 : 1).replace(/\.0$/, "")}%`;
}

function seconds(value) {
  return value >= 1 ? `${value.toFixed(1)} s` : `${Math.round(1000 * value)} ms`;
}

function timeText(times) {
  return ["decide", "plan", "move"]
    .map((name, place) => (times[place] >= 0.0005 ? `${name} ${seconds(times[place])}` : ""))
    .filter(Boolean)
    .join(", ");
}

function notify(change) {
  for (const watcher of chosen.watchers) watcher(change);
}

function choose(number) {
  if (!page.rows.length) return;
  chosen.row = Math.max(0, Math.min(page.rows.length - 1, number));
  const first = chosenCalls().find((each) => each);
  if (first) chosen.frame = first.frame;
  const scope = nearestScope();
  if (scope) chosen.shown = scope[0];
  notify("row");
}

// Returns the frames of the demonstration that the chosen call reads, or the nearest of its callers.
function nearestScope() {
  const own = chosenCalls().find((each) => each && each.scope);
  if (own) return own.scope;
  for (let number = chosen.row; number >= 0; number = page.rows[number].parent) {
    const found = SIDES.map((side) => call(page.rows[number], side)).find((each) => each && each.scope);
    if (found) return found.scope;
  }
  return null;
}

function scrub(frame) {
  chosen.frame = Math.max(0, Math.min(page.frames - 1, frame));
  notify("frame");
}

function scrubShown(frame) {
  chosen.shown = Math.max(0, Math.min(page.demonstration.frames - 1, frame));
  notify("frame");
}

// Lists the rows that are not folded away.
function updateVisible() {
  chosen.visible = [];
  for (let number = 0; number < page.rows.length; ) {
    chosen.visible.push(number);
    number = chosen.folded.has(number) ? page.rows[number].end : number + 1;
  }
  notify("folding");
}

function reveal(number) {
  if (!page.rows[number]) return;
  for (let parent = page.rows[number].parent; parent >= 0; parent = page.rows[parent].parent) chosen.folded.delete(parent);
  updateVisible();
  choose(number);
}

function jump(step) {
  const places = page.divergences.map((each) => each.row).filter((row) => row >= 0);
  const sorted = [...new Set(places)].sort((one, other) => one - other);
  const ahead = step > 0 ? sorted.find((row) => row > chosen.row) : sorted.reverse().find((row) => row < chosen.row);
  if (ahead !== undefined) reveal(ahead);
}
