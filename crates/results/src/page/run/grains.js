// Spheres or discs, force chains and walls: their data, their drawing, and their part of the controls.

// Returns the arrays of the spheres of a frame.
function openedGrains(about, arrays) {
  const { spheres: n, chains: m, loose, triangles } = about, [ofCentres, ofPlaces, ofWalls] = about.bounds;
  // Centres and radii stay packed: the graphics card opens them.
  const packed = new Uint16Array(4 * n);
  for (let axis = 0; axis < 3; axis++) arrays.numbers(n).forEach((place, i) => { packed[4 * i + axis] = place; });
  const scales = about.scales.map(() => arrays.numbers(n)), radius = scales[meta.spheres.radius];
  for (let i = 0; i < n; i++) packed[4 * i + 3] = radius[i];
  const ascending = (numbers) => {
    for (let i = 1; i < numbers.length; i++) numbers[i] += numbers[i - 1];
    return numbers;
  };
  const numbers = ascending(arrays.halves(n)), group = arrays.numbers(n), material = arrays.numbers(n);
  const first = ascending(arrays.halves(m)), second = arrays.halves(m), normals = arrays.numbers(m);
  const places = arrays.points(loose, 1, ofPlaces), corners = arrays.points(triangles, 3, ofWalls), owners = arrays.numbers(triangles), lines = arrays.numbers(triangles);
  const centre = (i) => [0, 1, 2].map((axis) => inView(valueOf(packed[4 * i + axis], ofCentres[axis]), axis));
  const ends = new Float32Array(6 * m);
  let next = 0;
  for (let k = 0; k < m; k++) {
    ends.set(centre(first[k]), 6 * k);
    if (second[k] === TO_PLACE) ends.set(places.subarray(3 * next, 3 * ++next), 6 * k + 3);
    else ends.set(centre(second[k]), 6 * k + 3);
  }
  return { n, about, packed, scales, numbers, group, material, ends, normals, corners, owners, lines, centre, place: (number) => placeOf(number, numbers, 0, n), value: (scale, i) => valueOf(scales[scale][i], about.scales[scale]) };
}

const TO_PLACE = 4294967295;
// Share of the radius with which spheres are drawn among force chains.
const SHRUNK = 0.35;

// Converts a coordinate to units of the view.
const inView = (x, axis) => (x - (meta.view.middle[axis] ?? 0)) / meta.view.unit;

// Spheres with at most this diameter in pixels are drawn as points: one vertex each. Larger points would vanish with their middle at the edge of the view.
const MOST_OF_POINTS = 48;

// The program of spheres, as points or as squares.
const balls = (points) => ({
  vertex: `#version 300 es
    precision highp float;
    layout(location = 0) in vec4 place;
    layout(location = 1) in vec4 colour;
    uniform mat3 turn;
    uniform vec2 pan, zoom;
    uniform float deep, least, share, pixels;
    uniform vec4 plane, low, span;
    ${points ? "" : "out vec2 at;"}
    flat out vec3 paint;
    flat out vec2 depth;
    void main() {
      vec4 ball = low + span * place;
      vec3 centre = turn * ball.xyz;
      float radius = max(share * ball.w, least);
      ${points ? "vec2 at = vec2(0.0); gl_PointSize = 2.0 * radius * pixels;" : "at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;"}
      paint = colour.rgb;
      depth = vec2(0.5 - 0.5 * centre.z * deep, 0.5 * radius * deep);
      gl_Position = vec4((centre.xy + at * radius - pan) * zoom, -centre.z * deep, 1.0);
      // Spheres beyond the plane are cut away.
      if (dot(plane.xyz, ball.xyz) > plane.w) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    }`,
  fragment: `#version 300 es
    precision highp float;
    ${points ? "" : "in vec2 at;"}
    flat in vec3 paint;
    flat in vec2 depth;
    uniform bool round;
    out vec4 colour;
    void main() {
      ${points ? "vec2 at = vec2(2.0, -2.0) * gl_PointCoord + vec2(-1.0, 1.0);" : ""}
      float square = dot(at, at);
      if (square > 1.0) discard;
      float up = sqrt(1.0 - square);
      // The rim covers a part of its pixels.
      float cover = clamp((1.0 - square) / max(fwidth(square), 1e-6), 0.0, 1.0);
      if (round) {
        // The light is that of the bodies. The rim is darker, so that neighbours differ.
        float light = (0.80 + 0.22 * dot(vec3(at, up), vec3(-0.35, 0.75, 0.5612))) * (0.84 + 0.16 * up);
        colour = vec4(paint * light, cover);
      } else {
        float wide = fwidth(square) * 0.7;
        colour = vec4(paint * (1.0 - 0.42 * smoothstep(0.78 - wide, 0.78 + wide, square)), cover);
      }
      gl_FragDepth = depth.x - up * depth.y;
    }`,
});

