/** Loads the wasm core, and passes bytes and texts in and out. The page and its workers use this file. */

import { HttpError } from "./http_error";

/** The emscripten module. Pointers and sizes are numbers of bytes. */
export interface CoreModule {
  readonly HEAPU8: Uint8Array;
  _malloc(bytes: number): number;
  _free(pointer: number): void;
  _lode_answer(): number;
  _lode_answer_bytes(): number;

  _lode_open(json: number, bytes: number): number;
  _lode_close(model: number): void;
  _lode_wants_connection(model: number, now_ms: number): number;
  _lode_connect(model: number, now_ms: number): void;
  _lode_disconnect(model: number, why: number, bytes: number, now_ms: number): number;
  _lode_connected(model: number): number;
  _lode_receive(model: number, pointer: number, bytes: number, now_ms: number): number;
  _lode_takes_input(model: number): number;
  _lode_step(model: number, now_ms: number): number;
  _lode_take_outgoing(model: number): number;
  _lode_take_job(model: number): number;
  _lode_finish_job(model: number, pointer: number, bytes: number): number;
  _lode_take_cache_query(model: number): number;
  _lode_finish_cache_query(model: number, query: number, pointer: number, bytes: number): void;
  _lode_take_arrival(model: number): number;

  _lode_job_image(pointer: number, bytes: number): number;
  _lode_decode(pointer: number, bytes: number): number;
  _lode_decode_image(job: number, bytes: number, rgba: number, width: number, height: number): number;

  _lode_summary(model: number): number;
  _lode_start_camera(model: number, json: number, bytes: number): number;
  _lode_frame(model: number, now_ms: number, json: number, bytes: number): number;
  _lode_mesh_vertices(model: number, id: number): number;
  _lode_mesh_indices(model: number, id: number): number;
  _lode_mesh_stride(model: number, id: number): number;
  _lode_pick(model: number, x_px: number, y_px: number): number;
  _lode_project(model: number, json: number, bytes: number): number;
  _lode_shader(stage: number, parts: number): number;
  _lode_textures(model: number): number;
  _lode_texture_table(model: number): number;
  _lode_take_texture_upload(model: number): number;
}

interface CoreOptions {
  locateFile(name: string): string;
  instantiateWasm(
    imports: WebAssembly.Imports,
    done: (instance: WebAssembly.Instance, module: WebAssembly.Module) => void,
  ): object;
}

const kEncoder = new TextEncoder();
const kDecoder = new TextDecoder();

/** Compiles core.wasm once, so that workers need not compile it again. */
export async function compileCore(): Promise<WebAssembly.Module> {
  const url = new URL("core.wasm", import.meta.url);
  const response = await fetch(url);
  if (!response.ok) throw new HttpError(response.status);
  if (response.headers.get("content-type") === "application/wasm")
    return WebAssembly.compileStreaming(response);
  return WebAssembly.compile(await response.arrayBuffer());
}

/** An instance of the core. */
export class Core {
  private constructor(readonly module: CoreModule) {}

  static async create(compiled: WebAssembly.Module): Promise<Core> {
    const url = new URL("core.js", import.meta.url).href;
    const { default: createCore } = (await import(url)) as {
      default(options: CoreOptions): Promise<CoreModule>;
    };
    const module = await createCore({
      locateFile: (name) => new URL(name, import.meta.url).href,
      instantiateWasm(imports, done) {
        void WebAssembly.instantiate(compiled, imports).then((instance) => done(instance, compiled));
        return {};
      },
    });
    return new Core(module);
  }

  /** Copies bytes into the core for the duration of a call. */
  withBytes<T>(bytes: Uint8Array, call: (pointer: number, size: number) => T): T {
    const pointer = this.module._malloc(Math.max(bytes.length, 1)) >>> 0;
    if (pointer === 0) throw new RangeError("The memory of this page is exhausted");
    try {
      this.module.HEAPU8.set(bytes, pointer);
      return call(pointer, bytes.length);
    } finally {
      this.module._free(pointer);
    }
  }

  withText<T>(text: string, call: (pointer: number, size: number) => T): T {
    return this.withBytes(kEncoder.encode(text), call);
  }

  /** Returns the answer of the last call in the core's memory. It is valid until the next call. */
  answerView(): Uint8Array {
    const pointer = this.module._lode_answer() >>> 0;
    return this.module.HEAPU8.subarray(pointer, pointer + this.module._lode_answer_bytes());
  }

  /** Returns a copy of the answer of the last call. */
  answer(): Uint8Array<ArrayBuffer> {
    return this.answerView().slice() as Uint8Array<ArrayBuffer>;
  }

  answerText(): string {
    return kDecoder.decode(this.answerView());
  }

  /** Returns the answer, parsed without checks, because the core and the page come from one build. */
  answerJson<T>(): T {
    return JSON.parse(this.answerText()) as T;
  }
}
