// The labelling page: lists, buttons and keys around the view; stage.js draws boxes, changes.js keeps them.

import {Changes} from "/changes.js";
import {Stage} from "/stage.js";

const COLOURS = [
  "#ffb000", "#00b4d8", "#ff5d8f", "#7ae582", "#b892ff", "#ff7f51", "#3ddbd9", "#ffe14d", "#5b8cff", "#e056fd",
];
const find = (id) => document.getElementById(id);
const scene = await (await fetch("/api/scene")).json();
const names = scene.targets.map(({name}) => name);
const count = scene.views.length;
const image = (path) => `/${path}?${scene.id}`;
const colour = (name) => {
  const number = names.indexOf(name);
  return COLOURS[number] ?? `hsl(${(number * 137.5 + 60) % 360} 80% 65%)`;
};

let view = Math.min(Number(sessionStorage.getItem(`view ${scene.id}`) ?? 0), count - 1);
let chosen = names[0];
let noteTimer;

const stage = new Stage(find("canvas"), {
  colour,
  onBox: (name, box) => setBox(name, box),
  onChoose: (name) => { chosen = name; show(); },
});
const changes = new Changes(scene, {
  onChange: (changed) => { drawThumbnail(changed); drawCounts(); if (changed === view) show(); },
  onKept: drawKept,
  onNote: note,
});

// ---- what can be done -------------------------------------------------------------------------------------------

const current = () => changes.views[view];
// Who draws in a view that is not labelled says that it is; a proposal stays one until it is accepted.
const afterEdit = (boxes) => ({label: current().label === "proposed" ? "proposed" : "labelled", boxes});

function setBox(name, box) {
  changes.change(view, afterEdit({...current().boxes, [name]: box}));
}

const actions = {
  accept() { if (current().label === "proposed") actions.agree(); },
  agree() { changes.change(view, {label: "labelled", boxes: current().boxes}); },
  right() {
    actions.agree();
    go(following((labels) => labels.label !== "labelled"), "every view is labelled");
  },
  nothing() { changes.change(view, {label: "labelled", boxes: {}}); },
  copy() {
    const other = nearestWith(chosen);
    if (other === undefined) note(`no other view has a box of ${chosen}`);
    else setBox(chosen, changes.views[other].boxes[chosen]);
  },
  remove() {
    const {[chosen]: removed, ...boxes} = current().boxes;
    if (removed) changes.change(view, afterEdit(boxes));
  },
  undo() { go(changes.undo(), "there is nothing to undo"); },
  redo() { go(changes.redo(), "there is nothing to redo"); },
  previous() { go((view + count - 1) % count); },
  next() { go((view + 1) % count); },
  unlabelled() { go(following((labels) => labels.label === "unlabelled"), "no view is unlabelled"); },
  proposed() { go(following((labels) => labels.label === "proposed"), "no view has proposals"); },
  above() { choose(names.indexOf(chosen) - 1); },
  below() { choose(names.indexOf(chosen) + 1); },
  cancel() { stage.cancel(); },
  save() { changes.save(); },
};

const KEYS = {
  a: "accept", n: "nothing", c: "copy", x: "remove", delete: "remove", backspace: "remove", z: "undo", y: "redo",
  arrowleft: "previous", arrowright: "next", u: "unlabelled", p: "proposed", arrowup: "above", arrowdown: "below",
  enter: "right", escape: "cancel", "ctrl+z": "undo", "ctrl+y": "redo", "ctrl+shift+z": "redo", "ctrl+s": "save",
};

function choose(number) {
  chosen = names[(number + names.length) % names.length];
  show();
}

// The first view after this one, around the end, that is such.
function following(isSuch) {
  for (let step = 1; step <= count; step += 1) {
    const other = (view + step) % count;
    if (isSuch(changes.views[other])) return other;
  }
  return undefined;
}

