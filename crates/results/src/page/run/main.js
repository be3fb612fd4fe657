// The page and its controls, in two and in three dimensions. `start` at the end begins.

function preview(why) {
  $("why").textContent = why;
  $("preview").hidden = false;
  $("loading").hidden = true;
  $("canvas").hidden = $("buttons").hidden = $("player").hidden = true;
  for (const form of [$("controls"), $("find")]) for (const control of form.elements) control.disabled = true;
}

const make = (name, text, attributes = {}) => {
  const made = document.createElement(name);
  made.textContent = text;
  for (const key in attributes) made.setAttribute(key, attributes[key]);
  return made;
};

class Page {
  constructor(view, frames) {
    Object.assign(this, { view, frames, selected: -1, shown: null, wanted: 0, playing: false });
    view.afterDraw = () => this.ring();
    this.spheres = meta.spheres ? new SphereControls(this) : null;
    this.controls();
    this.player();
    this.pointer();
    this.keyboard();
    this.find();
    window.addEventListener("fdem-theme", () => view.redraw());
    $("canvas").addEventListener("webglcontextlost", () => preview("Only a picture is shown: the browser lost its connection to the graphics card. Reload the page to play the run."));
  }

  // Shows frame k; resolves when it is shown, or when another frame was requested.
  async show(k) {
    this.wanted = Math.max(0, Math.min(this.frames.count - 1, k));
    const about = meta.frames[this.wanted];
    $("frame").value = this.wanted;
    const [factor, unit] = prefixed("s", meta.last);
    const digits = meta.last * factor >= 100 ? 1 : meta.last * factor >= 10 ? 2 : 3;
    const when = `${(about.time * factor).toFixed(digits)} ${unit}, step ${grouped(about.step)}`;
    $("when").textContent = when;
    $("frame").setAttribute("aria-valuetext", `frame ${this.wanted + 1} of ${this.frames.count}, ${when}`);
    $("previous").disabled = this.wanted === 0;
    $("next").disabled = this.wanted === this.frames.count - 1;
    const mine = this.wanted, frame = await this.frames.get(mine);
    if (this.wanted !== mine) return;
    this.shown = frame;
    this.paint();
    this.describe();
    document.querySelectorAll("#table-body tr").forEach((row, at) => (at === mine ? row.setAttribute("aria-current", "true") : row.removeAttribute("aria-current")));
    this.time(about.time);
    // Decompresses the next frame in advance.
    if (mine + 1 < this.frames.count) this.frames.get(mine + 1).catch(() => {});
  }

  // Moves the cursors of the plots over time.
  time(time) {
    for (const cursor of document.querySelectorAll(".plots .cursor")) {
      const x = Number(cursor.dataset.zero) + time * Number(cursor.dataset.rate);
      cursor.setAttribute("x1", x);
      cursor.setAttribute("x2", x);
      cursor.setAttribute("visibility", "visible");
    }
  }

  field() {
    return meta.fields[$("field").selectedIndex];
  }

  range(field) {
    if (field.fixed || $("range").value === "series") return field.range;
    const [low, high] = this.shown.about.usual[field.scale];
    if (field.signed) {
      const most = Math.max(high, -low) || 1;
      return [-most, most];
    }
    return [0, high || 1];
  }

  crackColour(mode) {
    return meta.cracks[mode].colour;
  }

  // Returns a colour for each element.
  colours(frame, field) {
    const n = frame.about.elements, colours = new Uint32Array(n);
    if (field.scale === null) {
      const numbers = frame[field.key], table = meta.numbered.map(packedColour);
      for (let k = 0; k < n; k++) colours[k] = table[numbers[k] % table.length];
      return colours;
    }
    const [low, high] = this.range(field), table = Array.from({ length: 512 }, (_, k) => packedColour(ramp(field.ramp, k / 511))), none = packedColour(meta.none);
    const [least, most] = frame.about.scales[field.scale], places = frame.scales[field.scale];
    const step = (511 * (most - least)) / STEPS / (high - low), start = (511 * (least - low)) / (high - low);
    for (let k = 0; k < n; k++) {
      const at = places[k] === NOWHERE ? -1 : Math.max(0, Math.min(511, Math.round(start + places[k] * step)));
      colours[k] = at < 0 ? none : table[at];
    }
    return colours;
  }

