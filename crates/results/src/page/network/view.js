// The view. Spheres are squares that the fragment shader rounds, rods are strips. The projection is parallel, so that sizes hold at every depth.

const SPHERES = {
  vertex: `#version 300 es
    precision highp float;
    layout(location = 0) in vec3 centre;
    layout(location = 1) in float radius;
    layout(location = 2) in vec4 colour;
    uniform mat3 turn;
    uniform vec2 pan, zoom;
    uniform float size, pixel;
    uniform vec4 plane;
    out vec2 corner;
    out vec4 paint;
    flat out vec2 depths;
    void main() {
      corner = vec2((gl_VertexID & 1) * 2 - 1, (gl_VertexID >> 1) * 2 - 1);
      paint = colour;
      vec3 place = turn * centre;
      float r = max(radius * size, pixel);
      depths = vec2(place.z, r);
      bool hidden = colour.a == 0.0 || dot(plane.xyz, centre) > plane.w;
      gl_Position = hidden ? vec4(2.0, 2.0, 2.0, 1.0) : vec4((place.xy - pan + corner * r) * zoom, 0.0, 1.0);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in vec2 corner;
    in vec4 paint;
    flat in vec2 depths;
    uniform vec3 paper;
    uniform float flatness;
    out vec4 colour;
    void main() {
      float rest = 1.0 - dot(corner, corner);
      // Covered share of the pixel, for antialiasing of the rim.
      float cover = clamp(0.5 + rest / max(fwidth(rest), 1e-6), 0.0, 1.0);
      if (cover == 0.0) discard;
      float w = sqrt(max(rest, 0.0));
      gl_FragDepth = 0.5 - 0.45 * (depths.x + (flatness > 0.5 ? 0.0 : w * depths.y));
      vec3 normal = vec3(corner, w);
      float light = (0.60 + 0.48 * max(dot(normal, vec3(-0.42, 0.62, 0.6624)), 0.0)) * (0.80 + 0.20 * w);
      float shine = 0.10 * pow(max(dot(normal, vec3(-0.23, 0.34, 0.912)), 0.0), 24.0);
      vec3 lit = flatness > 0.5 ? paint.rgb * (w < 0.22 ? 0.7 : 1.0) : paint.rgb * light + shine;
      colour = vec4(paint.a < 0.9 ? mix(paper, lit, 0.22) : lit, cover);
    }`,
};

const RODS = {
  vertex: `#version 300 es
    precision highp float;
    layout(location = 0) in vec3 from;
    layout(location = 1) in vec3 to;
    layout(location = 2) in float radius;
    layout(location = 3) in vec4 colour;
    uniform mat3 turn;
    uniform vec2 pan, zoom;
    uniform float pixel, lift;
    uniform vec4 plane;
    out float across;
    out vec4 paint;
    void main() {
      int side = (gl_VertexID & 1) * 2 - 1;
      paint = colour;
      across = float(side);
      vec3 a = turn * from, b = turn * to;
      vec2 along = b.xy - a.xy;
      float far = length(along);
      vec2 normal = far > 0.0 ? vec2(-along.y, along.x) / far : vec2(1.0, 0.0);
      vec3 end = (gl_VertexID >> 1) == 0 ? a : b;
      vec2 place = end.xy + normal * across * max(radius, pixel);
      bool hidden = colour.a == 0.0 || dot(plane.xyz, from) > plane.w || dot(plane.xyz, to) > plane.w;
      gl_Position = hidden ? vec4(2.0, 2.0, 2.0, 1.0) : vec4((place - pan) * zoom, -0.9 * (end.z + radius + lift), 1.0);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in float across;
    in vec4 paint;
    uniform vec3 paper;
    uniform float flatness;
    out vec4 colour;
    void main() {
      float light = flatness > 0.5 ? 1.0 : 0.62 + 0.43 * sqrt(max(1.0 - across * across, 0.0));
      colour = vec4(mix(paper, paint.rgb * light, paint.a < 0.9 ? 0.22 : 1.0), 1.0);
    }`,
};

