import type {
  FrameAnswer,
  FrameRequest,
  OpenOptions,
  Pick,
  StartCamera,
  Summary,
  TextureState,
  TextureUpload,
  Vec3,
} from "./contract";
import { Core } from "./core";

/** A blob that the core asks the cache for. */
export interface CacheQuery {
  number: number;
  digest: string;
}

/** A received blob to write to the cache. */
export interface Arrival {
  digest: string;
  bytes: Uint8Array<ArrayBuffer>;
}

const kDigestBytes = 32; // length of the hexadecimal digest in front of an arrival
const kUploadHeadBytes = 20; // length of layer, x, y, width and height in front of texels

/** One model that the core streams and shows. */
export class CoreModel {
  private handle: number;

  /** @throws Error with the core's message if the core refuses the options. */
  constructor(
    readonly core: Core,
    options: OpenOptions,
  ) {
    this.handle = core.withText(JSON.stringify(options), (pointer, size) => core.module._lode_open(pointer, size));
    if (this.handle === 0) throw new Error(core.answerText());
  }

  close(): void {
    if (this.handle !== 0) this.core.module._lode_close(this.handle);
    this.handle = 0;
  }

  get isOpen(): boolean {
    return this.handle !== 0;
  }

  wantsConnection(now_ms: number): boolean {
    return this.core.module._lode_wants_connection(this.handle, now_ms) !== 0;
  }

  connect(now_ms: number): void {
    this.core.module._lode_connect(this.handle, now_ms);
  }

  isConnected(): boolean {
    return this.core.module._lode_connected(this.handle) !== 0;
  }

  /** Reports a lost connection. Returns the error if the core does not try again, else null. */
  disconnect(why: string, now_ms: number): string | null {
    const ended = this.core.withText(why, (pointer, size) =>
      this.core.module._lode_disconnect(this.handle, pointer, size, now_ms),
    );
    return ended ? this.errorText() : null;
  }

  /**
   * Passes received bytes. Call with no bytes to let the core continue after takesInput() was false. After an
   * error of the connection, isConnected() is false. Returns the error if the stream has ended for good, else
   * null.
   */
  receive(bytes: Uint8Array, now_ms: number): string | null {
    const failed = this.core.withBytes(bytes, (pointer, size) =>
      this.core.module._lode_receive(this.handle, pointer, size, now_ms),
    );
    return failed ? this.errorText() : null;
  }

  /** Returns false if received bytes must wait until outgoing bytes are sent. */
  takesInput(): boolean {
    return this.core.module._lode_takes_input(this.handle) !== 0;
  }

  /** Advances the stream. Returns the error if it has ended for good, else null. */
  step(now_ms: number): string | null {
    return this.core.module._lode_step(this.handle, now_ms) ? this.errorText() : null;
  }

  takeOutgoing(): Uint8Array<ArrayBuffer> | null {
    return this.core.module._lode_take_outgoing(this.handle) ? this.core.answer() : null;
  }

  takeJob(): Uint8Array<ArrayBuffer> | null {
    return this.core.module._lode_take_job(this.handle) ? this.core.answer() : null;
  }

  /** Passes the result of a worker. Returns the error if the stream has ended for good, else null. */
  finishJob(result: Uint8Array): string | null {
    const failed = this.core.withBytes(result, (pointer, size) =>
      this.core.module._lode_finish_job(this.handle, pointer, size),
    );
    return failed ? this.errorText() : null;
  }

  takeCacheQuery(): CacheQuery | null {
    return this.core.module._lode_take_cache_query(this.handle) ? this.core.answerJson() : null;
  }

  /** Answers a query. @param blob  null if the cache has no such blob. */
  finishCacheQuery(query: number, blob: Uint8Array | null): void {
    const module = this.core.module;
    if (blob === null) {
      module._lode_finish_cache_query(this.handle, query, 0, -1);
      return;
    }
    this.core.withBytes(blob, (pointer, size) =>
      module._lode_finish_cache_query(this.handle, query, pointer, size),
    );
  }

