// The view in three dimensions: facets, sections, and lines as strips of constant width. The projection is parallel, so that sizes hold at every depth.

const SURFACE = {
  vertex: `#version 300 es
    precision highp float;
    layout(location = 0) in vec3 corner;
    layout(location = 1) in vec4 colour;
    uniform mat3 turn;
    uniform vec2 pan, zoom;
    uniform float deep;
    uniform vec4 plane;
    out vec3 place, share, paint;
    out float beyond;
    void main() {
      // The alpha of the colour has a bit for each edge that is an edge of the facet.
      int k = gl_VertexID % 3, real = int(colour.a * 255.0 + 0.5);
      share = vec3(k == 0, k == 1, k == 2) + vec3((real & 1) == 0, (real & 2) == 0, (real & 4) == 0);
      paint = colour.rgb;
      place = turn * corner;
      beyond = dot(plane.xyz, corner) - plane.w;
      gl_Position = vec4((place.xy - pan) * zoom, -place.z * deep, 1.0);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in vec3 place, share, paint;
    in float beyond;
    uniform float mesh, opacity;
    uniform int kind;
    uniform bool open;
    const int OUTSIDE = 0, SECTION = 1;
    out vec4 colour;
    void main() {
      if (kind != SECTION && beyond > 0.0) discard;
      vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
      normal *= normal.z < 0.0 ? -1.0 : 1.0;
      // Soft light from above left; a section is lit evenly.
      float light = kind == SECTION ? 0.97 : 0.80 + 0.22 * dot(normal, vec3(-0.35, 0.75, 0.5612));
      vec3 lit = paint * light;
      // The inside of a surface that is cut open.
      if (kind == OUTSIDE && open && !gl_FrontFacing) lit = mix(lit, vec3(0.42), 0.5) * 0.8;
      vec3 wide = fwidth(share);
      vec3 away = smoothstep(vec3(0.0), wide * 1.1, share);
      float edge = 1.0 - min(away.x, min(away.y, away.z));
      // Elements of a few pixels have no lines, because the lines would cover them.
      float room = clamp((0.22 - max(wide.x, max(wide.y, wide.z))) * 12.0, 0.0, 1.0);
      colour = vec4(mix(lit, lit * 0.5, mesh * edge * room), opacity);
    }`,
};

const LINES = {
  vertex: `#version 300 es
    precision highp float;
    layout(location = 0) in vec3 from;
    layout(location = 1) in vec3 to;
    layout(location = 2) in vec4 colour;
    uniform mat3 turn;
    uniform vec2 pan, zoom, pixel;
    uniform float deep, width, lift;
    // A colour for all, and its share.
    uniform vec4 tint;
    uniform vec4 plane;
    out vec4 paint;
    out float beyond;
    void main() {
      paint = vec4(mix(colour.rgb, tint.rgb, tint.a), 1.0);
      vec3 p = turn * from, q = turn * to;
      vec2 a = (p.xy - pan) * zoom / pixel, b = (q.xy - pan) * zoom / pixel;
      float far = length(b - a);
      vec2 along = far > 0.0 ? (b - a) / far : vec2(1.0, 0.0);
      bool last = (gl_VertexID >> 1) == 1;
      // Lines that meet at an angle overlap a little; seams are not longer than their lines.
      vec2 more = along * (tint.a == 0.0 ? 0.25 * width : 0.0);
      vec2 end = last ? b + more : a - more;
      float side = float(gl_VertexID & 1) - 0.5;
      beyond = dot(plane.xyz, last ? to : from) - plane.w;
      gl_Position = vec4((end + vec2(-along.y, along.x) * side * width) * pixel, -((last ? q.z : p.z) + lift) * deep, 1.0);
    }`,
  fragment: `#version 300 es
    precision highp float;
    in vec4 paint;
    in float beyond;
    uniform float opacity, slack;
    out vec4 colour;
    void main() {
      if (beyond > slack) discard;
      colour = vec4(paint.rgb, opacity);
    }`,
};

// Kinds of triangles, as in the shader.
const OUTSIDE = 0, SECTION = 1, CRACK = 2;