  // Sets the colours of elements and cracks, and the legends.
  paint() {
    const frame = this.shown, field = this.field();
    if (!frame) return;
    this.view.show(frame, this.colours(frame, field));
    this.spheres?.paint();
    this.legends(field);
  }

  // The legend of a field with a scale.
  bar(field, [low, high], before = "") {
    const [factor, unit] = prefixed(field.unit, Math.max(high, -low));
    const box = make("div", "", { class: "legend" }), bar = make("div", "", { class: "bar" }), ends = make("div", "", { class: "ends" });
    bar.style.background = `linear-gradient(to right, ${field.ramp.map((rgb) => `rgb(${rgb.join(" ")})`).join(", ")})`;
    ends.append(...[low, (low + high) / 2, high].map((x) => make("span", brief(Number((x * factor).toPrecision(3))))));
    box.append(make("div", before + field.name + (unit ? ` (${unit})` : "")), bar, ends);
    return box;
  }

  legends(field) {
    const legends = [];
    if (field.scale !== null && (meta.elements || !this.spheres)) legends.push(this.bar(field, this.range(field)));
    legends.push(...(this.spheres?.legends() ?? []));
    const { broken } = this.shown.about, { cracks, intact } = this.view.visible;
    // The last two of the sizes are those of the joints that hold: whole ones, and those that soften.
    const shown = broken.map((size, kind) => (kind < broken.length - 2 ? cracks : intact) && size > 0);
    if (shown.some((yes) => yes)) {
      const box = make("div", "", { class: "legend" }), list = make("div", "", { class: "cracks" });
      meta.cracks.forEach(({ name }, mode) => {
        if (!shown[mode]) return;
        const item = make("span", ""), sample = make("i", "");
        sample.style.background = `rgb(${this.crackColour(mode).join(" ")})`;
        item.append(sample, `${name} ${quantity(broken[mode], meta.measure, 3)}`);
        list.append(item);
      });
      box.append(make("div", shown.slice(0, 3).some((yes) => yes) ? "cracks" : "joints"), list);
      legends.push(box);
    }
    $("legends").replaceChildren(...legends);
  }

  // Selects element k, or none if k is -1.
  pick(k) {
    this.selected = k;
    this.spheres?.select(-1);
    this.picked(k);
  }

  // Selects the sphere at place i of the frame.
  pickSphere(i) {
    this.selected = -1;
    this.spheres.select(i);
    this.picked(this.spheres.selected);
  }

  // Shows the number that is selected.
  picked(number) {
    $("clear").disabled = number < 0;
    $("find-id").value = number < 0 ? "" : number;
    $("find-id").setCustomValidity("");
    this.describe();
    this.view.redraw();
  }

  describe() {
    const frame = this.shown;
    if (frame && this.spheres?.describe()) return;
    if (this.selected < 0 || !frame) {
      const what = !this.spheres ? "an element" : meta.elements ? `an element or a ${meta.spheres.one}` : `a ${meta.spheres.one}`;
      $("picked").replaceChildren(make("p", `Click ${what}, or enter its number (from 0).`, { class: "hint" }));
      return;
    }
    const k = frame.place(this.selected);
    if (k < 0) {
      $("picked").replaceChildren(make("p", `Element ${grouped(this.selected)} is not ${meta.missing}.`, { class: "hint" }));
      return;
    }
    const list = document.createElement("dl");
    const add = (name, text) => list.append(make("dt", name), make("dd", text, { "data-fact": name }));
    add("element", grouped(this.selected));
    add("body", meta.bodies[frame.body[k]] ?? String(frame.body[k]));
    add("material", meta.materials[frame.material[k]] ?? String(frame.material[k]));
    if (frame.fragment) add("fragment", grouped(frame.fragment[k]));
    this.view.centroid(k).forEach((x, axis) => add(["x", "y", "z"][axis], quantity(x * meta.view.unit + meta.view.middle[axis], "m")));
    for (const field of meta.fields) if (field.scale !== null) add(field.name, quantity(frame.value(field.scale, k), field.unit));
    for (const [name, text] of frame.more?.(k) ?? []) add(name, text);
    $("picked").replaceChildren(list, make("p", "Values in this frame, rounded to 1/65,534 of their range in the frame.", { class: "scale" }));
  }

