import { ExternalTexture } from "three";
import type { TextureState } from "./contract";
import type { CoreModel } from "./core_model";
import type { Screen } from "./screen";

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
  private table_rows = 0;
  private serial = -1;
  private state: TextureState | null = null;

  constructor(
    private readonly model: CoreModel,
    private readonly screen: Screen,
  ) {
    this.gl = screen.gl;
  }

  /** True if the model has textures. */
  get exist(): boolean {
    return this.state !== null;
  }

  /** True if textures have transparent texels. */
  get has_clear(): boolean {
    return this.state?.has_clear ?? false;
  }

  /** Uploads new tiles, then the table that refers to them. @returns true if the picture may change. */
  update(): boolean {
    this.state = this.model.textures();
    if (!this.state) return false;
    const is_new = this.state.serial !== this.serial;
    if (is_new) this.makeLayers(this.state);
    const has_tiles = this.uploadTiles();
    const table = this.model.textureTable();
    if (table) this.setTable(table);
    if (!is_new && !has_tiles && !table) return false;
    this.screen.resetState();
    return true;
  }

  dispose(): void {
    this.gl.deleteTexture(this.layers.sourceTexture as WebGLTexture | null);
    this.gl.deleteTexture(this.table.sourceTexture as WebGLTexture | null);
  }

  private uploadTiles(): boolean {
    const gl = this.gl;
    let upload = this.model.takeTextureUpload();
    if (!upload) return false;
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.layers.sourceTexture as WebGLTexture);
    this.setUnpacking();
    for (; upload; upload = this.model.takeTextureUpload()) {
      const { layer, x, y, width, height, texels } = upload;
      const { RGBA, UNSIGNED_BYTE } = gl;
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, x, y, layer, width, height, 1, RGBA, UNSIGNED_BYTE, texels);
    }
    return true;
  }

  /** Makes the empty array of a new set of textures. */
  private makeLayers({ serial, layers }: TextureState): void {
    const gl = this.gl;
    gl.deleteTexture(this.layers.sourceTexture as WebGLTexture | null);
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, gl.SRGB8_ALPHA8, kTilePx, kTilePx, Math.max(1, layers));
    this.setSampling(gl.TEXTURE_2D_ARRAY, gl.LINEAR);
    this.layers.sourceTexture = texture;
    this.serial = serial;
    this.setTable(new Uint32Array(1));
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