// Height of the legends at the bottom, in pixels.
const FOOT = 76;
// Nothing is beyond this plane.
const NOWHERE_CUT = [0, 0, 0, 1e9];
// Directions of the view at the beginning: from the front, the right and above.
const HOME = { yaw: Math.PI / 6, pitch: Math.PI / 9 };
// Opacity of a solid that lets the cracks inside be seen.
const TRANSLUCENT = 0.09;

// More lines than this are drawn one pixel wide, which is faster.
const MOST_STRIPS = 30000;
// Tints of lines.
const AS_GIVEN = [0, 0, 0, 0], WHITE = [1, 1, 1, 1], PALE_LINES = [0.75, 0.79, 0.84, 1];

const coloured = (colour, edges) => ((colour & 0xffffff) | (edges << 24)) >>> 0;

class View extends Screen {
  constructor(canvas) {
    super(canvas);
    const { gl } = this, uniforms = ["turn", "pan", "zoom", "deep", "plane"];
    this.surface = this.program(SURFACE, [...uniforms, "mesh", "opacity", "kind", "open"]);
    this.strips = this.program(LINES, [...uniforms, "pixel", "width", "tint", "lift", "opacity", "slack"]);
    // Triangles: the surface, the section, the facets of cracks, and joints that hold.
    const triangles = () => {
      const array = gl.createVertexArray(), corners = gl.createBuffer(), colours = gl.createBuffer();
      gl.bindVertexArray(array);
      this.attribute(0, corners, 3, gl.FLOAT, 12, 0, 0);
      this.attribute(1, colours, 4, gl.UNSIGNED_BYTE, 4, 0, 0);
      return { array, corners, colours, count: 0 };
    };
    const strips = () => {
      const array = gl.createVertexArray(), ends = gl.createBuffer(), colours = gl.createBuffer();
      gl.bindVertexArray(array);
      this.attribute(0, ends, 3, gl.FLOAT, 24, 0, 1);
      this.attribute(1, ends, 3, gl.FLOAT, 24, 12, 1);
      this.attribute(2, colours, 4, gl.UNSIGNED_BYTE, 4, 0, 1);
      // The same lines one pixel wide, for many: both ends of each are vertices.
      const thin = gl.createVertexArray(), ofEnds = gl.createBuffer();
      gl.bindVertexArray(thin);
      for (const place of [0, 1]) this.attribute(place, ends, 3, gl.FLOAT, 12, 0, 0);
      this.attribute(2, ofEnds, 4, gl.UNSIGNED_BYTE, 4, 0, 0);
      return { array, ends, colours, thin, ofEnds, count: 0, length: 0 };
    };
    this.triangles = { surface: triangles(), section: triangles(), cracks: triangles(), intact: triangles() };
    this.lines = { angles: strips(), borders: strips(), traces: strips(), section: strips(), sectionCracks: strips() };
    gl.bindVertexArray(null);
    this.visible = { cracks: true, intact: false, outlines: true, mesh: false };
    this.grains = meta.spheres ? new Grains(this, false) : null;
    // The solid is "opaque", "translucent" or "hidden".
    this.solid = "opaque";
    // Distance of the fragments from their places, over their distances from the middle.
    this.exploded = 0;
    this.hiddenBodies = new Set();
    this.plane = NOWHERE_CUT;
    this.modeColour = (mode) => meta.cracks[mode].colour;
    this.built = null;
    this.cut = null;
    this.home();
  }

  // Sets the frame and a colour for each element.
  show(frame, colours) {
    if (this.frame !== frame) this.built = null;
    this.grains?.set(frame.grains);
    this.frame = frame;
    this.colours = colours;
    if (!this.built) this.build();
    this.paintTriangles();
    if (this.cut) this.paintSection();
    this.redraw();
  }

  // The form has changed: the next drawing builds it again.
  changed() {
    this.built = null;
    if (this.frame) this.show(this.frame, this.colours);
  }

  // Sets the plane of the cut. The next drawing makes the section, however often the plane has moved until then.
  setPlane(plane) {
    this.plane = plane;
    this.cut = null;
    this.redraw();
  }

  shown(element) {
    return !this.hiddenBodies.size || !this.hiddenBodies.has(this.frame.body[element]);
  }

  // Writes the corners of an element, with its fragment at its place, to an array.
  place(element, to, at = 0) {
    const { corners, fragment } = this.frame, first = 12 * element, offset = 3 * fragment[element];
    for (let k = 0; k < 12; k++) to[at + k] = corners[first + k] + (this.offsets ? this.offsets[offset + (k % 3)] : 0);
  }

