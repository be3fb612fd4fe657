// What the views in two and in three dimensions share: programs of the graphics card, buffers, and when they draw.

class Screen {
  // Throws an error if WebGL2 is missing.
  constructor(canvas) {
    this.canvas = canvas;
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: true, powerPreference: "high-performance" });
    if (!gl) throw new Error("this browser has no WebGL2");
    this.gl = gl;
    this.frame = null;
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

  fill(buffer, data) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
  }

  redraw() {
    if (!this.asked) this.asked = requestAnimationFrame(() => this.draw());
  }

  // Begins a drawing: fits the canvas to its place on the page, and clears it. Returns its size in pixels and the pixels for each pixel of the page.
  begin() {
    cancelAnimationFrame(this.asked);
    this.asked = 0;
    const { gl, canvas } = this, ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(1, Math.round(side * ratio)));
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    gl.viewport(0, 0, width, height);
    gl.clearColor(...this.paper(), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    return { width, height, ratio };
  }

  // The colour of the background, from 0 to 1.
  paper() {
    const paper = getComputedStyle(document.documentElement).getPropertyValue("--view").trim();
    return [1, 3, 5].map((k) => parseInt(paper.slice(k, k + 2), 16) / 255);
  }
}

const packedColour = ([r, g, b]) => ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;

// The colours of the joints of a frame that hold: whole ones, then those that soften.
function holdingColours({ holding }) {
  const [whole, softening] = meta.cracks.slice(-2).map(({ colour }) => packedColour(colour));
  return new Uint32Array(holding[0] + holding[1]).fill(whole, 0, holding[0]).fill(softening, holding[0]);
}
