// The page of a run in three dimensions.

// The colour of cracks in tension on a dark background, where their usual colour is not seen.
const DARK_TENSION = [203, 213, 225];

class SpacePage extends Page {
  constructor(view, frames) {
    super(view, frames);
    view.modeColour = (mode) => this.crackColour(mode);
    window.addEventListener("fdem-theme", () => this.paint());
  }

  crackColour(mode) {
    return mode === 0 && isDark() ? DARK_TENSION : meta.cracks[mode].colour;
  }

  controls() {
    super.controls();
    const { view } = this;
    $("solid").addEventListener("change", () => {
      view.solid = $("solid").value;
      view.redraw();
    });
    for (const id of ["cut-axis", "cut-here"]) {
      $(id).addEventListener(id === "cut-axis" ? "change" : "click", () => {
        this.direct();
        this.cut();
      });
    }
    for (const id of ["cut", "cut-flip"]) $(id).addEventListener("input", () => this.cut());
    $("explode").addEventListener("input", () => {
      view.exploded = $("explode").value / 50;
      $("explode-text").textContent = `${$("explode").value} %`;
      view.changed();
    });
  }

  // Chooses the direction of the cut such that the section is seen.
  direct() {
    const axis = $("cut-axis").value, toward = this.view.turn()[2];
    this.normal = axis === "view" ? toward : [0, 1, 2].map((other) => (String(other) === axis ? (toward[other] < 0 ? -1 : 1) : 0));
    $("cut-flip").checked = false;
  }

  // Sets the plane of the cut.
  cut() {
    const { view } = this, axis = $("cut-axis").value, off = axis === "none";
    $("cut-place").hidden = off;
    $("cut-here").hidden = axis !== "view";
    if (off) view.setPlane(NOWHERE_CUT);
    else {
      const { normal } = this, reach = meta.view.half.reduce((sum, half, k) => sum + Math.abs(normal[k]) * half, 0);
      // The slider goes along the axis, whichever side is cut away.
      const back = axis !== "view" && normal[Number(axis)] < 0 ? -1 : 1;
      const far = back * ($("cut").value / 500 - 1) * reach * 1.0001, sign = $("cut-flip").checked ? -1 : 1;
      const place = axis === "view" ? far * meta.view.unit : back * far * meta.view.unit + meta.view.middle[Number(axis)];
      $("cut-text").textContent = `${axis === "view" ? "distance from the middle" : "xyz"[axis]} = ${quantity(place, "m", 4)}`;
      $("cut").setAttribute("aria-valuetext", $("cut-text").textContent);
      view.setPlane([...normal.map((x) => sign * x), sign * far]);
    }
    this.tellInside();
  }

  // Says where the inside is missing.
  tellInside() {
    $("cut-open").hidden = $("cut-axis").value === "none" || !this.shown || this.shown.solid;
  }

  describe() {
    super.describe();
    this.tellInside();
    const count = this.shown?.about.fragments ?? 0;
    $("fragments").textContent = count === 1 ? "1 piece" : `${grouped(count)} pieces`;
    if (!this.listed && this.shown) this.listBodies();
  }

  listBodies() {
    this.listed = true;
    const { view } = this, bodies = [...new Set([...this.shown.body, ...meta.bodies.keys()])].sort((a, b) => a - b);
    const boxes = bodies.map((body) => {
      const label = make("label", "", { class: "check" }), box = make("input", "", { type: "checkbox", "data-body": body });
      box.checked = true;
      box.addEventListener("change", () => {
        if (box.checked) view.hiddenBodies.delete(body);
        else view.hiddenBodies.add(body);
        view.changed();
      });
      label.append(box, ` ${meta.bodies[body] ?? `body ${body}`}`);
      return [label, box, body];
    });
    $("bodies").append(...boxes.map(([label]) => label));
    $("bodies-count").textContent = grouped(bodies.length);
    $("bodies-field").hidden = bodies.length < 2;
    const all = (on) => {
      for (const [, box, body] of boxes) {
        box.checked = on;
        if (on) view.hiddenBodies.delete(body);
        else view.hiddenBodies.add(body);
      }
      view.changed();
    };
    $("all-bodies").addEventListener("click", () => all(true));
    $("no-bodies").addEventListener("click", () => all(false));
  }
}

run(SpacePage, (page, view) => ({
  // The direction of the view and the cut, and the numbers of facets and of triangles of the section.
  space: () => ({ yaw: view.yaw, pitch: view.pitch, scale: view.scale, plane: view.plane, facets: view.owners.length, section: view.cut?.owners.length ?? -1, unit: meta.view.unit, middle: meta.view.middle }),
  canvas: () => {
    const { left, top } = view.canvas.getBoundingClientRect(), { clientWidth: width, clientHeight: height } = view.canvas;
    return { left, top, width, height, foot: FOOT };
  },
  solid: () => view.frame.solid,
  turn: (yaw, pitch) => view.rotate(yaw - view.yaw, pitch - view.pitch),
}));