// The view with a box of a target that was taken most nearly from here: 30 degrees count as much as a metre.
function nearestWith(name) {
  const [x, z, heading, tilt] = scene.poses[view];
  const turn = (angle) => Math.abs(((angle % 360) + 540) % 360 - 180);
  const away = ([ox, oz, oh, ot]) => Math.hypot(ox - x, oz - z) + (turn(oh - heading) + Math.abs(ot - tilt)) / 30;
  let best;
  for (let other = 0; other < count; other += 1) {
    if (other === view || !changes.views[other].boxes[name]) continue;
    if (best === undefined || away(scene.poses[other]) < away(scene.poses[best])) best = other;
  }
  return best;
}

function go(to, otherwise) {
  if (to === undefined) { note(otherwise); return; }
  view = to;
  sessionStorage.setItem(`view ${scene.id}`, view);
  show();
}

// ---- what is shown ----------------------------------------------------------------------------------------------

const element = (tag, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
};

const rows = scene.targets.map((target, number) => {
  const row = element("button", {onclick: () => choose(number)},
    element("kbd", {textContent: number < 9 ? number + 1 : ""}), element("i", {className: "swatch"}),
    element("span", {textContent: target.name}), element("small"));
  row.style.setProperty("--colour", colour(target.name));
  row.dataset.target = target.name;
  return row;
});
const thumbnails = scene.views.map((_, number) => {
  const picture = element("img", {src: image(`thumbnail/${number}`), loading: "lazy", alt: "", draggable: false});
  const button = element("button", {onclick: () => go(number), title: `view ${number + 1}`}, picture, element("b"));
  button.dataset.view = number;
  return button;
});

function show() {
  const labels = current();
  const [x, z, heading, tilt] = scene.poses[view];
  if (find("view").dataset.view !== String(view)) {
    find("view").src = image(`view/${view}`);
    find("view").dataset.view = view;
    for (const other of [view + 1, following(({label}) => label !== "labelled")]) { // likely to be next
      if (other < count) new Image().src = image(`view/${other}`);
    }
  }
  stage.show(labels, chosen);
  find("view-title").textContent = `View ${view + 1} of ${count}`;
  const angles = `${Math.round(heading)}°, tilt ${Math.round(tilt)}°`;
  find("pose").textContent = `x ${x.toFixed(2)}, z ${z.toFixed(2)} m; ${angles}`;
  const there = Object.keys(labels.boxes).length;
  find("state").dataset.label = labels.label;
  find("state").textContent = {
    unlabelled: "not labelled yet",
    proposed: there ? `proposed: ${there} ${there === 1 ? "box" : "boxes"}` : "proposed: nothing here",
    labelled: there ? `labelled: ${there} ${there === 1 ? "box" : "boxes"}` : "labelled: nothing here",
  }[labels.label];
  for (const row of rows) {
    row.classList.toggle("chosen", row.dataset.target === chosen);
    row.classList.toggle("there", row.dataset.target in labels.boxes);
  }
  rows[names.indexOf(chosen)].scrollIntoView({block: "nearest"});
  drawPictures();
  document.querySelector("[data-do=accept]").disabled = labels.label !== "proposed";
  document.querySelector("[data-do=remove]").disabled = !(chosen in labels.boxes);
  document.querySelector("[data-do=undo]").disabled = !changes.done.length;
  document.querySelector("[data-do=redo]").disabled = !changes.undone.length;
  for (const thumbnail of thumbnails) thumbnail.classList.toggle("current", Number(thumbnail.dataset.view) === view);
  thumbnails[view].scrollIntoView({block: "nearest", inline: "center"});
}

function drawPictures() {
  const number = names.indexOf(chosen);
  const box = find("pictures");
  if (box.dataset.target === chosen) return;
  box.dataset.target = chosen;
  find("pictures-title").textContent = `Pictures of ${chosen}`;
  const shown = Math.min(scene.targets[number].pictures, 4);
  box.replaceChildren(...Array.from({length: shown}, (_, picture) =>
    element("img", {src: image(`picture/${number}/${picture}`), alt: `${chosen}, picture ${picture + 1}`})));
}

