import { BlobCache } from "./blob_cache";
import { compileCore, Core } from "./core";
import { DecodePool } from "./decode_pool";

/** Objects that all models of the page share. */
export interface Host {
  core: Core;
  pool: DecodePool;
  cache: BlobCache;
}

let host: Promise<Host> | null = null;

/** Returns the host; the first call creates it. @throws the reason if the browser cannot run the core. */
export function startHost(): Promise<Host> {
  host ??= start();
  return host;
}

async function start(): Promise<Host> {
  const compiled = await compileCore();
  const pool = new DecodePool(compiled);
  return { core: await Core.create(compiled), pool, cache: new BlobCache() };
}