  // Draws the outline of the selected element.
  ring() {
    const parts = [];
    const k = this.selected >= 0 && this.view.frame ? this.view.frame.place(this.selected) : -1;
    if (k >= 0) {
      for (const corners of this.view.around(k)) parts.push(svg("polygon", { points: corners.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ") }));
    }
    parts.push(...(this.spheres?.ring() ?? []));
    $("overlay").replaceChildren(...parts, ...(this.view.furniture?.() ?? []));
  }

  controls() {
    const { view } = this;
    $("controls").addEventListener("submit", (event) => event.preventDefault());
    for (const id of ["field", "range"]) $(id).addEventListener("change", () => this.paint());
    for (const name of ["cracks", "intact", "outlines", "mesh"]) {
      $(`show-${name}`).addEventListener("change", (event) => {
        view.visible[name] = event.target.checked;
        this.paint();
      });
    }
    $("show-intact").parentElement.hidden = !meta.frames.some((about) => about.holding.some((count) => count > 0));
    $("zoom-in").addEventListener("click", () => view.zoom(1.25));
    $("zoom-out").addEventListener("click", () => view.zoom(0.8));
    $("reset").addEventListener("click", () => view.home());
  }

  player() {
    $("play").addEventListener("click", () => this.play(!this.playing));
    $("previous").addEventListener("click", () => this.go(this.wanted - 1));
    $("next").addEventListener("click", () => this.go(this.wanted + 1));
    $("frame").addEventListener("input", () => this.go(Number($("frame").value)));
    for (const button of document.querySelectorAll("#table-body button")) {
      button.addEventListener("click", () => {
        this.go(Number(button.dataset.frame));
        $("canvas").scrollIntoView({ block: "center" });
      });
    }
  }

  // Shows a frame and stops playing.
  go(k) {
    this.play(false);
    return this.show(k);
  }

  play(on) {
    if (on === this.playing) return;
    this.playing = on;
    $("play").textContent = on ? "Pause" : "Play";
    if (!on) return;
    // At the end, playing starts again from the first frame.
    let restart = this.wanted === this.frames.count - 1, before = -Infinity;
    const mine = (this.turns = (this.turns ?? 0) + 1);
    const turn = async (now) => {
      if (!this.playing || this.turns !== mine) return;
      if (now - before >= 1000 / Number($("speed").value) - 4) {
        before = now;
        if (!restart && this.wanted === this.frames.count - 1) this.play(false);
        else await this.show(restart ? 0 : this.wanted + 1);
        restart = false;
      }
      requestAnimationFrame(turn);
    };
    requestAnimationFrame(turn);
  }

  pointer() {
    const { view } = this, { canvas } = view;
    const down = new Map();
    let travelled = 0;
    const point = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      down.set(event.pointerId, point(event));
      travelled = down.size === 1 ? 0 : Infinity;
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = down.get(event.pointerId);
      if (!before) return;
      const now = point(event), [dx, dy] = [now[0] - before[0], now[1] - before[1]];
      travelled += Math.hypot(dx, dy);
      if (down.size === 2) {
        const other = [...down].find(([id]) => id !== event.pointerId)[1];
        const apart = (a) => Math.hypot(a[0] - other[0], a[1] - other[1]);
        view.move(dx / 2, dy / 2);
        if (apart(before) > 0) view.zoom(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
      } else if (travelled > 3) view.drag(dx, dy, event.shiftKey || (event.buttons & 6) !== 0);
      down.set(event.pointerId, now);
    });
    const up = (event) => {
      const started = down.delete(event.pointerId);
      if (!started || event.type !== "pointerup" || travelled > 3 || event.button !== 0) return;
      const at = point(event), found = this.shown ? view.pick(...at) : -1, sphere = this.shown && this.spheres ? view.pickSphere(...at) : -1;
      if (sphere >= 0) this.pickSphere(sphere);
      else this.pick(this.shown ? this.shown.number(found) : -1);
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const pixels = event.deltaY * (event.deltaMode === 1 ? 16 : 1);
      view.zoom(Math.exp(-Math.max(-240, Math.min(240, pixels)) * 0.0016), ...point(event));
    }, { passive: false });
  }

  keyboard() {
    const { view } = this;
    view.canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
      if (arrow) view.arrow(arrow, event.shiftKey);
      else if (event.key === " ") this.play(!this.playing);
      else if (event.key === "," || event.key === "PageUp") this.go(this.wanted - 1);
      else if (event.key === "." || event.key === "PageDown") this.go(this.wanted + 1);
      else if (event.key === "+" || event.key === "=") view.zoom(1.25);
      else if (event.key === "-" || event.key === "_") view.zoom(0.8);
      else if (event.key === "r" || event.key === "R" || event.key === "Home") view.home();
      else return;
      event.preventDefault();
    });
    document.addEventListener("keydown", (event) => { if (event.key === "Escape" && (this.selected >= 0 || this.spheres?.selected >= 0)) this.pick(-1); });
  }

  find() {
    $("find").addEventListener("submit", (event) => {
      event.preventDefault();
      const field = $("find-id"), text = field.value.trim().replaceAll(",", ""), k = Number(text);
      // Without elements the numbers are those of spheres.
      const sphere = /^\d+$/.test(text) && !meta.elements && this.spheres?.shown ? this.spheres.shown.place(k) : -1;
      if (/^\d+$/.test(text) && k < meta.elements) this.pick(k);
      else if (sphere >= 0) this.pickSphere(sphere);
      else {
        field.setCustomValidity(meta.elements ? `Elements have numbers from 0 to ${meta.elements - 1}` : this.spheres ? `This frame has no ${meta.spheres.one} with this number` : "There are no elements");
        field.reportValidity();
      }
    });
    $("find-id").addEventListener("input", () => $("find-id").setCustomValidity(""));
    $("clear").addEventListener("click", () => this.pick(-1));
  }
}

