// The page and its controls.

function preview(why) {
  $("why").textContent = why;
  $("preview").hidden = false;
  $("loading").hidden = true;
  $("canvas").hidden = $("buttons").hidden = true;
  for (const control of $("controls").elements) control.disabled = true;
}

class Page {
  constructor(network) {
    this.network = network;
    this.selected = -1;
    this.isolated = false;
    this.share = overlapShare();
    try {
      this.view = new View($("canvas"), network);
    } catch (error) {
      preview(`Only a picture is shown: ${error.message}.`);
    }
    this.table = new Table(network, (k) => this.pick(k, true));
    this.find();
    if (this.view) {
      this.view.afterDraw = () => this.rings();
      this.controls();
      this.pointer();
      this.keyboard();
      this.paint();
      $("loading").hidden = true;
      $("canvas").addEventListener("webglcontextlost", () => preview("Only a picture is shown: the browser lost its connection to the graphics card. Reload the page to rotate the view."));
      window.addEventListener("fdem-theme", () => this.paint());
    }
  }

  // Colours elements and contacts, and shows the legends.
  paint() {
    if (!this.view) return;
    const { network } = this, by = $("colour-by").value;
    const heat = stops("heat");
    const touched = this.touched();
    const alpha = (k) => (this.selected < 0 || k === this.selected || touched.has(k) ? 255 : this.isolated ? 0 : 128);
    const ofContact = (c) => {
      const mine = this.selected < 0 || network.i[c] === this.selected || network.j[c] === this.selected;
      const alpha = !$("show-contacts").checked ? 0 : mine ? 255 : this.isolated ? 0 : 128;
      return [...ramp(heat, this.share(network.overlap[c])), alpha];
    };
    const element = this.elementColours(by);
    const facet = (k) => (k === this.selected ? ringColour() : meta.bodies?.walls ? (isDark() ? [120, 130, 142] : [150, 160, 172]) : element.of(k));
    this.view.colourFacets((k) => [...facet(k), alpha(k)]);
    this.view.colour((k) => [...(k === this.selected ? ringColour() : element.of(k)), alpha(k)], ofContact, [128, 136, 144, 255]);
    const unit = meta.unit ? ` (${meta.unit})` : "";
    const legends = [];
    if ($("show-elements").checked && network.n) legends.push(legend(element.name, element.stops, element.low, element.high, element.more));
    if ($("show-contacts").checked && meta.overlaps && !($("show-elements").checked && by === "overlap")) {
      const { low, high, largest } = meta.overlaps;
      legends.push(legend(`contacts: ${meta.value}${meta.bodies ? "" : unit}`, heat, low, high, largest > high ? largest : null));
    }
    $("legends").replaceChildren(...legends);
  }

  elementColours(by) {
    const { network } = this, unit = meta.unit ? ` (${meta.unit})` : "";
    const heat = stops("heat"), sea = stops("sea"), alone = isDark() ? DARK_ALONE : meta.alone;
    if (by === "size") {
      const [low, high] = meta.sizes ?? [0, 0];
      const share = (k) => (high > low ? (network.radius(k) - low) / (high - low) : 0.5);
      return { name: `radius${unit}`, stops: sea, low, high, more: null, of: (k) => ramp(sea, share(k)) };
    }
    if (by === "overlap") {
      const { low, high, largest } = meta.overlaps ?? { low: 0, high: 0, largest: 0 };
      const of = (k) => (network.coordination(k) ? ramp(heat, this.share(network.largest[k])) : alone);
      return { name: `largest ${meta.value}${meta.bodies ? "" : unit}`, stops: heat, low, high, more: largest > high ? largest : null, of };
    }
    const { high, largest } = meta.counts;
    const of = (k) => {
      const count = network.coordination(k);
      return count ? ramp(sea, (count - 1) / (Math.max(high, 2) - 1)) : alone;
    };
    return { name: `contacts of ${meta.noun}${meta.alone_count ? " (grey: none)" : ""}`, stops: sea, low: 1, high: Math.max(high, 1), more: largest > high ? largest : null, of };
  }

