import { ExternalTexture, type WebGLRenderer } from "three";
import type { TextureState } from "./contract";
import type { CoreModel } from "./core_model";

const kTilePx = 512;
const kTableWidth = 1024; // words per row of the table, as in the shader

/**
 * The texture tiles of a model: layers of an array texture, and the table in which the shader looks tiles up.
 * They are plain WebGL textures, because three.js cannot upload a part of a layer.
 */
export class TileTextures {
  readonly layers = new ExternalTexture();
  readonly table = new ExternalTexture();
  private readonly gl: WebGL2RenderingContext;
  private layer_count = 0;
  private table_rows = 0;
  private serial = -1;

  constructor(
    private readonly model: CoreModel,
    private readonly renderer: WebGLRenderer,
  ) {
    this.gl = renderer.getContext() as WebGL2RenderingContext;
    this.resize(1);
    this.setTable(new Uint32Array(1));
  }

  /** Uploads new tiles, then the table that refers to them. @returns true if the picture may change. */
  update(serial: number): boolean {
    if (serial === this.serial) return false;
    this.serial = serial;
    const state: TextureState | null = this.model.textures();
    if (!state) return false;
    if (state.layers > this.layer_count) this.resize(state.layers);
    this.uploadTiles();
    this.setTable(this.model.textureTable());
    this.renderer.resetState();
    return true;
  }

  dispose(): void {
    this.gl.deleteTexture(this.layers.sourceTexture as WebGLTexture | null);
    this.gl.deleteTexture(this.table.sourceTexture as WebGLTexture | null);
  }

  private uploadTiles(): void {
    const gl = this.gl;
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.layers.sourceTexture as WebGLTexture);
    this.setUnpacking();
    for (let upload = this.model.takeTextureUpload(); upload; upload = this.model.takeTextureUpload()) {
      const { layer, x, y, width, height } = upload.at;
      gl.texSubImage3D(
        gl.TEXTURE_2D_ARRAY,
        0,
        x,
        y,
        layer,
        width,
        height,
        1,
        gl.RGBA,
        gl.UNSIGNED_BYTE,
        upload.texels,
      );
    }
  }

  /** Makes room for more layers and keeps the tiles that are there. */
  private resize(layers: number): void {
    const gl = this.gl;
    const most = gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS) as number;
    const old = this.layers.sourceTexture as WebGLTexture | null;
    const kept = this.layer_count;
    const count = Math.min(Math.max(layers, this.layer_count * 2), most);
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, gl.SRGB8_ALPHA8, kTilePx, kTilePx, count);
    this.setSampling(gl.TEXTURE_2D_ARRAY, gl.LINEAR);
    if (old) {
      const framebuffer = gl.createFramebuffer();
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, framebuffer);
      for (let layer = 0; layer < kept; ++layer) {
        gl.framebufferTextureLayer(gl.READ_FRAMEBUFFER, gl.COLOR_ATTACHMENT0, old, 0, layer);
        gl.copyTexSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, layer, 0, 0, kTilePx, kTilePx);
      }
      gl.deleteFramebuffer(framebuffer);
      gl.deleteTexture(old);
    }
    this.layers.sourceTexture = texture;
    this.layer_count = count;
    this.renderer.resetState();
  }

  private setTable(words: Uint32Array): void {
    const gl = this.gl;
    const rows = Math.max(1, Math.ceil(words.length / kTableWidth));
    if (rows > this.table_rows) {
      gl.deleteTexture(this.table.sourceTexture as WebGLTexture | null);
      const texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, gl.R32UI, kTableWidth, rows);
      this.setSampling(gl.TEXTURE_2D, gl.NEAREST);
      this.table.sourceTexture = texture;
      this.table_rows = rows;
    }
    const padded = new Uint32Array(rows * kTableWidth);
    padded.set(words);
    gl.bindTexture(gl.TEXTURE_2D, this.table.sourceTexture as WebGLTexture);
    this.setUnpacking();
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, kTableWidth, rows, gl.RED_INTEGER, gl.UNSIGNED_INT, padded);
    this.renderer.resetState();
  }

  private setUnpacking(): void {
    const gl = this.gl;
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
  }

  private setSampling(target: number, filter: number): void {
    const gl = this.gl;
    gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, filter);
    gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, filter);
    gl.texParameteri(target, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(target, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  }
}