  // The offsets of fragments: away from the middle of all.
  spread() {
    this.offsets = null;
    if (!(this.exploded > 0) || !this.frame.n) return;
    const { corners, fragment, surface } = this.frame, count = this.frame.about.fragments, sums = new Float64Array(3 * count), sizes = new Float64Array(count);
    for (let element = 0; element < surface; element++) {
      const of = fragment[element];
      sizes[of]++;
      for (let k = 0; k < 12; k++) sums[3 * of + (k % 3)] += corners[12 * element + k] / 4;
    }
    const middle = [0, 0, 0];
    for (let of = 0; of < count; of++) for (let axis = 0; axis < 3; axis++) middle[axis] += sums[3 * of + axis] / surface;
    this.offsets = new Float32Array(3 * count);
    for (let of = 0; of < count; of++) {
      if (sizes[of]) for (let axis = 0; axis < 3; axis++) this.offsets[3 * of + axis] = this.exploded * (sums[3 * of + axis] / sizes[of] - middle[axis]);
    }
  }

  // Makes the facets and lines of the frame.
  build() {
    const { frame } = this, { surface, marks, modes } = frame, at = new Float32Array(12);
    this.spread();
    this.cut = null;
    const facets = new Float32Array(9 * frame.about.facets), owners = new Uint32Array(frame.about.facets);
    const angles = new Growing(Float32Array), borders = new Growing(Float32Array);
    const cracks = new Growing(Float32Array), crackOwners = new Growing(Uint32Array);
    let count = 0, radius = 1;
    for (let element = 0; element < surface; element++) {
      if (!this.shown(element)) continue;
      this.place(element, at);
      for (let k = 0; k < 4; k++) {
        if (!((marks[element] >> k) & 1)) continue;
        const [p, q, r] = FACETS[k];
        if (modes[4 * element + k]) {
          crackOwners.push(4 * element + k);
          cracks.push(at[3 * p], at[3 * p + 1], at[3 * p + 2], at[3 * q], at[3 * q + 1], at[3 * q + 2], at[3 * r], at[3 * r + 1], at[3 * r + 2]);
          continue;
        }
        owners[count] = element;
        const to = 9 * count++;
        for (let axis = 0; axis < 3; axis++) {
          facets[to + axis] = at[3 * p + axis];
          facets[to + 3 + axis] = at[3 * q + axis];
          facets[to + 6 + axis] = at[3 * r + axis];
        }
      }
      for (let k = 0; k < 12; k += 3) radius = Math.max(radius, at[k] ** 2 + at[k + 1] ** 2 + at[k + 2] ** 2);
      if (marks[element] >> 4 === 0) continue;
      for (let k = 0; k < 6; k++) {
        const lines = (marks[element] >> (4 + k)) & 1 ? angles : (marks[element] >> (10 + k)) & 1 ? borders : null;
        if (!lines) continue;
        const [p, q] = EDGES[k];
        lines.push(at[3 * p], at[3 * p + 1], at[3 * p + 2], at[3 * q], at[3 * q + 1], at[3 * q + 2]);
      }
    }
    this.radius = Math.max(Math.sqrt(radius), this.grains?.radius ?? 0) * 1.01;
    // Facets on the outside come first: a translucent solid has only those.
    this.outside = count;
    facets.set(cracks.all, 9 * count);
    crackOwners.all.forEach((facet, k) => { owners[count + k] = facet >> 2; });
    count += crackOwners.length;
    this.facets = facets.subarray(0, 9 * count);
    this.owners = owners.subarray(0, count);
    this.crackFacets = cracks.all;
    this.crackOwners = crackOwners.all;
    this.fill(this.triangles.surface.corners, this.facets);
    this.fill(this.triangles.cracks.corners, this.crackFacets);
    [this.intactCorners, this.intactColours] = this.holdingJoints();
    this.fill(this.triangles.intact.corners, this.intactCorners);
    this.setLines(this.lines.angles, angles.all, meta.outlines[1].colour);
    this.setLines(this.lines.borders, borders.all, meta.outlines[0].colour);
    const [traces, ofTraces] = this.traces();
    this.setLines(this.lines.traces, traces.all);
    this.traceModes = ofTraces.all;
    this.built = frame;
  }