  touched() {
    const { network, selected } = this;
    const others = new Set();
    if (selected >= 0) {
      for (let at = network.starts[selected]; at < network.starts[selected + 1]; at++) {
        const c = network.contacts[at];
        others.add(network.i[c] === selected ? network.j[c] : network.i[c]);
      }
    }
    return others;
  }

  // Selects element k, or none if k is -1.
  pick(k, bring = false) {
    this.selected = k;
    this.describe();
    this.table.mark(k);
    $("clear").disabled = k < 0;
    $("zoom-to").disabled = k < 0 || !this.view;
    $("find-id").value = k < 0 ? "" : this.network.id(k);
    $("find-id").setCustomValidity("");
    if (this.view && k >= 0 && bring) {
      const [x, y] = this.view.project(k), { clientWidth, clientHeight } = this.view.canvas;
      if (x < 0 || y < 0 || x > clientWidth || y > clientHeight) this.view.move(clientWidth / 2 - x, clientHeight / 2 - y);
    }
    this.paint();
  }

  // Zooms to the selected element and its neighbourhood.
  zoomTo() {
    if (this.view && this.selected >= 0) this.view.focus(this.selected);
  }

  describe() {
    const { network, selected: k } = this;
    const unit = meta.unit ? ` ${meta.unit}` : "";
    const make = (name, text, ...inside) => {
      const made = document.createElement(name);
      made.append(...(text === null ? inside : [text]));
      return made;
    };
    if (k < 0) {
      const hint = make("p", `Click ${meta.noun}, or type its id.`);
      hint.className = "hint";
      $("picked").replaceChildren(hint);
      return;
    }
    const count = network.coordination(k);
    const facts = [
      ["id", network.id(k)],
      ["centre", ["x", "y", "z"].slice(0, network.d).map((_, axis) => network.at(k, axis)).join(", ") + unit],
      [meta.cutoff === null ? "radius" : "cut-off", (meta.cutoff === null ? network.radius(k) : meta.cutoff) + unit],
      ["contacts", String(count)],
    ].filter(([name]) => !(meta.bodies && name === "radius" && network.radius(k) === 0));
    const list = make("dl", null, ...facts.flatMap(([name, text]) => {
      const value = make("dd", text);
      value.dataset.fact = name;
      return [make("dt", name), value];
    }));
    const parts = [list];
    if (count) {
      const table = document.createElement("table");
      table.append(make("caption", meta.bodies ? "contacts" : tableCaption()));
      const heads = ["id", ...network.columns.map(({ name }) => name), ...(network.shift ? ["shift"] : [])];
      table.append(make("thead", null, make("tr", null, ...heads.map((name) => {
        const head = make("th", name);
        head.scope = "col";
        return head;
      }))));
      const rows = [];
      // A large element may have thousands of contacts, but the list is for reading.
      const most = 500;
      for (let at = network.starts[k]; at < network.starts[k + 1] && rows.length < most; at++) {
        const c = network.contacts[at], first = network.i[c] === k, other = first ? network.j[c] : network.i[c];
        const cells = [make("td", null, elementButton(network, other, (next) => this.pick(next, true))), ...network.columns.map(({ of }) => make("td", String(of(c))))];
        if (network.shift) cells.push(make("td", Array.from(network.shift.subarray(network.d * c, network.d * (c + 1)), (x) => (first ? x : -x) + 0).join(" ")));
        rows.push(make("tr", null, ...cells));
      }
      table.append(make("tbody", null, ...rows));
      parts.push(table);
      if (count > most) parts.push(make("p", `and ${grouped(count - most)} more`));
    }
    $("picked").replaceChildren(...parts);
    $("picked").scrollTop = 0;
  }