// Triangles of surfaces: flat, lit from both sides.
const FACETS = {
  vertex: `#version 300 es
    precision highp float;
    layout(location = 0) in vec3 corner;
    layout(location = 1) in vec4 colour;
    uniform mat3 turn;
    uniform vec2 pan, zoom;
    uniform vec4 plane;
    out vec3 place;
    out vec4 paint;
    out float beyond;
    void main() {
      paint = colour;
      place = turn * corner;
      beyond = dot(plane.xyz, corner) - plane.w;
      gl_Position = colour.a == 0.0 ? vec4(2.0, 2.0, 2.0, 1.0) : vec4((place.xy - pan) * zoom, -0.9 * place.z, 1.0);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in vec3 place;
    in vec4 paint;
    in float beyond;
    uniform vec3 paper;
    uniform float flatness, cover;
    out vec4 colour;
    void main() {
      if (beyond > 0.0) discard;
      vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
      float light = flatness > 0.5 ? 1.0 : 0.55 + 0.45 * abs(dot(normal, vec3(-0.42, 0.62, 0.6624)));
      colour = vec4(mix(paper, paint.rgb * light, paint.a < 0.9 ? 0.22 : 1.0), cover);
    }`,
};

const HOME = meta.dimensions === 3 ? { yaw: Math.PI / 6, pitch: Math.PI / 9 } : { yaw: 0, pitch: Math.PI / 2 };