// Begins with a kind of page. `more` returns what else the console and tests can ask for.
async function start(Kind, more = () => ({})) {
  theme();
  let view;
  try {
    view = new View($("canvas"));
  } catch (error) {
    preview(`Only a picture is shown: ${error.message}.`);
    return;
  }
  const page = new Kind(view, new Frames());
  // The last frame is shown first. Without frames there is nothing to play.
  if (page.frames.count) await page.show(page.frames.count - 1);
  else for (const control of $("player").querySelectorAll("button, input, select")) control.disabled = true;
  if (page.frames.count === 1) $("play").disabled = $("frame").disabled = true;
  $("loading").hidden = true;
  // For the console and for tests: position of the element at place k on the page, the selected element, the element at place k, the state, a function that shows a
  // frame, and the time of a redraw.
  window.fdem = {
    project: (k) => {
      const box = view.canvas.getBoundingClientRect(), [x, y] = view.project(view.centroid(k));
      return [box.left + x, box.top + y];
    },
    picked: () => page.selected,
    number: (k) => view.frame.number(k),
    state: () => ({ frame: page.shown?.k ?? -1, wanted: page.wanted, playing: page.playing, pan: view.pan, zoomed: view.zoomed }),
    show: (k) => page.go(k),
    time: () => {
      const start = performance.now();
      page.paint();
      view.draw();
      view.gl.readPixels(0, 0, 1, 1, view.gl.RGBA, view.gl.UNSIGNED_BYTE, new Uint8Array(4));
      return performance.now() - start;
    },
    // The spheres of the frame: their number, the place of one on the page, its number, the selected number, and the counts of lines and triangles.
    // Time of a drawing alone, without new colours.
    drawTime: () => {
      const start = performance.now();
      view.draw();
      view.gl.readPixels(0, 0, 1, 1, view.gl.RGBA, view.gl.UNSIGNED_BYTE, new Uint8Array(4));
      return performance.now() - start;
    },
    ...(page.spheres && {
      spheres: () => ({ count: page.spheres.shown?.n ?? 0, chains: view.grains.chains.count, walls: page.spheres.shown?.owners.length ?? 0 }),
      sphereAt: (i) => {
        const box = view.canvas.getBoundingClientRect(), [x, y] = view.project(page.spheres.shown.centre(i));
        return [box.left + x, box.top + y, view.grains.radiusOf(i) * view.scale];
      },
      sphereNumber: (i) => page.spheres.shown.numbers[i],
      pickedSphere: () => page.spheres.selected,
    }),
    ...more(page, view),
  };
}

const run = (...kind) => start(...kind).then(() => { document.documentElement.dataset.ready = "true"; }, (error) => {
  preview(`Only a picture is shown: ${error.message}.`);
  document.documentElement.dataset.ready = "failed";
});