const BARS = {
  vertex: `#version 300 es
    precision highp float;
    layout(location = 0) in vec3 from;
    layout(location = 1) in vec3 to;
    layout(location = 2) in vec4 colour;
    layout(location = 3) in float width;
    uniform mat3 turn;
    uniform vec2 pan, zoom, pixel;
    uniform float deep, least;
    uniform vec4 plane;
    out float side;
    flat out vec3 paint;
    void main() {
      vec3 p = turn * from, q = turn * to;
      vec2 a = (p.xy - pan) * zoom / pixel, b = (q.xy - pan) * zoom / pixel;
      float far = length(b - a);
      vec2 along = far > 0.0 ? (b - a) / far : vec2(1.0, 0.0);
      bool last = (gl_VertexID >> 1) == 1;
      side = float(gl_VertexID & 1) * 2.0 - 1.0;
      float wide = max(width * zoom.x / pixel.x, least);
      paint = colour.rgb;
      gl_Position = vec4(((last ? b : a) + vec2(-along.y, along.x) * side * 0.5 * wide) * pixel, -(last ? q.z : p.z) * deep, 1.0);
      if (dot(plane.xyz, 0.5 * (from + to)) > plane.w) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in float side;
    flat in vec3 paint;
    uniform float shade;
    out vec4 colour;
    void main() { colour = vec4(paint * (1.0 - shade * side * side), 1.0); }`,
};

const GLASS = {
  vertex: `#version 300 es
    precision highp float;
    layout(location = 0) in vec3 corner;
    uniform mat3 turn;
    uniform vec2 pan, zoom;
    uniform float deep;
    uniform vec4 plane;
    out float beyond;
    void main() {
      vec3 place = turn * corner;
      beyond = dot(plane.xyz, corner) - plane.w;
      gl_Position = vec4((place.xy - pan) * zoom, -place.z * deep, 1.0);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in float beyond;
    uniform vec4 tint;
    out vec4 colour;
    void main() {
      if (beyond > 0.0) discard;
      colour = tint;
    }`,
};

