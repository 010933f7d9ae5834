import type { WebGLRenderer } from "three";
import { BlobCache } from "./blob_cache";
import { compileCore, Core } from "./core";
import { DecodePool } from "./decode_pool";
import { makeRenderer, Screen } from "./screen";

/** Objects that all models of the page share. */
export class Host {
  readonly cache = new BlobCache();
  private screen_: Screen | null = null;

  /** @param renderer  for the first screen, if it exists already. */
  constructor(
    readonly core: Core,
    readonly pool: DecodePool,
    renderer: WebGLRenderer | null,
  ) {
    if (!renderer) return;
    this.screen_ = new Screen(core, renderer);
    this.screen_.prepare(this.screen_.programs.featuresOf("surface", false, false));
  }

  /** The screen; a new one if the last has lost its context. @throws Error if the browser has no WebGL 2. */
  get screen(): Screen {
    if (this.screen_ && !this.screen_.isLost) return this.screen_;
    this.screen_?.dispose();
    return (this.screen_ = new Screen(this.core, makeRenderer()));
  }
}

let host: Promise<Host> | null = null;

/** Returns the host; the first call creates it. @throws the reason if the browser cannot run the core. */
export function startHost(): Promise<Host> {
  host ??= start();
  return host;
}

async function start(): Promise<Host> {
  const compiling = compileCore();
  const renderer = tryRenderer(); // while the core arrives
  const compiled = await compiling;
  const pool = new DecodePool(compiled);
  return new Host(await Core.create(compiled), pool, renderer);
}

/** Returns null if the browser has no WebGL 2: Host.screen says so once a model needs it. */
function tryRenderer(): WebGLRenderer | null {
  try {
    return makeRenderer();
  } catch {
    return null;
  }
}
