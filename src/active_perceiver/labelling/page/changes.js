// What is known of every view, undo and redo, and keeping every change: it is posted at once and again until the
// server says that it is kept. What is not yet kept survives a reload of the page.

const RETRY = 1000; // ms
const ANSWER_WITHIN = 10000; // ms
const LONGEST_HISTORY = 500;

const same = (one, other) => JSON.stringify(sorted(one)) === JSON.stringify(sorted(other));
const sorted = ({label, boxes}) => [label, Object.keys(boxes).sort().map((name) => [name, boxes[name]])];

export class Changes {
  // scene: what /api/scene gives. onChange(view): a view is different now. onKept({kept, text, unsaved}): how keeping
  // goes; kept is "yes", "busy" or "no". onNote(text): something that the person should know.
  constructor(scene, {onChange, onKept, onNote}) {
    Object.assign(this, {scene, onChange, onKept, onNote});
    this.views = scene.views;
    this.unsaved = scene.unsaved;
    this.storageKey = `labelling ${scene.id}`;
    const stored = JSON.parse(sessionStorage.getItem(this.storageKey) ?? "{}");
    this.done = stored.done ?? []; // {view, before, after}, the last one is undone first
    this.undone = stored.undone ?? [];
    this.pending = stored.pending ?? []; // not yet kept
    for (const {view, after} of this.pending) this.views[view] = after;
    this.post();
  }

  change(view, after) {
    const before = this.views[view];
    if (same(before, after)) return;
    this.done.push({view, before, after});
    this.done.splice(0, this.done.length - LONGEST_HISTORY);
    this.undone = [];
    this.put(view, before, after);
  }

  // Each gives the number of the view that it changed, or undefined if there is nothing to undo or redo.
  undo() { return this.step(this.done, this.undone, "after", "before"); }
  redo() { return this.step(this.undone, this.done, "before", "after"); }

  step(from, to, now, then) {
    while (from.length) {
      const entry = from.pop();
      if (!same(this.views[entry.view], entry[now])) continue; // changed by another page meanwhile
      to.push(entry);
      this.put(entry.view, entry[now], entry[then]);
      return entry.view;
    }
    return undefined;
  }

  put(view, before, after) {
    this.views[view] = after;
    this.pending.push({view, before, after});
    this.store();
    this.onChange(view);
    this.post();
  }

  store() {
    const {done, undone, pending} = this;
    try {
      sessionStorage.setItem(this.storageKey, JSON.stringify({done, undone, pending}));
    } catch { /* the browser has no room for it: nothing but a reload would need it */ }
  }

  async post() {
    if (this.posting) return;
    this.posting = true;
    while (this.pending.length) {
      const change = this.pending[0];
      this.onKept({kept: this.failing ? "no" : "busy", text: this.failing ?? "keeping …", unsaved: this.unsaved});
      const {status, body} = await send("/api/change", {scene: this.scene.id, ...change});
      if (status === 200) {
        this.failing = undefined;
        this.unsaved = body.unsaved;
        this.pending.shift();
      } else if (status === 409) { // another page was there first
        this.failing = undefined;
        this.views[change.view] = body.current;
        this.pending = this.pending.filter(({view}) => view !== change.view);
        this.onChange(change.view);
        this.onNote(body.error);
      } else if (status === 400) { // asking again would not help
        this.pending.shift();
        this.views[change.view] = change.before;
        this.onChange(change.view);
        this.onNote(`not kept: ${body.error}`);
      } else {
        this.failing = `not kept: ${body.error}; trying again`;
        this.onKept({kept: "no", text: this.failing, unsaved: this.unsaved});
        await new Promise((resolve) => { setTimeout(resolve, RETRY); });
      }
      this.store();
    }
    this.posting = false;
    this.onKept({kept: "yes", text: "every change is kept", unsaved: this.unsaved});
    this.settled?.();
  }

  // Put all changes into the scene file; what is still on its way is waited for.
  async save() {
    if (this.posting) await new Promise((resolve) => { this.settled = resolve; });
    const {status, body} = await send("/api/save", {scene: this.scene.id}, 10 * ANSWER_WITHIN);
    if (status === 200) {
      this.unsaved = body.unsaved;
      this.onKept({kept: "yes", text: "every change is kept", unsaved: this.unsaved});
      const views = body.saved === 1 ? "view" : "views";
      this.onNote(body.saved ? `saved: ${body.saved} changed ${views}` : "there was nothing to save", "good");
    } else {
      this.onNote(`not saved: ${body.error}`);
    }
  }
}

async function send(path, value, within = ANSWER_WITHIN) {
  try {
    const answer = await fetch(path, {
      method: "POST",
      headers: {"Content-Type": "application/json"},
      body: JSON.stringify(value),
      signal: AbortSignal.timeout(within),
      keepalive: true, // goes on when the page is closed
    });
    return {status: answer.status, body: await answer.json()};
  } catch {
    return {status: 0, body: {error: "the server does not answer"}};
  }
}