// Draws the spheres of a view.
class Grains {
  constructor(view, flat) {
    const { gl } = view, uniforms = ["turn", "pan", "zoom", "deep", "plane"];
    Object.assign(this, { view, flat, grains: null, visible: { spheres: true, chains: false, walls: true } });
    this.programs = [false, true].map((points) => view.program(balls(points), [...uniforms, "least", "share", "pixels", "low", "span", "round"]));
    this.bars = view.program(BARS, [...uniforms, "pixel", "least", "shade"]);
    this.glass = view.program(GLASS, [...uniforms, "tint"]);
    this.buffers = Object.fromEntries(["places", "colours", "corners"].map((name) => [name, gl.createBuffer()]));
    // As squares each sphere is an instance.
    this.ofBalls = [1, 0].map((divisor) => {
      const array = gl.createVertexArray();
      gl.bindVertexArray(array);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.places);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 4, gl.UNSIGNED_SHORT, true, 8, 0);
      gl.vertexAttribDivisor(0, divisor);
      view.attribute(1, this.buffers.colours, 4, gl.UNSIGNED_BYTE, 4, 0, divisor);
      return array;
    });
    this.mostOfPoints = Math.min(MOST_OF_POINTS, gl.getParameter(gl.ALIASED_POINT_SIZE_RANGE)[1]);
    this.ofGlass = gl.createVertexArray();
    gl.bindVertexArray(this.ofGlass);
    view.attribute(0, this.buffers.corners, 3, gl.FLOAT, 12, 0, 0);
    const bars = () => {
      const array = gl.createVertexArray(), ends = gl.createBuffer(), colours = gl.createBuffer(), widths = gl.createBuffer();
      gl.bindVertexArray(array);
      view.attribute(0, ends, 3, gl.FLOAT, 24, 0, 1);
      view.attribute(1, ends, 3, gl.FLOAT, 24, 12, 1);
      view.attribute(2, colours, 4, gl.UNSIGNED_BYTE, 4, 0, 1);
      view.attribute(3, widths, 1, gl.FLOAT, 4, 0, 1);
      return { array, ends, colours, widths, count: 0 };
    };
    this.chains = bars();
    this.edges = bars();
    gl.bindVertexArray(null);
  }

  // Sets the spheres and walls of a frame.
  set(grains) {
    if (this.grains === grains) return;
    const { view, buffers } = this;
    this.grains = grains;
    this.radius = 0;
    if (!grains) return;
    view.fill(buffers.places, grains.packed);
    view.fill(buffers.corners, grains.corners);
    view.fill(this.chains.ends, grains.ends);
    const ends = [];
    grains.lines.forEach((bits, k) => {
      for (let edge = 0; edge < 3; edge++) {
        if (!((bits >> edge) & 1)) continue;
        const a = 9 * k + 3 * edge, b = 9 * k + 3 * ((edge + 1) % 3);
        for (const at of [a, b]) ends.push(grains.corners[at], grains.corners[at + 1], grains.corners[at + 2]);
      }
    });
    this.edges.count = ends.length / 6;
    view.fill(this.edges.ends, new Float32Array(ends));
    view.fill(this.edges.widths, new Float32Array(this.edges.count));
    const { bounds, scales } = grains.about, ofRadii = scales[meta.spheres.radius];
    const low = bounds[0].map(([low], axis) => inView(low, axis)), wide = [...bounds[0], ofRadii].map(([low, high]) => ((high - low) / meta.view.unit) * (65535 / STEPS));
    this.low = [...low, ofRadii[0] / meta.view.unit];
    this.span = wide;
    // Distance of the farthest point from the middle.
    const far = (pairs) => Math.hypot(...pairs.map((ends, axis) => Math.max(...ends.map((x) => Math.abs(inView(x, axis))))));
    this.radius = Math.max(grains.n ? far(bounds[0]) + ofRadii[1] / meta.view.unit : 0, grains.owners.length ? far(bounds[2]) : 0);
  }

  // Sets the colours of the spheres and of the chains, and the force of the widest chains.
  paint(colours, ofChains, widths) {
    const { view } = this;
    view.fill(this.buffers.colours, colours);
    view.fill(this.chains.colours, ofChains);
    view.fill(this.chains.widths, widths);
    this.chains.count = widths.length;
    const dark = view.paper()[0] < 0.5;
    view.fill(this.edges.colours, new Uint32Array(this.edges.count).fill(packedColour(dark ? [150, 162, 174] : meta.spheres.wall)));
    view.redraw();
  }

  get share() {
    return this.visible.chains && !this.flat ? SHRUNK : 1;
  }

  // Draws all. `turn`: directions to the right, up and towards the eye, as rows.
  draw({ turn, pan, zoom, pixel, deep, plane, ratio }) {
    const { grains, flat } = this, { gl } = this.view;
    if (!grains) return;
    const begin = (program) => {
      gl.useProgram(program.program);
      gl.uniformMatrix3fv(program.turn, true, turn.flat());
      gl.uniform2fv(program.pan, pan);
      gl.uniform2fv(program.zoom, zoom);
      gl.uniform1f(program.deep, deep);
      gl.uniform4fv(program.plane, plane);
    };
    if (flat) gl.disable(gl.DEPTH_TEST);
    else gl.enable(gl.DEPTH_TEST);
    if (this.visible.spheres && grains.n) {
      const pixels = zoom[0] / pixel[0], largest = 2 * this.share * (this.low[3] + this.span[3]) * pixels, points = largest <= this.mostOfPoints ? 1 : 0, program = this.programs[points];
      begin(program);
      gl.uniform4fv(program.low, this.low);
      gl.uniform4fv(program.span, this.span);
      gl.uniform1f(program.share, this.share);
      gl.uniform1f(program.pixels, pixels);
      // None is smaller than a pixel.
      gl.uniform1f(program.least, 0.6 / pixels);
      gl.uniform1i(program.round, flat ? 0 : 1);
      gl.bindVertexArray(this.ofBalls[points]);
      gl.enable(gl.SAMPLE_ALPHA_TO_COVERAGE);
      if (points) gl.drawArrays(gl.POINTS, 0, grains.n);
      else gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, grains.n);
      gl.disable(gl.SAMPLE_ALPHA_TO_COVERAGE);
    }
    const bars = ({ array, count }, least, shade) => {
      if (!count) return;
      begin(this.bars);
      gl.uniform2fv(this.bars.pixel, pixel);
      gl.uniform1f(this.bars.least, least * ratio);
      gl.uniform1f(this.bars.shade, shade);
      gl.bindVertexArray(array);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
    };
    if (this.visible.chains) bars(this.chains, 0.7, flat ? 0 : 0.35);
    if (this.visible.walls) {
      bars(this.edges, flat ? 1.8 : 1.2, 0);
      if (!flat && grains.owners.length) {
        begin(this.glass);
        gl.uniform4fv(this.glass.tint, [0.47, 0.56, 0.66, 0.1]);
        gl.enable(gl.BLEND);
        gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
        gl.depthMask(false);
        gl.bindVertexArray(this.ofGlass);
        gl.drawArrays(gl.TRIANGLES, 0, 3 * grains.owners.length);
        gl.depthMask(true);
        gl.disable(gl.BLEND);
      }
    }
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(null);
  }

  // Returns the sphere at a point of the view, the nearest to the eye, and its depth there: -1 if there is none.
  pick([u, v], [right, up, toward], [a, b, c, d]) {
    const { grains, low, span } = this, found = { sphere: -1, depth: -Infinity };
    if (!grains || !this.visible.spheres) return found;
    const { packed, n } = grains, scaled = span.map((x) => x / 65535);
    for (let i = 0; i < n; i++) {
      const x = low[0] + packed[4 * i] * scaled[0], y = low[1] + packed[4 * i + 1] * scaled[1], z = low[2] + packed[4 * i + 2] * scaled[2];
      const du = right[0] * x + right[1] * y + right[2] * z - u, dv = up[0] * x + up[1] * y + up[2] * z - v;
      const radius = this.share * (low[3] + packed[4 * i + 3] * scaled[3]), rest = radius * radius - du * du - dv * dv;
      if (rest < 0 || a * x + b * y + c * z > d) continue;
      const depth = this.flat ? i : toward[0] * x + toward[1] * y + toward[2] * z + Math.sqrt(rest);
      if (depth > found.depth) Object.assign(found, { sphere: i, depth });
    }
    return found;
  }

  // Radius of a sphere as it is drawn, in units of the view.
  radiusOf(i) {
    return this.share * (this.low[3] + (this.grains.packed[4 * i + 3] * this.span[3]) / 65535);
  }
}