  takeArrival(): Arrival | null {
    if (!this.core.module._lode_take_arrival(this.handle)) return null;
    const answer = this.core.answer();
    return {
      digest: new TextDecoder().decode(answer.subarray(0, kDigestBytes)),
      bytes: answer.subarray(kDigestBytes),
    };
  }

  /** Returns the model's summary, or null until it is known. */
  summary(): Summary | null {
    return this.core.module._lode_summary(this.handle) ? this.core.answerJson() : null;
  }

  /** Sets the first camera. Returns false if the core needs the coarsest mesh first. @throws Error */
  startCamera(start: StartCamera): boolean {
    const result = this.core.withText(JSON.stringify(start), (pointer, size) =>
      this.core.module._lode_start_camera(this.handle, pointer, size),
    );
    if (result < 0) throw new Error(this.errorText());
    return result > 0;
  }

  /** Advances the camera and selects the parts to draw. @throws Error if the core cannot. */
  frame(now_ms: number, request: FrameRequest): FrameAnswer {
    this.core.withText(JSON.stringify(request), (pointer, size) =>
      this.core.module._lode_frame(this.handle, now_ms, pointer, size),
    );
    return this.answerOrThrow<FrameAnswer>();
  }

  /** Returns the words of a mesh's vertices, or null if the mesh is not resident any more. */
  meshVertices(id: number): Uint32Array<ArrayBuffer> | null {
    return this.core.module._lode_mesh_vertices(this.handle, id) ? this.answerWords() : null;
  }

  meshIndices(id: number): Uint32Array<ArrayBuffer> | null {
    return this.core.module._lode_mesh_indices(this.handle, id) ? this.answerWords() : null;
  }

  /** Returns the number of words per vertex: 4, or 6 with texture coordinates. */
  meshStride(id: number): number {
    return this.core.module._lode_mesh_stride(this.handle, id);
  }

  /** @throws Error if the model has no camera. */
  pick(x_px: number, y_px: number): Pick | null {
    return this.core.module._lode_pick(this.handle, x_px, y_px) ? this.answerOrThrow<Pick>() : null;
  }

  /** Projects true coordinates to pixels of the last frame. @throws Error if the model has no camera. */
  project(points: Vec3[]): [x_px: number, y_px: number, visible: 0 | 1][] {
    if (points.length === 0) return [];
    this.core.withText(JSON.stringify(points), (pointer, size) =>
      this.core.module._lode_project(this.handle, pointer, size),
    );
    return this.answerOrThrow();
  }

  /** Returns the state of the texture tiles, or null without textures. */
  textures(): TextureState | null {
    return this.core.module._lode_textures(this.handle) ? this.core.answerJson() : null;
  }

  /** Returns the words of the table of tiles, or null if none has changed since the last call. */
  textureTable(): Uint32Array<ArrayBuffer> | null {
    return this.core.module._lode_texture_table(this.handle) ? this.answerWords() : null;
  }

  /** Takes the next image for the texture array. The texels are valid until the next call of the core. */
  takeTextureUpload(): TextureUpload | null {
    if (!this.core.module._lode_take_texture_upload(this.handle)) return null;
    const answer = this.core.answerView();
    const head = new DataView(answer.buffer, answer.byteOffset, kUploadHeadBytes);
    const word = (index: number) => head.getUint32(4 * index, true);
    const texels = answer.subarray(kUploadHeadBytes);
    return { layer: word(0), x: word(1), y: word(2), width: word(3), height: word(4), texels };
  }

  private answerWords(): Uint32Array<ArrayBuffer> {
    return new Uint32Array(this.core.answer().buffer);
  }

  private answerOrThrow<T extends object>(): T {
    const answer = this.core.answerJson<T | { error: string }>();
    if ("error" in answer) throw new Error(answer.error);
    return answer;
  }

  private errorText(): string {
    return this.core.answerJson<{ error: string }>().error;
  }
}

/** Returns a shader of the mesh program. @param parts  sum of the features, such as kTextured. */
export function shaderText(core: Core, stage: "vertex" | "fragment", parts: number): string {
  core.module._lode_shader(stage === "vertex" ? 0 : 1, parts);
  return core.answerText();
}
