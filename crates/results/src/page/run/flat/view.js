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

class View extends Screen {
  constructor(canvas) {
    super(canvas);
    const { gl } = this;
    this.triangles = this.program(TRIANGLES, ["pan", "zoom", "mesh"]);
    this.strips = this.program(STRIPS, ["pan", "zoom", "pixel", "width", "seam"]);
    this.buffers = { corners: gl.createBuffer(), colours: gl.createBuffer(), ends: gl.createBuffer(), modes: gl.createBuffer(), intact: gl.createBuffer(), intactColours: gl.createBuffer(), outlines: [gl.createBuffer(), gl.createBuffer()], outlineColours: [gl.createBuffer(), gl.createBuffer()] };
    this.ofTriangles = gl.createVertexArray();
    gl.bindVertexArray(this.ofTriangles);
    this.attribute(0, this.buffers.corners, 2, gl.FLOAT, 8, 0, 0);
    this.attribute(1, this.buffers.colours, 4, gl.UNSIGNED_BYTE, 4, 0, 0);
    const strips = (ends, colours) => {
      const array = gl.createVertexArray();
      gl.bindVertexArray(array);
      this.attribute(0, ends, 2, gl.FLOAT, 16, 0, 1);
      this.attribute(1, ends, 2, gl.FLOAT, 16, 8, 1);
      this.attribute(2, colours, 4, gl.UNSIGNED_BYTE, 4, 0, 1);
      return array;
    };
    this.ofStrips = strips(this.buffers.ends, this.buffers.modes);
    this.ofIntact = strips(this.buffers.intact, this.buffers.intactColours);
    this.ofOutlines = this.buffers.outlines.map((ends, kind) => strips(ends, this.buffers.outlineColours[kind]));
    gl.bindVertexArray(null);
    this.grains = meta.spheres ? new Grains(this, true) : null;
    this.visible = { cracks: true, intact: false, outlines: true, mesh: false };
    this.pan = [0, 0];
    this.zoomed = 1;
  }

  // Sets the frame and a colour for each element.
  show(frame, colours) {
    if (this.frame !== frame) {
      this.fill(this.buffers.corners, frame.corners);
      this.fill(this.buffers.ends, frame.cracks);
      this.fill(this.buffers.intact, frame.intact);
      this.fill(this.buffers.intactColours, holdingColours(frame.about));
      frame.outlines.forEach(({ ends }, kind) => {
        this.fill(this.buffers.outlines[kind], ends);
        this.fill(this.buffers.outlineColours[kind], new Uint32Array(ends.length / 4).fill(packedColour(meta.outlines[kind].colour)));
      });
      this.grains?.set(frame.grains);
      this.frame = frame;
    }
    const ofCorners = new Uint32Array(3 * colours.length);
    colours.forEach((colour, k) => ofCorners.fill(colour, 3 * k, 3 * k + 3));
    this.fill(this.buffers.colours, ofCorners);
    this.fill(this.buffers.modes, Uint32Array.from(frame.modes, (mode) => packedColour(meta.cracks[mode].colour)));
    this.redraw();
  }

  // Pixels of the page per unit.
  get scale() {
    const { clientWidth, clientHeight } = this.canvas;
    return 0.94 * this.zoomed * Math.min(clientWidth / (2 * meta.view.half[0]), (clientHeight - FOOT) / (2 * meta.view.half[1]));
  }

  draw() {
    const { gl } = this, { width, height, ratio } = this.begin();
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
    if (this.visible.intact && this.frame.intact.length) {
      gl.bindVertexArray(this.ofIntact);
      gl.uniform1f(this.strips.width, 1.6 * ratio);
      gl.uniform1f(this.strips.seam, 0);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.frame.intact.length / 4);
    }
    if (this.visible.cracks && this.frame.about.cracks) {
      gl.bindVertexArray(this.ofStrips);
      for (const [wide, seam] of [[4.2, 1], [2.2, 0]]) {
        gl.uniform1f(this.strips.width, wide * ratio);
        gl.uniform1f(this.strips.seam, seam);
        gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.frame.about.cracks);
      }
    }
    gl.bindVertexArray(null);
    this.grains?.draw({ turn: this.turn(), pan, zoom, pixel, deep: 1e-3, plane: [0, 0, 0, 1e9], ratio });
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

  // Directions to the right, up and towards the eye, as rows.
  turn() {
    return [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  }

  // Returns the disc at a pixel, the last that is drawn there, or -1.
  pickSphere(x, y) {
    return this.grains.pick(this.unproject([x, y]), this.turn(), [0, 0, 0, 1e9]).sphere;
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

  // Corners of the polygons around element k, in pixels of the canvas.
  around(k) {
    return [this.corners(k).map((corner) => this.project(corner))];
  }

  // The centroid of element k.
  centroid(k) {
    const c = this.corners(k);
    return [0, 1].map((axis) => (c[0][axis] + c[1][axis] + c[2][axis]) / 3);
  }

  drag(dx, dy) {
    this.move(dx, dy);
  }

  arrow([x, y]) {
    this.move(40 * x, 40 * y);
  }
}