  // The corners of the joints that hold, of the bodies that are shown, each moved with its fragment, and their
  // colours.
  holdingJoints() {
    const { count, corners, body, fragment } = this.frame.intact, all = new Growing(Float32Array), colours = new Growing(Uint32Array);
    const each = holdingColours(this.frame.about);
    for (let joint = 0; joint < count; joint++) {
      if (this.hiddenBodies.has(body[joint])) continue;
      colours.push(each[joint]);
      for (let k = 0; k < 9; k++) all.push(corners[9 * joint + k] + (this.offsets ? this.offsets[3 * fragment[joint] + (k % 3)] : 0));
    }
    return [all.all, colours.all];
  }

  // The edges at which cracks end on the surface, and their modes.
  traces() {
    const { frame } = this, { sides, codes, count } = frame.cracks, at = new Float32Array(12), lines = new Growing(Float32Array), modes = new Growing(Uint8Array);
    for (let side = 0; side < 2; side++) {
      for (let c = 0; c < count; c++) {
        const bits = (codes[c] >> (4 + 3 * side)) & 7, element = sides[side][c] >> 2;
        if (!bits || !this.shown(element)) continue;
        const corners = FACETS[sides[side][c] & 3], turn = (codes[c] >> 2) & 3;
        // The corners of side 1 are in the opposite order, from the one that is first on side 0.
        const corner = (k) => 3 * corners[side === 0 ? k % 3 : (turn + 3 - (k % 3)) % 3];
        this.place(element, at);
        for (let k = 0; k < 3; k++) {
          if (!((bits >> k) & 1)) continue;
          const p = corner(k), q = corner(k + 1);
          lines.push(at[p], at[p + 1], at[p + 2], at[q], at[q + 1], at[q + 2]);
          modes.push((codes[c] & 3) + 1);
        }
      }
    }
    return [lines, modes];
  }

  setLines(lines, ends, colour = null) {
    lines.count = ends.length / 6;
    this.fill(lines.ends, ends);
    if (colour) this.colourLines(lines, new Uint32Array(lines.count).fill(packedColour(colour)));
    let length = 0;
    for (let k = 0; k < ends.length; k += 6) length += Math.hypot(ends[k + 3] - ends[k], ends[k + 4] - ends[k + 1], ends[k + 5] - ends[k + 2]);
    lines.length = lines.count ? length / lines.count : 0;
  }

  colourLines(lines, colours) {
    this.fill(lines.colours, colours);
    if (colours.length <= MOST_STRIPS) return;
    const ofEnds = new Uint32Array(2 * colours.length);
    for (let k = 0; k < ofEnds.length; k++) ofEnds[k] = colours[k >> 1];
    this.fill(lines.ofEnds, ofEnds);
  }

  // Makes the section of the frame by the plane.
  slice() {
    const { frame } = this, none = { corners: new Float32Array(0), owners: [], edges: [], lines: new Float32Array(0), modes: new Uint8Array(0) };
    const cut = this.plane !== NOWHERE_CUT && frame.solid ? section(frame, this.plane, (element) => this.shown(element), (element, to) => this.place(element, to), !this.offsets) : none;
    this.cut = cut;
    this.fill(this.triangles.section.corners, cut.corners);
    const modes = cut.modes.filter((mode) => mode), whole = new Float32Array(6 * (cut.modes.length - modes.length)), cracked = new Float32Array(6 * modes.length);
    let wholes = 0, cracks = 0;
    for (let k = 0; k < cut.lines.length; k++) {
      if (cut.modes[Math.floor(k / 6)]) cracked[cracks++] = cut.lines[k];
      else whole[wholes++] = cut.lines[k];
    }
    this.setLines(this.lines.section, whole, meta.outlines[1].colour);
    this.setLines(this.lines.sectionCracks, cracked);
    this.sectionModes = modes;
    this.paintSection();
  }

  // Sets the colours of triangles: `colour` returns that of triangle k.
  paintEach(target, count, colour) {
    const all = new Uint32Array(3 * count);
    for (let k = 0; k < count; k++) all[3 * k] = all[3 * k + 1] = all[3 * k + 2] = colour(k);
    this.fill(target.colours, all);
    target.count = count;
  }