class View {
  // Throws an error without WebGL2.
  constructor(canvas, network) {
    this.canvas = canvas;
    this.network = network;
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: true, powerPreference: "high-performance" });
    if (!gl) throw new Error("this browser has no WebGL2");
    this.gl = gl;
    const { n, d } = network;
    let low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let k = 0; k < n; k++) {
      for (let axis = 0; axis < 3; axis++) {
        const x = network.at(k, axis), r = axis < d ? network.radius(k) * meta.drawn : 0;
        low[axis] = Math.min(low[axis], x - r);
        high[axis] = Math.max(high[axis], x + r);
      }
    }
    for (const line of meta.outline) {
      for (const end of line) end.forEach((x, axis) => {
        low[axis] = Math.min(low[axis], x);
        high[axis] = Math.max(high[axis], x);
      });
    }
    for (let k = 0; network.corners && k < network.corners.length; k++) {
      low[k % 3] = Math.min(low[k % 3], network.corners[k]);
      high[k % 3] = Math.max(high[k % 3], network.corners[k]);
    }
    if (low[0] > high[0]) { low = [0, 0, 0]; high = [1, 1, 1]; }
    this.low = low;
    this.high = high;
    this.middle = low.map((x, axis) => x + (high[axis] - x) / 2);
    // The unit of all coordinates is half of the diagonal, and the origin is the middle, so that 32 bits are enough wherever the packing is.
    const half = Math.hypot(...low.map((x, axis) => (high[axis] - x) / 2));
    this.unit = half > 0 && Number.isFinite(half) ? half : 1;
    this.visible = { elements: true, contacts: true };
    this.size = 1;
    // Opacity of surfaces.
    this.surfaces = meta.bodies?.walls ? 0.3 : 1;
    this.plane = [0, 0, 0, 1e9];
    this.quality = 1;
    this.selected = -1;
    this.neighbours = new Set();
    this.afterDraw = () => {};
    this.build();
    this.home();
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  build() {
    const { gl, network } = this;
    const { n, m, d } = network;
    this.centres = new Float32Array(3 * n);
    this.radii = new Float32Array(n);
    for (let k = 0; k < n; k++) {
      for (let axis = 0; axis < 3; axis++) this.centres[3 * k + axis] = (network.at(k, axis) - this.middle[axis]) / this.unit;
      this.radii[k] = network.radius(k) * meta.drawn / this.unit;
    }
    // A contact that leads to an image has two halves, one at each element.
    const across = network.branch ? (c) => network.shift.subarray(d * c, d * c + d).some((x) => x !== 0) || this.leaves(c) : () => false;
    const { halves } = network;
    let rods = 0;
    for (let c = 0; c < m; c++) rods += halves ? (halves[c] & 1) + (halves[c] >> 1) : across(c) ? 2 : 1;
    rods += meta.outline.length;
    const ends = new Float32Array(7 * rods);
    this.rodOf = new Int32Array(rods).fill(-1);
    const share = overlapShare();
    let rod = 0;
    const put = (from, to, radius, contact) => {
      ends.set(from, 7 * rod);
      ends.set(to, 7 * rod + 3);
      ends[7 * rod + 6] = radius;
      this.rodOf[rod++] = contact;
    };
    for (let c = 0; c < m; c++) {
      const i = network.i[c], j = network.j[c];
      const from = this.centres.subarray(3 * i, 3 * i + 3), to = this.centres.subarray(3 * j, 3 * j + 3);
      const radius = Math.min(this.radii[i], this.radii[j]) * (d === 2 ? 0.5 : 1) * (0.10 + 0.14 * share(network.overlap[c]));
      if (halves) {
        // The line leads through the contact point.
        const point = [0, 1, 2].map((axis) => (axis < d ? network.point[d * c + axis] : 0)).map((x, axis) => (x - this.middle[axis]) / this.unit);
        const wide = (meta.bodies.rod / this.unit) * (0.6 + 0.8 * share(network.overlap[c]));
        if (halves[c] & 1) put(from, point, wide, c);
        if (halves[c] & 2) put(point, to, wide, c);
      } else if (across(c)) {
        const half = [0, 1, 2].map((axis) => (axis < d ? network.branch[d * c + axis] / this.unit / 2 : 0));
        put(from, half.map((x, axis) => from[axis] + x), radius, c);
        put(to, half.map((x, axis) => to[axis] - x), radius, c);
      } else put(from, to, radius, c);
    }
    for (const [a, b] of meta.outline) {
      const inside = (end) => end.map((x, axis) => (x - this.middle[axis]) / this.unit);
      put(inside(a), inside(b), 0, -1);
    }
    this.rods = rods;
    this.sphereColours = new Uint8Array(4 * n);
    this.rodColours = new Uint8Array(4 * rods);
    this.alphas = new Uint8Array(n);
    const { corners, facets } = network;
    this.facetCount = facets ? facets.length / 3 : 0;
    this.corners = new Float32Array(9 * this.facetCount);
    for (let k = 0; k < 3 * this.facetCount; k++) {
      for (let axis = 0; axis < 3; axis++) this.corners[3 * k + axis] = (corners[3 * facets[k] + axis] - this.middle[axis]) / this.unit;
    }
    this.facetColours = new Uint8Array(12 * this.facetCount);
    this.programs = [SPHERES, RODS, FACETS].map((source) => this.program(source));
    const buffer = (content) => {
      const made = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, made);
      gl.bufferData(gl.ARRAY_BUFFER, content, gl.STATIC_DRAW);
      return made;
    };
    const attribute = (place, count, kind, normal, stride, start) => {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, count, kind, normal, stride, start);
      gl.vertexAttribDivisor(place, 1);
    };
    this.sphereArray = gl.createVertexArray();
    gl.bindVertexArray(this.sphereArray);
    buffer(this.centres);
    attribute(0, 3, gl.FLOAT, false, 12, 0);
    buffer(this.radii);
    attribute(1, 1, gl.FLOAT, false, 4, 0);
    this.sphereColourBuffer = buffer(this.sphereColours);
    attribute(2, 4, gl.UNSIGNED_BYTE, true, 4, 0);
    this.rodArray = gl.createVertexArray();
    gl.bindVertexArray(this.rodArray);
    buffer(ends);
    attribute(0, 3, gl.FLOAT, false, 28, 0);
    attribute(1, 3, gl.FLOAT, false, 28, 12);
    attribute(2, 1, gl.FLOAT, false, 28, 24);
    this.rodColourBuffer = buffer(this.rodColours);
    attribute(3, 4, gl.UNSIGNED_BYTE, true, 4, 0);
    this.facetArray = gl.createVertexArray();
    gl.bindVertexArray(this.facetArray);
    buffer(this.corners);
    attribute(0, 3, gl.FLOAT, false, 12, 0);
    this.facetColourBuffer = buffer(this.facetColours);
    attribute(1, 4, gl.UNSIGNED_BYTE, true, 4, 0);
    for (const place of [0, 1]) gl.vertexAttribDivisor(place, 0);
    gl.bindVertexArray(null);
  }

  // Whether the branch of a contact leads out of the box although its shift is 0, because elements of the file are outside of the box.
  leaves(c) {
    const { network } = this, { d } = network, i = network.i[c], j = network.j[c];
    for (let axis = 0; axis < d; axis++) {
      if (Math.abs(network.at(i, axis) + network.branch[d * c + axis] - network.at(j, axis)) > 1e-5 * this.unit) return true;
    }
    return false;
  }

  program({ vertex, fragment }) {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) || "the view cannot be set up");
    const places = {};
    for (let k = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) - 1; k >= 0; k--) {
      const { name } = gl.getActiveUniform(program, k);
      places[name] = gl.getUniformLocation(program, name);
    }
    return { program, places };
  }

  home() {
    Object.assign(this, HOME, { pan: [0, 0] });
    this.scale = this.fit();
    this.fitted = true;
    this.redraw();
  }

  // Pixels of the page per unit at which the projected bounding box fits into the view.
  fit() {
    const turn = this.turn();
    const extent = [0, 1].map((row) => this.low.reduce((sum, x, axis) => sum + Math.abs(turn[row][axis]) * (this.high[axis] - x) / this.unit, 0));
    const { clientWidth, clientHeight } = this.canvas;
    const scale = 0.92 * Math.min(clientWidth / (extent[0] || 1e-9), clientHeight / (extent[1] || 1e-9));
    return Math.min(scale, 0.25 * Math.max(clientWidth, clientHeight, 1) * 4);
  }

  // Directions to the right, up and towards the eye, as rows.
  turn() {
    const [s, c, t, u] = [Math.sin(this.yaw), Math.cos(this.yaw), Math.sin(this.pitch), Math.cos(this.pitch)];
    return [[c, s, 0], [-t * s, t * c, u], [u * s, -u * c, t]];
  }

  // Position of element k: pixels of the page from the upper left corner of the view, and units towards the eye.
  project(k) {
    const turn = this.turn(), { clientWidth, clientHeight } = this.canvas;
    const [x, y, z] = turn.map((row) => row[0] * this.centres[3 * k] + row[1] * this.centres[3 * k + 1] + row[2] * this.centres[3 * k + 2]);
    return [clientWidth / 2 + (x - this.pan[0]) * this.scale, clientHeight / 2 - (y - this.pan[1]) * this.scale, z];
  }

  shown(k) {
    const at = 3 * k, [a, b, c, most] = this.plane;
    const beyond = a * this.centres[at] + b * this.centres[at + 1] + c * this.centres[at + 2] > most;
    return !beyond && this.alphas[k] !== 0;
  }

  // The front element at a point of the view, or -1.
  pick(x, y) {
    const turn = this.turn(), { clientWidth, clientHeight } = this.canvas;
    const u = (x - clientWidth / 2) / this.scale + this.pan[0], v = (clientHeight / 2 - y) / this.scale + this.pan[1];
    // If elements are hidden, their centres among the contacts can be picked.
    const size = this.visible.elements ? this.size : 0.3, least = 4 / this.scale;
    let found = -1, nearest = -Infinity;
    for (let k = 0; k < this.network.n; k++) {
      const a = this.centres[3 * k], b = this.centres[3 * k + 1], c = this.centres[3 * k + 2];
      const du = turn[0][0] * a + turn[0][1] * b + turn[0][2] * c - u, dv = turn[1][0] * a + turn[1][1] * b + turn[1][2] * c - v;
      const r = Math.max(this.radii[k] * size, least), rest = r * r - du * du - dv * dv;
      if (rest < 0) continue;
      const depth = turn[2][0] * a + turn[2][1] * b + turn[2][2] * c + Math.sqrt(rest);
      if (depth > nearest && this.shown(k) && !(meta.bodies && this.radii[k] === 0)) { nearest = depth; found = k; }
    }
    // An element that is visible through a surface is picked before the surface.
    if (!this.visible.elements || this.surfaces === 0 || (this.surfaces < 1 && found >= 0)) return found;
    const [right, up, toward] = turn, dot = (row, at) => row[0] * this.corners[at] + row[1] * this.corners[at + 1] + row[2] * this.corners[at + 2];
    for (let facet = 0; facet < this.facetCount; facet++) {
      const [a, b, c] = [0, 3, 6].map((corner) => [dot(right, 9 * facet + corner) - u, dot(up, 9 * facet + corner) - v, dot(toward, 9 * facet + corner)]);
      const [p, q, r] = [b[0] * c[1] - c[0] * b[1], c[0] * a[1] - a[0] * c[1], a[0] * b[1] - b[0] * a[1]];
      if ((p < 0 || q < 0 || r < 0) && (p > 0 || q > 0 || r > 0)) continue;
      const depth = (p * a[2] + q * b[2] + r * c[2]) / (p + q + r || 1), owner = this.network.owner[facet];
      if (depth > nearest && this.alphas[owner]) { nearest = depth; found = owner; }
    }
    return found;
  }

  colourFacets(ofBody) {
    const { gl, network } = this;
    for (let k = 0; k < 3 * this.facetCount; k++) this.facetColours.set(ofBody(network.owner[Math.floor(k / 3)]), 4 * k);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.facetColourBuffer);
    gl.bufferData(gl.ARRAY_BUFFER, this.facetColours, gl.DYNAMIC_DRAW);
  }

  colour(ofElement, ofContact, outline) {
    for (let k = 0; k < this.network.n; k++) {
      const colour = ofElement(k);
      this.alphas[k] = colour[3];
      // A body that is drawn as a surface is not drawn as a sphere.
      if (meta.bodies && this.radii[k] === 0) colour[3] = 0;
      this.sphereColours.set(colour, 4 * k);
    }
    for (let rod = 0; rod < this.rods; rod++) this.rodColours.set(this.rodOf[rod] < 0 ? outline : ofContact(this.rodOf[rod]), 4 * rod);
    const { gl } = this;
    for (const [buffer, content] of [[this.sphereColourBuffer, this.sphereColours], [this.rodColourBuffer, this.rodColours]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, content, gl.DYNAMIC_DRAW);
    }
    this.redraw();
  }

  rotate(yaw, pitch) {
    if (meta.dimensions === 2) return;
    this.yaw += yaw;
    this.pitch = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, this.pitch + pitch));
    this.moved();
  }

  // Moves the view by pixels of the page.
  move(x, y) {
    this.pan = [this.pan[0] - x / this.scale, this.pan[1] + y / this.scale];
    this.moved();
  }

  // Zooms about a point of the view, by default the middle.
  zoom(factor, x = this.canvas.clientWidth / 2, y = this.canvas.clientHeight / 2) {
    const least = this.fit() / 20, most = Math.max(this.fit() * 2000, 1);
    const scale = Math.max(least, Math.min(most, this.scale * factor));
    const [dx, dy] = [x - this.canvas.clientWidth / 2, this.canvas.clientHeight / 2 - y];
    this.pan = [this.pan[0] + dx / this.scale - dx / scale, this.pan[1] + dy / this.scale - dy / scale];
    this.scale = scale;
    this.moved();
  }

  // Moves element k to the middle of the view and scales it to an eighth of the view, so that its neighbours are visible.
  focus(k) {
    const turn = this.turn(), at = this.centres.subarray(3 * k, 3 * k + 3);
    this.pan = [0, 1].map((row) => turn[row][0] * at[0] + turn[row][1] * at[1] + turn[row][2] * at[2]);
    const { clientWidth, clientHeight } = this.canvas, r = this.radii[k];
    // A surface has a centre but no radius.
    if (meta.bodies && r === 0) return this.moved();
    const wanted = r > 0 ? Math.min(clientWidth, clientHeight) / (16 * r) : this.scale;
    this.scale = Math.max(this.fit(), Math.min(this.fit() * 2000, wanted));
    this.moved();
  }

  moved() {
    this.fitted = false;
    this.moving = performance.now();
    this.redraw();
  }

  redraw() {
    this.asked ??= requestAnimationFrame((now) => {
      this.asked = undefined;
      this.frame(now);
    });
  }

  // Draws fewer pixels while a moving view is slow, and all pixels when the view rests.
  frame(now) {
    const moving = this.moving !== undefined && now - this.moving < 200;
    if (moving && this.before !== undefined) {
      const took = now - this.before;
      if (took > 55) this.quality = Math.max(0.35, this.quality * 0.8);
      else if (took < 25) this.quality = Math.min(1, this.quality * 1.1);
    }
    this.before = moving ? now : undefined;
    this.draw(moving ? this.quality : 1);
    if (moving) {
      clearTimeout(this.rest);
      this.rest = setTimeout(() => { this.moving = undefined; this.redraw(); }, 220);
    }
  }

  draw(quality) {
    const { gl, canvas } = this;
    const { clientWidth, clientHeight } = canvas;
    if (!clientWidth || !clientHeight) return;
    const ratio = Math.min(window.devicePixelRatio || 1, 2) * quality;
    const [width, height] = [Math.max(1, Math.round(clientWidth * ratio)), Math.max(1, Math.round(clientHeight * ratio))];
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    if (this.fitted) this.scale = this.fit();
    gl.viewport(0, 0, width, height);
    const paper = this.paper();
    gl.clearColor(...paper, 1);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.SAMPLE_ALPHA_TO_COVERAGE);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const turn = this.turn();
    const flat = meta.dimensions === 2;
    const use = ({ program, places }, more) => {
      gl.useProgram(program);
      gl.uniformMatrix3fv(places.turn, false, [0, 1, 2].flatMap((column) => turn.map((row) => row[column])));
      gl.uniform2f(places.pan, ...this.pan);
      gl.uniform2f(places.zoom, 2 * this.scale / clientWidth, 2 * this.scale / clientHeight);
      gl.uniform1f(places.pixel, more / (this.scale * ratio));
      gl.uniform4f(places.plane, ...this.plane);
      gl.uniform3f(places.paper, ...paper);
      gl.uniform1f(places.flatness, flat ? 1 : 0);
      return places;
    };
    const spheres = use(this.programs[0], 0.75);
    // Without elements, contacts meet in small spheres.
    gl.uniform1f(spheres.size, this.visible.elements ? this.size : 0.12);
    gl.bindVertexArray(this.sphereArray);
    if (this.visible.elements || this.visible.contacts) gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.network.n);
    const rods = use(this.programs[1], 0.5);
    gl.uniform1f(rods.lift, flat ? 0.05 : 0);
    gl.bindVertexArray(this.rodArray);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.rods);
    if (this.facetCount && this.visible.elements && this.surfaces > 0) {
      const facets = use(this.programs[2], 0);
      const through = this.surfaces < 1;
      gl.uniform1f(facets.cover, this.surfaces);
      gl.disable(gl.SAMPLE_ALPHA_TO_COVERAGE);
      if (through) {
        gl.enable(gl.BLEND);
        gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
        gl.depthMask(false);
      }
      gl.bindVertexArray(this.facetArray);
      gl.drawArrays(gl.TRIANGLES, 0, 3 * this.facetCount);
      gl.disable(gl.BLEND);
      gl.depthMask(true);
    }
    gl.bindVertexArray(null);
    this.afterDraw();
  }

  paper() {
    const text = getComputedStyle(document.documentElement).getPropertyValue("--view").trim();
    return [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16) / 255);
  }
}

function overlapShare() {
  const range = meta.overlaps;
  if (!range || !(range.high > range.low)) return () => 0.5;
  return (x) => Math.max(0, Math.min(1, (x - range.low) / (range.high - range.low)));
}
