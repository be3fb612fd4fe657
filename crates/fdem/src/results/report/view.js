// The view: coloured triangles, and above them outlines and cracks as strips of constant width.

const TRIANGLES = {
  vertex: `#version 300 es
    precision highp float;
    layout(location = 0) in vec2 corner;
    layout(location = 1) in vec4 colour;
    uniform vec2 pan, zoom;
    out vec3 share;
    out vec4 paint;
    void main() {
      int k = gl_VertexID % 3;
      share = vec3(k == 0, k == 1, k == 2);
      paint = colour;
      gl_Position = vec4((corner - pan) * zoom, 0.0, 1.0);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in vec3 share;
    in vec4 paint;
    uniform float mesh;
    out vec4 colour;
    void main() {
      // Near an edge one of the shares is smaller than its change over a pixel.
      vec3 wide = fwidth(share);
      vec3 away = smoothstep(vec3(0.0), wide * 1.1, share);
      float edge = 1.0 - min(away.x, min(away.y, away.z));
      // Elements of a few pixels have no lines, because the lines would cover them.
      float room = clamp((0.22 - max(wide.x, max(wide.y, wide.z))) * 12.0, 0.0, 1.0);
      colour = vec4(mix(paint.rgb, paint.rgb * 0.45, mesh * edge * room), 1.0);
    }`,
};

const STRIPS = {
  vertex: `#version 300 es
    precision highp float;
    layout(location = 0) in vec2 from;
    layout(location = 1) in vec2 to;
    layout(location = 2) in vec4 colour;
    uniform vec2 pan, zoom, pixel;
    uniform float width, seam;
    out vec4 paint;
    void main() {
      paint = mix(colour, vec4(1.0), seam);
      vec2 a = (from - pan) * zoom / pixel, b = (to - pan) * zoom / pixel;
      float far = length(b - a);
      vec2 along = far > 0.0 ? (b - a) / far : vec2(1.0, 0.0);
      vec2 end = (gl_VertexID >> 1) == 0 ? a - along * width * 0.25 : b + along * width * 0.25;
      float side = float(gl_VertexID & 1) - 0.5;
      gl_Position = vec4((end + vec2(-along.y, along.x) * side * width) * pixel, 0.0, 1.0);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in vec4 paint;
    out vec4 colour;
    void main() { colour = paint; }`,
};

// Height of the legends at the bottom, in pixels.
const FOOT = 76;