  paintSection() {
    const { owners, edges } = this.cut;
    this.paintEach(this.triangles.section, owners.length, (k) => coloured(this.colours[owners[k]], edges[k]));
    const ofLines = meta.cracks.map((_, mode) => packedColour(this.modeColour(mode)));
    this.colourLines(this.lines.sectionCracks, Uint32Array.from(this.sectionModes, (mode) => ofLines[mode - 1]));
  }

  paintTriangles() {
    const { surface, cracks, intact } = this.triangles, { colours } = this;
    this.paintEach(intact, this.intactColours.length, (k) => coloured(this.intactColours[k], 7));
    this.paintEach(surface, this.owners.length, (k) => coloured(colours[this.owners[k]], 7));
    // Dark colours are made lighter, so that the light on them is seen.
    const modes = meta.cracks.map((_, mode) => packedColour(this.modeColour(mode).map((x) => Math.round(x + 0.16 * (255 - x)))));
    this.paintEach(cracks, this.crackOwners.length, (k) => coloured(modes[this.frame.modes[this.crackOwners[k]] - 1], 7));
    const ofLines = meta.cracks.map((_, mode) => packedColour(this.modeColour(mode)));
    this.colourLines(this.lines.traces, Uint32Array.from(this.traceModes, (mode) => ofLines[mode - 1]));
  }

  // Directions to the right, up and towards the eye, as rows.
  turn(yaw = this.yaw, pitch = this.pitch) {
    const [s, c, t, u] = [Math.sin(yaw), Math.cos(yaw), Math.sin(pitch), Math.cos(pitch)];
    return [[c, s, 0], [-t * s, t * c, u], [u * s, -u * c, t]];
  }

  // Pixels of the page per unit: all frames fit into the view at its first direction.
  get scale() {
    const { clientWidth, clientHeight } = this.canvas, rows = this.turn(HOME.yaw, HOME.pitch);
    const [wide, high] = [0, 1].map((row) => meta.view.half.reduce((sum, half, axis) => sum + Math.abs(rows[row][axis]) * half, 0));
    return 0.9 * this.zoomed * Math.min(clientWidth / (2 * wide), (clientHeight - FOOT) / (2 * high));
  }

  draw() {
    const { gl } = this, { width, height, ratio } = this.begin();
    if (!this.frame) return;
    if (!this.cut) this.slice();
    const { scale } = this, pan = [this.pan[0], this.pan[1] - FOOT / 2 / scale];
    const pixel = [2 / width, 2 / height], zoom = pixel.map((side) => side * ratio * scale), deep = 0.98 / this.radius;
    for (const program of [this.surface, this.strips]) {
      gl.useProgram(program.program);
      // The rows are given as columns.
      gl.uniformMatrix3fv(program.turn, true, this.turn().flat());
      gl.uniform2fv(program.pan, pan);
      gl.uniform2fv(program.zoom, zoom);
      gl.uniform1f(program.deep, deep);
      gl.uniform4fv(program.plane, this.plane);
    }
    gl.uniform2fv(this.strips.pixel, pixel);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);

    const opaque = this.solid === "opaque", { surface, section: ofSection, cracks, intact } = this.triangles;
    gl.useProgram(this.surface.program);
    gl.uniform1i(this.surface.open, this.plane === NOWHERE_CUT ? 0 : 1);
    gl.uniform1f(this.surface.mesh, this.visible.mesh ? 1 : 0);
    const draw = (triangles, kind, opacity, count = triangles.count) => {
      if (!count) return;
      gl.uniform1i(this.surface.kind, kind);
      gl.uniform1f(this.surface.opacity, opacity);
      gl.bindVertexArray(triangles.array);
      gl.drawArrays(gl.TRIANGLES, 0, 3 * count);
    };
    // Lines are before the facets that they bound.
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    if (opaque) {
      draw(surface, OUTSIDE, 1);
      draw(ofSection, SECTION, 1);
    } else if (this.visible.cracks) draw(cracks, CRACK, 1);
    // An opaque solid hides all but those in its gaps.
    if (this.visible.intact) draw(intact, CRACK, 1);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    if (this.grains) {
      this.grains.draw({ turn: this.turn(), pan, zoom, pixel, deep, plane: this.plane, ratio });
      gl.enable(gl.DEPTH_TEST);
      gl.useProgram(this.surface.program);
    }
    if (this.solid === "translucent") {
      gl.enable(gl.BLEND);
      gl.depthMask(false);
      draw(surface, OUTSIDE, TRANSLUCENT, this.outside);
      draw(ofSection, SECTION, 2 * TRANSLUCENT);
      gl.depthMask(true);
      gl.disable(gl.BLEND);
    }