function drawThumbnail(number) {
  const {label, boxes} = changes.views[number];
  const there = Object.keys(boxes);
  thumbnails[number].dataset.label = label;
  thumbnails[number].querySelector("b").replaceChildren(...there.map((name) => {
    const dot = element("i");
    dot.style.background = colour(name);
    return dot;
  }));
}

function drawCounts() {
  const number = {labelled: 0, proposed: 0, unlabelled: 0};
  const seen = Object.fromEntries(names.map((name) => [name, 0]));
  for (const {label, boxes} of changes.views) {
    number[label] += 1;
    for (const name of Object.keys(boxes)) seen[name] += 1;
  }
  find("counts").replaceChildren(...Object.entries(number).map(([label, many]) => {
    const part = element("span", {}, element("b", {textContent: many}), ` ${label}`);
    part.dataset.label = label;
    return part;
  }));
  find("progress").replaceChildren(...Object.entries(number).map(([label, many]) => {
    const part = element("i");
    part.dataset.label = label;
    part.style.width = `${100 * many / count}%`;
    return part;
  }));
  for (const row of rows) row.querySelector("small").textContent = seen[row.dataset.target] || "–";
  document.querySelector("[data-do=unlabelled]").disabled = !number.unlabelled;
  document.querySelector("[data-do=proposed]").disabled = !number.proposed;
}

function drawKept({kept, text, unsaved}) {
  find("kept").dataset.kept = kept;
  find("kept").textContent = text;
  const saved = !unsaved && kept === "yes";
  const number = unsaved ? ` (${unsaved} ${unsaved === 1 ? "view" : "views"})` : "";
  find("save").textContent = saved ? "Saved" : `Save${number}`;
  find("save").disabled = saved;
  find("save").title = `write into ${scene.file} (Ctrl+S)`;
}

function note(text, kind = "") {
  clearTimeout(noteTimer);
  Object.assign(find("note"), {textContent: text, className: kind, hidden: false});
  noteTimer = setTimeout(() => { find("note").hidden = true; }, kind ? 2500 : 6000);
}

// An image that did not come is asked for again: the server may have been away.
document.addEventListener("error", ({target}) => {
  if (target instanceof HTMLImageElement) setTimeout(() => { target.src = target.src; }, 3000);
}, true);

// ---- beginning --------------------------------------------------------------------------------------------------

document.title = `${scene.name} – labelling`;
find("scene-name").textContent = scene.name;
find("targets").replaceChildren(...rows.map((row) => element("li", {}, row)));
find("strip").replaceChildren(...thumbnails);
for (const button of document.querySelectorAll("[data-do]")) {
  button.append(element("kbd", {textContent: button.dataset.key}));
  button.addEventListener("click", () => actions[button.dataset.do]());
}
find("save").addEventListener("click", () => actions.save());
document.addEventListener("keydown", (event) => {
  if (event.altKey) return;
  const name = `${event.ctrlKey || event.metaKey ? "ctrl+" : ""}${event.ctrlKey && event.shiftKey ? "shift+" : ""}`
    + event.key.toLowerCase();
  const target = /^[1-9]$/.test(name) ? Number(name) - 1 : undefined;
  if (target !== undefined && target < names.length) choose(target);
  else if (KEYS[name]) actions[KEYS[name]]();
  else return;
  event.preventDefault();
});
// A button that was clicked must not take Enter and the like for itself.
document.addEventListener("click", (event) => event.target.closest("button")?.blur());
window.addEventListener("beforeunload", (event) => { if (changes.pending.length) event.preventDefault(); });

for (let number = 0; number < count; number += 1) drawThumbnail(number);
drawCounts();
show();
document.body.dataset.ready = "yes";