  // Draws rings around the selected element and its neighbours, also where other elements hide them.
  rings() {
    const { view, selected } = this;
    const rings = [];
    if (selected >= 0) {
      // More rings could not be distinguished, and would take seconds.
      const most = 600, size = view.visible.elements ? view.size : 0.3;
      for (const k of [...[...this.touched()].slice(0, most), selected]) {
        if (!view.shown(k) || (meta.bodies && view.radii[k] === 0)) continue;
        const [x, y] = view.project(k), mine = k === selected;
        const r = Math.max(view.radii[k] * size * view.scale, 2) + (mine ? 2 : 1);
        rings.push(svg("circle", { cx: x.toFixed(1), cy: y.toFixed(1), r: r.toFixed(1), class: mine ? "mine" : "neighbour" }));
        if (mine) rings.push(svg("text", { x: (x + r * 0.75 + 5).toFixed(1), y: (y - r * 0.75 - 4).toFixed(1) }, this.network.id(k)));
      }
    }
    $("overlay").replaceChildren(...rings);
  }

  find() {
    $("find").addEventListener("submit", (event) => {
      event.preventDefault();
      const field = $("find-id"), text = field.value.trim(), k = this.network.find(text);
      if (k >= 0) this.pick(k, true);
      else {
        field.setCustomValidity(text ? `There is no ${meta.nouns[0]} ${text}` : `Type the id of ${meta.noun}`);
        field.reportValidity();
      }
    });
    $("find-id").addEventListener("input", () => $("find-id").setCustomValidity(""));
    $("clear").addEventListener("click", () => this.pick(-1));
    $("zoom-to").addEventListener("click", () => this.zoomTo());
    $("isolate").addEventListener("change", () => {
      this.isolated = $("isolate").checked;
      this.paint();
    });
    document.addEventListener("keydown", (event) => { if (event.key === "Escape" && this.selected >= 0) this.pick(-1); });
  }

  controls() {
    const { view } = this;
    $("controls").addEventListener("submit", (event) => event.preventDefault());
    for (const name of ["elements", "contacts"]) {
      $(`show-${name}`).addEventListener("change", (event) => {
        view.visible[name] = event.target.checked;
        this.paint();
      });
    }
    $("colour-by").addEventListener("change", () => this.paint());
    $("surfaces")?.addEventListener("change", () => {
      view.surfaces = Number($("surfaces").value);
      view.redraw();
    });
    $("size").addEventListener("input", () => {
      view.size = $("size").value / 100;
      $("size-text").textContent = `${$("size").value} %`;
      view.redraw();
    });
    const clip = () => {
      const axis = $("clip-axis").value, off = axis === "none";
      $("clip").disabled = $("clip-flip").disabled = off;
      if (off) {
        view.plane = [0, 0, 0, 1e9];
        $("clip-text").textContent = "–";
      } else {
        const k = Number(axis), x = view.low[k] + ($("clip").value / 1000) * (view.high[k] - view.low[k]);
        const sign = $("clip-flip").checked ? -1 : 1;
        view.plane = [0, 1, 2].map((other) => (other === k ? sign : 0)).concat((sign * (x - view.middle[k])) / view.unit);
        $("clip-text").textContent = `${["x", "y", "z"][k]} = ${brief(x)}${meta.unit ? ` ${meta.unit}` : ""}`;
      }
      view.redraw();
    };
    for (const id of ["clip-axis", "clip", "clip-flip"]) $(id).addEventListener("input", clip);
    $("zoom-in").addEventListener("click", () => view.zoom(1.25));
    $("zoom-out").addEventListener("click", () => view.zoom(0.8));
    $("reset").addEventListener("click", () => view.home());
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
      if (down.size === 1) travelled = 0;
      else travelled = Infinity;
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
      } else if (travelled > 3) {
        if (meta.dimensions === 2 || event.shiftKey || event.buttons & 6) view.move(dx, dy);
        else view.rotate(-dx * 0.008, dy * 0.008);
      }
      down.set(event.pointerId, now);
    });
    const up = (event) => {
      const started = down.delete(event.pointerId);
      if (started && event.type === "pointerup" && travelled <= 3 && event.button === 0) this.pick(view.pick(...point(event)));
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("dblclick", () => this.zoomTo());
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
      const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
      const arrow = arrows[event.key];
      if (arrow && (event.shiftKey || meta.dimensions === 2)) view.move(40 * arrow[0], 40 * arrow[1]);
      else if (arrow) view.rotate(-arrow[0] * 0.12, arrow[1] * 0.12);
      else if (event.key === "+" || event.key === "=") view.zoom(1.25);
      else if (event.key === "-" || event.key === "_") view.zoom(0.8);
      else if (event.key === "z" || event.key === "Z") this.zoomTo();
      else if (event.key === "r" || event.key === "R" || event.key === "Home") view.home();
      else return;
      event.preventDefault();
    });
  }
}