    gl.useProgram(this.strips.program);
    gl.enable(gl.BLEND);
    const strips = (lines, wide, lift, opacity, slack = 0, tint = AS_GIVEN) => {
      if (!lines.count) return;
      gl.uniform1f(this.strips.width, wide * ratio);
      gl.uniform4fv(this.strips.tint, tint);
      gl.uniform1f(this.strips.opacity, opacity);
      gl.uniform1f(this.strips.lift, lift / scale);
      gl.uniform1f(this.strips.slack, slack);
      if (lines.count > MOST_STRIPS) {
        gl.uniform1f(this.strips.width, 0);
        gl.bindVertexArray(lines.thin);
        gl.drawArrays(gl.LINES, 0, 2 * lines.count);
        return;
      }
      gl.bindVertexArray(lines.array);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, lines.count);
    };
    const { angles, borders, traces, section: around, sectionCracks } = this.lines;
    if (this.visible.outlines) {
      // Where no facets are behind them, lines differ from the background.
      const tint = opaque || this.paper()[0] > 0.5 ? AS_GIVEN : PALE_LINES;
      // Lines that are as near to each other as they are wide would only darken the colours.
      for (const [lines, most] of [[angles, meta.outlines[1].most], [borders, meta.outlines[0].most]]) {
        const wide = Math.min(most, 0.2 * lines.length * scale);
        if (wide >= 0.2) strips(lines, Math.max(wide, 0.5), 0.6, Math.min(1, 2 * wide) * (opaque ? 1 : 0.4), 0, tint);
      }
      strips(around, 1.3, 0.6, opaque ? 1 : 0.5, 1e-4, tint);
    }
    if (this.visible.cracks && opaque) {
      // Cracks are before the outlines, and their seams between both.
      for (const [wide, lift, tint] of [[3.4, 1, WHITE], [1.9, 1.4, AS_GIVEN]]) {
        // Seams hide no lines.
        gl.depthMask(tint === AS_GIVEN);
        strips(traces, wide, lift, 1, 0, tint);
        strips(sectionCracks, wide, lift, 1, 1e-4, tint);
      }
    }
    gl.disable(gl.BLEND);
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(null);
    this.afterDraw();
  }

  // Converts a point to pixels of the canvas, and units towards the eye.
  project([x, y, z]) {
    const { clientWidth, clientHeight } = this.canvas, [u, v, w] = this.turn().map((row) => row[0] * x + row[1] * y + row[2] * z);
    return [clientWidth / 2 + (u - this.pan[0]) * this.scale, (clientHeight - FOOT) / 2 - (v - this.pan[1]) * this.scale, w];
  }

  // Converts a pixel of the canvas to units to the right and up.
  unproject([x, y]) {
    const { clientWidth, clientHeight } = this.canvas;
    return [this.pan[0] + (x - clientWidth / 2) / this.scale, this.pan[1] - (y - (clientHeight - FOOT) / 2) / this.scale];
  }

  rotate(yaw, pitch) {
    this.yaw += yaw;
    this.pitch = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, this.pitch + pitch));
    this.redraw();
  }

  // Moves the view by pixels.
  move(dx, dy) {
    this.pan = [this.pan[0] - dx / this.scale, this.pan[1] + dy / this.scale];
    this.redraw();
  }

  // Zooms the view about a pixel.
  zoom(factor, x = this.canvas.clientWidth / 2, y = (this.canvas.clientHeight - FOOT) / 2) {
    const before = this.unproject([x, y]);
    this.zoomed = Math.min(2000, Math.max(0.05, this.zoomed * factor));
    const after = this.unproject([x, y]);
    this.pan = [this.pan[0] + before[0] - after[0], this.pan[1] + before[1] - after[1]];
    this.redraw();
  }

  home() {
    Object.assign(this, HOME, { pan: [0, 0], zoomed: 1 });
    this.redraw();
  }

  drag(dx, dy, moves) {
    if (moves) this.move(dx, dy);
    else this.rotate(-dx * 0.008, dy * 0.008);
  }

  arrow([x, y], moves) {
    if (moves) this.move(40 * x, 40 * y);
    else this.rotate(-x * 0.12, y * 0.12);
  }

  // Corners of the polygons around element k, in pixels of the canvas.
  around(k) {
    const at = new Float32Array(12);
    this.place(k, at);
    return FACETS.map((corners) => corners.map((corner) => this.project(at.subarray(3 * corner, 3 * corner + 3)).slice(0, 2)));
  }

  // The centroid of element k.
  centroid(k) {
    const { corners } = this.frame, at = 12 * k;
    return [0, 1, 2].map((axis) => (corners[at + axis] + corners[at + 3 + axis] + corners[at + 6 + axis] + corners[at + 9 + axis]) / 4);
  }

  // Returns the element at a pixel, the nearest to the eye of what is drawn there, or -1.
  pick(x, y) {
    if (!this.frame) return -1;
    if (!this.cut) this.slice();
    this.pickedDepth = -Infinity;
    const [u, v] = this.unproject([x, y]), [right, up, toward] = this.turn(), [a, b, c, d] = this.plane;
    let found = -1, nearest = -Infinity;
    const search = (corners, owner, cut) => {
      const flat = (row, at) => row[0] * corners[at] + row[1] * corners[at + 1] + row[2] * corners[at + 2];
      for (let at = 0, k = 0; at < corners.length; at += 9, k++) {
        const px = flat(right, at) - u, py = flat(up, at) - v, qx = flat(right, at + 3) - u, qy = flat(up, at + 3) - v, rx = flat(right, at + 6) - u, ry = flat(up, at + 6) - v;
        const i = qx * ry - rx * qy, j = rx * py - px * ry, l = px * qy - qx * py;
        if ((i < 0 || j < 0 || l < 0) && (i > 0 || j > 0 || l > 0)) continue;
        const sum = i + j + l;
        if (sum === 0) continue;
        const depth = (i * flat(toward, at) + j * flat(toward, at + 3) + l * flat(toward, at + 6)) / sum;
        if (depth <= nearest) continue;
        // What is beyond the plane has been cut away.
        if (cut) {
          const point = [0, 1, 2].map((axis) => u * right[axis] + v * up[axis] + depth * toward[axis]);
          if (a * point[0] + b * point[1] + c * point[2] > d) continue;
        }
        nearest = depth;
        found = owner(k);
      }
    };
    if (this.solid === "opaque" || !this.visible.cracks) {
      if (this.solid === "hidden") return -1;
      search(this.facets, (k) => this.owners[k], true);
      search(this.cut.corners, (k) => this.cut.owners[k], false);
    } else search(this.crackFacets, (k) => this.crackOwners[k] >> 2, true);
    this.pickedDepth = nearest;
    return found;
  }

  // Returns the sphere at a pixel, the nearest to the eye, or -1 if it is behind the element that `pick` has found there.
  pickSphere(x, y) {
    const { sphere, depth } = this.grains.pick(this.unproject([x, y]), this.turn(), this.plane);
    return depth > this.pickedDepth ? sphere : -1;
  }

  // The axes: at the lower right, or at the upper left where the legends take the whole width.
  furniture() {
    const { clientWidth, clientHeight } = this.canvas, middle = clientWidth < 700 ? [48, 52] : [clientWidth - 52, clientHeight - 46], rows = this.turn(), parts = [];
    const axes = ["x", "y", "z"].map((name, axis) => ({ name, to: [30 * rows[0][axis], -30 * rows[1][axis]], near: rows[2][axis] }));
    for (const { name, to, near } of axes.sort((one, other) => one.near - other.near)) {
      const end = middle.map((x, k) => x + to[k]), far = Math.hypot(...to) || 1;
      parts.push(svg("line", { class: "axis", x1: middle[0], y1: middle[1], x2: end[0].toFixed(1), y2: end[1].toFixed(1) }));
      const at = end.map((x, k) => x + (Math.hypot(...to) > 6 ? (9 * to[k]) / far : k === 0 ? 9 : -9));
      parts.push(svg("text", { class: "axis", x: at[0].toFixed(1), y: (at[1] + 4).toFixed(1) }, name));
    }
    return parts;
  }
}
