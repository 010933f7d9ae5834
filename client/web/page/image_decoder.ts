/** A decoded image: 8-bit RGBA, alpha not premultiplied, rows from the top. Width 0 if decoding failed. */
export interface DecodedImage {
  rgba: Uint8Array;
  width: number;
  height: number;
}

const kFailed: DecodedImage = { rgba: new Uint8Array(), width: 0, height: 0 };

/**
 * Decodes JPEG and WebP with the browser, and reads the texels back unchanged. A 2D canvas would premultiply
 * alpha and lose the colours of transparent texels, so texels go through a WebGL texture.
 */
export class ImageDecoder8 {
  private canvas: OffscreenCanvas | null = null;
  private gl: WebGL2RenderingContext | null = null;
  private texture: WebGLTexture | null = null;

  async decode(file: Uint8Array<ArrayBuffer>): Promise<DecodedImage> {
    let bitmap: ImageBitmap;
    try {
      bitmap = await createImageBitmap(new Blob([file]), {
        premultiplyAlpha: "none",
        colorSpaceConversion: "none",
      });
    } catch {
      return kFailed;
    }
    try {
      return this.readBack(bitmap) ?? readFromCanvas(bitmap) ?? kFailed;
    } finally {
      bitmap.close();
    }
  }

  private readBack(bitmap: ImageBitmap): DecodedImage | null {
    const gl = this.context();
    if (!gl) return null;
    const { width, height } = bitmap;
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.texture, 0);
    if (gl.checkFramebufferStatus(gl.FRAMEBUFFER) !== gl.FRAMEBUFFER_COMPLETE) return null;
    const rgba = new Uint8Array(width * height * 4);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
    return gl.getError() === gl.NO_ERROR ? { rgba, width, height } : null;
  }

  /** Returns a context with the texture and a framebuffer bound, or null if there is none. */
  private context(): WebGL2RenderingContext | null {
    if (this.gl && !this.gl.isContextLost()) return this.gl;
    if (typeof OffscreenCanvas === "undefined") return null;
    this.canvas = new OffscreenCanvas(1, 1);
    const gl = this.canvas.getContext("webgl2", { antialias: false, depth: false });
    this.gl = gl;
    if (!gl) return null;
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    return gl;
  }
}

/** Reads an image through a 2D canvas: exact for opaque images only. Used if workers have no WebGL. */
function readFromCanvas(bitmap: ImageBitmap): DecodedImage | null {
  if (typeof OffscreenCanvas === "undefined") return null;
  const { width, height } = bitmap;
  const context = new OffscreenCanvas(width, height).getContext("2d");
  if (!context) return null;
  context.drawImage(bitmap, 0, 0);
  const { data } = context.getImageData(0, 0, width, height);
  return { rgba: new Uint8Array(data.buffer), width, height };
}
