// The view with its boxes: drawing, choosing, moving and resizing them with the mouse.

const CLICK = 4; // pixels: a shorter way of the mouse is a click
const SMALLEST = 3; // pixels of the screen
const SMALL = 48; // pixels of the screen: smaller boxes get handles at their corners only, and outside
const CORNERS = ["nw", "ne", "se", "sw"];
const HANDLES = [...CORNERS, "n", "e", "s", "w"];

const clamp = (value, low = 0, high = 1) => Math.min(high, Math.max(low, value));
const asCorners = ([x, y, width, height]) => [x - width / 2, y - height / 2, x + width / 2, y + height / 2];
const asBox = ([left, top, right, bottom]) => [(left + right) / 2, (top + bottom) / 2, right - left, bottom - top];

export class Stage {
  // colour(name): of a target. onBox(name, box): a box was drawn, moved or resized. onChoose(name).
  constructor(canvas, {colour, onBox, onChoose}) {
    Object.assign(this, {canvas, colour, onBox, onChoose});
    this.layer = canvas.querySelector("#boxes");
    canvas.addEventListener("pointerdown", (event) => this.begin(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.end(event));
    canvas.addEventListener("pointercancel", () => this.cancel());
  }

  // labels: {label, boxes} of the view; chosen: name of the target that is drawn next.
  show(labels, chosen) {
    Object.assign(this, {labels, chosen});
    this.cancel();
  }

  cancel() {
    this.drag = undefined;
    this.draw();
  }

  draw() {
    const shown = {...this.labels.boxes};
    if (this.drag?.corners) shown[this.chosen] = asBox(this.drag.corners);
    // Large ones first, so that small ones within them can be clicked.
    const names = Object.keys(shown).sort((a, b) => shown[b][2] * shown[b][3] - shown[a][2] * shown[a][3]);
    this.layer.replaceChildren(...names.map((name) => this.element(name, shown[name])));
  }

  element(name, box) {
    const [left, top, right, bottom] = asCorners(box);
    const element = document.createElement("div");
    element.className = "box";
    element.dataset.target = name;
    element.classList.toggle("proposed", this.labels.label === "proposed");
    element.classList.toggle("chosen", name === this.chosen);
    element.classList.toggle("at-top", top < 0.05);
    element.classList.toggle("at-right", left > 0.8);
    Object.assign(element.style, {
      left: `${100 * left}%`, top: `${100 * top}%`,
      width: `${100 * (right - left)}%`, height: `${100 * (bottom - top)}%`,
    });
    element.style.setProperty("--colour", this.colour(name));
    const label = document.createElement("span");
    label.textContent = this.labels.label === "proposed" ? `${name}?` : name;
    element.append(label);
    if (name === this.chosen) {
      const frame = this.canvas.getBoundingClientRect();
      const small = Math.min(box[2] * frame.width, box[3] * frame.height) < SMALL;
      element.classList.toggle("small", small);
      for (const handle of small ? CORNERS : HANDLES) {
        const grip = document.createElement("i");
        grip.dataset.handle = handle;
        element.append(grip);
      }
    }
    return element;
  }

  position(event) {
    const frame = this.canvas.getBoundingClientRect();
    return [clamp((event.clientX - frame.left) / frame.width), clamp((event.clientY - frame.top) / frame.height)];
  }

  begin(event) {
    if (event.button !== 0 || !this.labels) return;
    event.preventDefault();
    this.canvas.setPointerCapture(event.pointerId);
    const at = this.position(event);
    const own = this.labels.boxes[this.chosen];
    const handle = event.target.dataset?.handle;
    const corners = own && asCorners(own);
    const inside = corners && at[0] >= corners[0] && at[0] <= corners[2] && at[1] >= corners[1] && at[1] <= corners[3];
    const kind = handle ? "resize" : inside ? "move" : "draw";
    this.drag = {kind, handle, from: at, before: corners, x: event.clientX, y: event.clientY};
  }

  move(event) {
    const {drag} = this;
    if (!drag) return;
    if (!drag.corners && Math.hypot(event.clientX - drag.x, event.clientY - drag.y) < CLICK) return;
    const [x, y] = this.position(event);
    if (drag.kind === "draw") {
      const [x0, y0] = drag.from;
      drag.corners = [Math.min(x, x0), Math.min(y, y0), Math.max(x, x0), Math.max(y, y0)];
    } else if (drag.kind === "move") {
      const [left, top, right, bottom] = drag.before;
      const dx = clamp(x - drag.from[0], -left, 1 - right);
      const dy = clamp(y - drag.from[1], -top, 1 - bottom);
      drag.corners = [left + dx, top + dy, right + dx, bottom + dy];
    } else {
      const corners = [...drag.before];
      if (drag.handle.includes("w")) corners[0] = x;
      if (drag.handle.includes("e")) corners[2] = x;
      if (drag.handle.includes("n")) corners[1] = y;
      if (drag.handle.includes("s")) corners[3] = y;
      const [left, top, right, bottom] = corners; // an edge may be pulled over the opposite one
      drag.corners = [Math.min(left, right), Math.min(top, bottom), Math.max(left, right), Math.max(top, bottom)];
    }
    this.draw();
  }

  end(event) {
    const {drag} = this;
    if (!drag) return;
    this.drag = undefined;
    if (!drag.corners) {
      const name = this.under(drag.from);
      if (name !== undefined && name !== this.chosen) this.onChoose(name);
      return;
    }
    const box = asBox(drag.corners);
    const {width, height} = this.canvas.getBoundingClientRect();
    if (box[2] * width < SMALLEST || box[3] * height < SMALLEST) this.draw();
    else this.onBox(this.chosen, box);
  }

  // The smallest box at a place.
  under([x, y]) {
    const {boxes} = this.labels;
    return Object.keys(boxes)
      .filter((name) => {
        const [left, top, right, bottom] = asCorners(boxes[name]);
        return x >= left && x <= right && y >= top && y <= bottom;
      })
      .sort((a, b) => boxes[a][2] * boxes[a][3] - boxes[b][2] * boxes[b][3])[0];
  }
}