// The part of the controls that is about spheres.
class SphereControls {
  constructor(page) {
    this.page = page;
    // Number of the selected sphere, or -1.
    this.selected = -1;
    const { grains } = page.view;
    $("sphere-field").addEventListener("change", () => page.paint());
    for (const name of Object.keys(grains.visible)) {
      grains.visible[name] = $(`show-${name}`).checked;
      $(`show-${name}`).addEventListener("change", (event) => {
        grains.visible[name] = event.target.checked;
        page.paint();
      });
    }
    if (!meta.elements) for (const id of ["field", "solid", "show-cracks", "show-outlines", "show-mesh"]) if ($(id)) $(id).parentElement.hidden = true;
    $("picked-heading").textContent = meta.elements ? `Element or ${meta.spheres.one}` : meta.spheres.one[0].toUpperCase() + meta.spheres.one.slice(1);
  }

  get shown() {
    return this.page.shown?.grains;
  }

  field() {
    return meta.spheres.fields[$("sphere-field").selectedIndex];
  }

  range(field, usual) {
    if ($("range").value === "series") return field.range;
    return [0, usual[1] || 1];
  }

  // A colour for each of `places`, whose values are between `ends`.
  scaled(places, ends, field, [low, high]) {
    const table = Array.from({ length: 512 }, (_, k) => packedColour(ramp(field.ramp, k / 511))), none = packedColour(meta.none);
    const step = (511 * (ends[1] - ends[0])) / STEPS / (high - low), start = (511 * (ends[0] - low)) / (high - low), colours = new Uint32Array(places.length);
    for (let k = 0; k < places.length; k++) colours[k] = places[k] === NOWHERE ? none : table[Math.max(0, Math.min(511, Math.round(start + places[k] * step)))];
    return colours;
  }

