/** A decoded image: 8-bit RGBA, alpha not premultiplied, rows from the top. Width 0 if decoding failed. */
export interface DecodedImage {
  rgba: Uint8Array;
  width: number;
  height: number;
}

const kFailed: DecodedImage = { rgba: new Uint8Array(), width: 0, height: 0 };

/**
 * Decodes JPEG and WebP with the browser, and reads the texels back unchanged. Opaque images go through a 2D
 * canvas in main memory. A canvas would premultiply alpha and lose the colours of transparent texels: images
 * with alpha use a WebGL texture.
 */
export class TileDecoder {
  private gl: WebGL2RenderingContext | null = null;
  private texture: WebGLTexture | null = null;
  private plane: OffscreenCanvasRenderingContext2D | null = null;

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
      const is_opaque = isJpeg(file);
      return (is_opaque ? null : this.readTexture(bitmap)) ?? this.readCanvas(bitmap) ?? kFailed;
    } finally {
      bitmap.close();
    }
  }

  /** Reads an image back through a 2D canvas: exact for opaque images. */
  private readCanvas(bitmap: ImageBitmap): DecodedImage | null {
    const { width, height } = bitmap;
    this.plane ??= new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
    if (!this.plane) return null;
    const { canvas } = this.plane;
    if (canvas.width < width || canvas.height < height) {
      canvas.width = Math.max(canvas.width, width);
      canvas.height = Math.max(canvas.height, height);
    }
    this.plane.globalCompositeOperation = "copy";
    this.plane.drawImage(bitmap, 0, 0);
    const { data } = this.plane.getImageData(0, 0, width, height);
    return { rgba: new Uint8Array(data.buffer), width, height };
  }

  /** Reads an image back through a WebGL texture. @returns null if workers have no WebGL. */
  private readTexture(bitmap: ImageBitmap): DecodedImage | null {
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
    const gl = new OffscreenCanvas(1, 1).getContext("webgl2", { antialias: false, depth: false });
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

/** Returns true for the first bytes of a JPEG file. JPEG has no alpha. */
function isJpeg(file: Uint8Array): boolean {
  return file[0] === 0xff && file[1] === 0xd8;
}