class View {
  // Throws an error if WebGL2 is missing.
  constructor(canvas) {
    this.canvas = canvas;
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: true, powerPreference: "high-performance" });
    if (!gl) throw new Error("this browser has no WebGL2");
    this.gl = gl;
    this.triangles = this.program(TRIANGLES, ["pan", "zoom", "mesh"]);
    this.strips = this.program(STRIPS, ["pan", "zoom", "pixel", "width", "seam"]);
    this.buffers = { corners: gl.createBuffer(), colours: gl.createBuffer(), ends: gl.createBuffer(), modes: gl.createBuffer(), outlines: [gl.createBuffer(), gl.createBuffer()], outlineColours: [gl.createBuffer(), gl.createBuffer()] };
    this.ofTriangles = gl.createVertexArray();
    gl.bindVertexArray(this.ofTriangles);
    this.attribute(0, this.buffers.corners, 2, gl.FLOAT, 8, 0, 0);
    this.attribute(1, this.buffers.colours, 4, gl.UNSIGNED_BYTE, 4, 0, 0);
    this.ofStrips = gl.createVertexArray();
    gl.bindVertexArray(this.ofStrips);
    this.attribute(0, this.buffers.ends, 2, gl.FLOAT, 16, 0, 1);
    this.attribute(1, this.buffers.ends, 2, gl.FLOAT, 16, 8, 1);
    this.attribute(2, this.buffers.modes, 4, gl.UNSIGNED_BYTE, 4, 0, 1);
    this.ofOutlines = this.buffers.outlines.map((ends, kind) => {
      const array = gl.createVertexArray();
      gl.bindVertexArray(array);
      this.attribute(0, ends, 2, gl.FLOAT, 16, 0, 1);
      this.attribute(1, ends, 2, gl.FLOAT, 16, 8, 1);
      this.attribute(2, this.buffers.outlineColours[kind], 4, gl.UNSIGNED_BYTE, 4, 0, 1);
      return array;
    });
    gl.bindVertexArray(null);
    this.frame = null;
    this.visible = { cracks: true, outlines: true, mesh: false };
    this.pan = [0, 0];
    this.zoomed = 1;
    this.asked = 0;
    this.afterDraw = () => {};
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  program({ vertex, fragment }, names) {
    const { gl } = this, program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader) || "the browser lost its connection to the graphics card");
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) || "the browser lost its connection to the graphics card");
    const places = { program };
    for (const name of names) places[name] = gl.getUniformLocation(program, name);
    return places;
  }

  attribute(place, buffer, size, type, stride, start, divisor) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, type, type === gl.UNSIGNED_BYTE, stride, start);
    gl.vertexAttribDivisor(place, divisor);
  }

  // Sets the frame, a colour for each corner and a colour for each crack.
  show(frame, colours, modes) {
    const { gl } = this;
    const fill = (buffer, data) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
    };
    if (this.frame !== frame) {
      fill(this.buffers.corners, frame.corners);
      fill(this.buffers.ends, frame.cracks);
      frame.outlines.forEach(({ ends }, kind) => {
        const [r, g, b] = meta.outlines[kind].colour;
        fill(this.buffers.outlines[kind], ends);
        fill(this.buffers.outlineColours[kind], new Uint32Array(ends.length / 4).fill(((255 << 24) | (b << 16) | (g << 8) | r) >>> 0));
      });
      this.frame = frame;
    }
    fill(this.buffers.colours, colours);
    fill(this.buffers.modes, modes);
    this.redraw();
  }

  redraw() {
    if (!this.asked) this.asked = requestAnimationFrame(() => this.draw());
  }

  // Pixels of the page per unit.
  get scale() {
    const { clientWidth, clientHeight } = this.canvas;
    return 0.94 * this.zoomed * Math.min(clientWidth / (2 * meta.view.half[0]), (clientHeight - FOOT) / (2 * meta.view.half[1]));
  }

  draw() {
    cancelAnimationFrame(this.asked);
    this.asked = 0;
    const { gl, canvas } = this, ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(1, Math.round(side * ratio)));
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    gl.viewport(0, 0, width, height);
    const paper = getComputedStyle(document.documentElement).getPropertyValue("--view").trim();
    gl.clearColor(...[1, 3, 5].map((k) => parseInt(paper.slice(k, k + 2), 16) / 255), 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    if (!this.frame) return;
    const pan = [this.pan[0], this.pan[1] - FOOT / 2 / this.scale];
    const pixel = [2 / width, 2 / height], zoom = pixel.map((side) => side * ratio * this.scale);
    gl.useProgram(this.triangles.program);
    gl.uniform2fv(this.triangles.pan, pan);
    gl.uniform2fv(this.triangles.zoom, zoom);
    gl.uniform1f(this.triangles.mesh, this.visible.mesh ? 1 : 0);
    gl.bindVertexArray(this.ofTriangles);
    gl.drawArrays(gl.TRIANGLES, 0, this.frame.corners.length / 2);
    gl.useProgram(this.strips.program);
    gl.uniform2fv(this.strips.pan, pan);
    gl.uniform2fv(this.strips.zoom, zoom);
    gl.uniform2fv(this.strips.pixel, pixel);
    this.frame.outlines.forEach(({ ends, size }, kind) => {
      const { most, share, least } = meta.outlines[kind], width = Math.min(most, share * size * this.scale);
      if (!this.visible.outlines || !ends.length || width < least) return;
      gl.bindVertexArray(this.ofOutlines[kind]);
      gl.uniform1f(this.strips.width, Math.max(width, 0.5) * ratio);
      gl.uniform1f(this.strips.seam, 0);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, ends.length / 4);
    });
    if (this.visible.cracks && this.frame.about.cracks) {
      gl.bindVertexArray(this.ofStrips);
      for (const [wide, seam] of [[4.2, 1], [2.2, 0]]) {
        gl.uniform1f(this.strips.width, wide * ratio);
        gl.uniform1f(this.strips.seam, seam);
        gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.frame.about.cracks);
      }
    }
    gl.bindVertexArray(null);
    this.afterDraw();
  }

  // Converts units to pixels of the canvas. `unproject` converts back.
  project([x, y]) {
    const { clientWidth, clientHeight } = this.canvas;
    return [clientWidth / 2 + (x - this.pan[0]) * this.scale, (clientHeight - FOOT) / 2 - (y - this.pan[1]) * this.scale];
  }

  unproject([x, y]) {
    const { clientWidth, clientHeight } = this.canvas;
    return [this.pan[0] + (x - clientWidth / 2) / this.scale, this.pan[1] - (y - (clientHeight - FOOT) / 2) / this.scale];
  }

  // Moves the view by pixels.
  move(dx, dy) {
    this.pan = [this.pan[0] - dx / this.scale, this.pan[1] + dy / this.scale];
    this.redraw();
  }

  // Zooms the view about a pixel.
  zoom(factor, x = this.canvas.clientWidth / 2, y = (this.canvas.clientHeight - FOOT) / 2) {
    const before = this.unproject([x, y]);
    this.zoomed = Math.min(2000, Math.max(0.1, this.zoomed * factor));
    const after = this.unproject([x, y]);
    this.pan = [this.pan[0] + before[0] - after[0], this.pan[1] + before[1] - after[1]];
    this.redraw();
  }

  home() {
    this.pan = [0, 0];
    this.zoomed = 1;
    this.redraw();
  }

  corners(k) {
    const c = this.frame.corners.subarray(6 * k, 6 * k + 6);
    return [[c[0], c[1]], [c[2], c[3]], [c[4], c[5]]];
  }

  // Returns the triangle at a pixel, the last that is drawn there, or -1.
  pick(x, y) {
    if (!this.frame) return -1;
    const [px, py] = this.unproject([x, y]), { corners } = this.frame;
    for (let k = corners.length / 6 - 1; k >= 0; k--) {
      const at = 6 * k;
      const side = (a, b) => (corners[at + b] - corners[at + a]) * (py - corners[at + a + 1]) - (corners[at + b + 1] - corners[at + a + 1]) * (px - corners[at + a]);
      const sides = [side(0, 2), side(2, 4), side(4, 0)];
      if ((sides.every((s) => s >= 0) || sides.every((s) => s <= 0)) && sides.some((s) => s !== 0)) return k;
    }
    return -1;
  }
}