  paint() {
    const grains = this.shown, { view } = this.page, field = this.field();
    if (!grains) return;
    const { about } = grains, numbered = meta.numbered.map(packedColour);
    const colours = field.scale === null
      ? Uint32Array.from(grains[field.key], (number) => numbered[number % numbered.length])
      : this.scaled(grains.scales[field.scale], about.scales[field.scale], field, this.range(field, about.usual[field.scale]));
    const { chains } = meta.spheres, range = this.range(chains, about.chainsUsual), ofChains = this.scaled(grains.normals, about.chainsEnds, chains, range);
    const widest = (2 * chains.widest * this.meanRadius(grains)) / meta.view.unit, pulling = packedColour(meta.spheres.pulling), widths = new Float32Array(grains.normals.length);
    for (let k = 0; k < widths.length; k++) {
      const normal = valueOf(grains.normals[k], about.chainsEnds);
      widths[k] = widest * Math.min(1.6, Math.abs(normal) / range[1]);
      if (normal < 0) ofChains[k] = pulling;
    }
    view.grains.paint(colours, ofChains, widths);
  }

  meanRadius(grains) {
    let sum = 0;
    for (let i = 0; i < grains.n; i++) sum += grains.value(meta.spheres.radius, i);
    return grains.n ? sum / grains.n : 0;
  }

  legends() {
    const grains = this.shown, field = this.field(), { visible } = this.page.view.grains, found = [];
    if (!grains) return found;
    const { about } = grains;
    const range = field.scale === null ? [0, 1] : this.range(field, about.usual[field.scale]), bodies = this.page.field();
    // One legend serves both where it is the same.
    const isSame = meta.elements && bodies.key === field.key && this.page.range(bodies)[1] === range[1];
    if (visible.spheres && field.scale !== null && !isSame) found.push(this.page.bar(field, range, meta.elements ? `${meta.spheres.many}: ` : ""));
    if (visible.chains && about.chains) found.push(this.page.bar(meta.spheres.chains, this.range(meta.spheres.chains, about.chainsUsual)));
    return found;
  }

  // Selects the sphere at place i of the frame, or none.
  select(i) {
    this.selected = i < 0 ? -1 : this.shown.numbers[i];
  }

  // The place of the selected sphere in the frame, or -1.
  get place() {
    return this.selected < 0 || !this.shown ? -1 : this.shown.place(this.selected);
  }

  // Writes the facts of the selected sphere; false if none is selected.
  describe() {
    if (this.selected < 0) return false;
    const i = this.place, grains = this.shown, { one } = meta.spheres;
    if (i < 0) {
      $("picked").replaceChildren(make("p", `No ${one} in this frame has number ${grouped(this.selected)}.`, { class: "hint" }));
      return true;
    }
    const list = document.createElement("dl"), add = (name, text) => list.append(make("dt", name), make("dd", text, { "data-fact": name }));
    add(one, grouped(this.selected));
    add("group", meta.spheres.groups[grains.group[i]] || String(grains.group[i]));
    add("material", meta.materials[grains.material[i]] ?? String(grains.material[i]));
    const centre = grains.centre(i), axes = this.page.view.grains.flat ? 2 : 3;
    for (let axis = 0; axis < axes; axis++) add("xyz"[axis], quantity(centre[axis] * meta.view.unit + meta.view.middle[axis], "m"));
    for (const field of meta.spheres.fields) if (field.scale !== null) add(field.name, quantity(grains.value(field.scale, i), field.unit));
    $("picked").replaceChildren(list, make("p", "Values in this frame, rounded to 1/65,534 of their range in the frame.", { class: "scale" }));
    return true;
  }

  // The ring around the selected sphere.
  ring() {
    const i = this.place, { view } = this.page;
    if (i < 0 || view.grains.grains !== this.shown) return [];
    const [x, y] = view.project(this.shown.centre(i));
    return [svg("circle", { cx: x.toFixed(1), cy: y.toFixed(1), r: Math.max(3, view.grains.radiusOf(i) * view.scale).toFixed(1) })];
  }
}