// Colour of elements without contact on a dark background.
const DARK_ALONE = [84, 91, 99];

// The colours of a ramp from small to large: pale to dark on a pale background. On a dark background the order is reversed, so that large values stand out,
// and the darkest colours are left out.
function stops(ramp) {
  return isDark() ? meta[ramp].slice(0, 13).reverse() : meta[ramp];
}

function ringColour() {
  const text = getComputedStyle(document.documentElement).getPropertyValue("--ring").trim();
  return [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16));
}

function legend(name, stops, low, high, more) {
  const made = document.createElement("div"), bar = document.createElement("div"), ends = document.createElement("div");
  made.className = "legend";
  bar.className = "bar";
  ends.className = "ends";
  const one = !(high > low);
  bar.style.background = one ? `rgb(${ramp(stops, low === 1 ? 0 : 0.5).join(" ")})` : `linear-gradient(to right, ${stops.map((rgb) => `rgb(${rgb.join(" ")})`).join(", ")})`;
  const counts = Number.isInteger(low) && Number.isInteger(high);
  const texts = one ? alike([low]) : counts ? [low, high].map(grouped) : alike([low, low + (high - low) / 2, high]);
  if (!one && more !== null) texts[texts.length - 1] += "+";
  for (const text of texts) {
    const end = document.createElement("span");
    end.textContent = text;
    ends.append(end);
  }
  const head = document.createElement("div");
  head.textContent = name + (more === null ? "" : `, largest ${alike([more])[0]}`);
  made.append(head, bar, ends);
  return made;
}

theme();
if (!meta.facets) $("surfaces-label").remove();
else $("surfaces").value = meta.bodies.walls ? "0.3" : "1";
for (const part of document.querySelectorAll(meta.dimensions === 2 ? "[data-only-3d]" : "[data-only-2d]")) part.remove();
openNetwork().then((network) => {
  const page = new Page(network);
  // For the console and tests: position of element k on the page, selection, state of the view, number of visible elements, time of a frame at full resolution.
  window.fdem = {
    project: (k) => {
      const box = page.view.canvas.getBoundingClientRect(), [x, y] = page.view.project(k);
      return [box.left + x, box.top + y];
    },
    pick: (k) => page.pick(k, true),
    picked: () => page.selected,
    state: () => page.view && { yaw: page.view.yaw, pitch: page.view.pitch, scale: page.view.scale, pan: page.view.pan },
    shown: () => Array.from({ length: network.n }, (_, k) => page.view.shown(k)).filter(Boolean).length,
    frame: () => {
      const start = performance.now(), { gl } = page.view;
      page.view.draw(1);
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      return performance.now() - start;
    },
  };
  document.documentElement.dataset.ready = "true";
}).catch((error) => {
  preview(`Only a picture is shown: ${error.message}.`);
  document.documentElement.dataset.ready = "failed";
});

// The unit of lengths is known, that of forces is not.
function tableCaption() {
  const unit = meta.unit ? ` in ${meta.unit}` : "";
  return meta.value === "overlap" ? `distance and overlap${unit}` : `distance${unit} and ${meta.value}`;
}
