"""The picture that a page has drawn on its canvas.

It is read from the canvas. A screenshot would not do: the browser blends the round corners of the view with what is behind them, and does so differently when it paints the page
again in parts, so that two screenshots of one drawing differ by a few pixels.
"""

# Runs before the page. A browser may forget a drawing once it is on the screen; this one keeps it until the page draws again.
KEPT = """{
  const get = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, options) { return get.call(this, kind, { ...options, preserveDrawingBuffer: true }); };
}"""


def picture(page):
    """What the page last drew, exactly. Draws nothing, but waits until a drawing that the page has asked for is done."""
    return page.evaluate(
        """new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))).then(() => document.getElementById("canvas").toDataURL())"""
    )


# Runs before the page: counts in `uploads` how often it sends data to the graphics card.
UPLOADS = """{
  window.uploads = 0;
  for (const name of ["bufferData", "bufferSubData", "texImage2D", "texSubImage2D"]) {
    const send = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...all) { window.uploads++; return send.apply(this, all); };
  }
}"""
