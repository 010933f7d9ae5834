/** Keeps blobs between visits in the browser's Cache API. Failures are ignored: the cache only saves time. */

const kPrefix = "lodestream-blobs-";
const kStateKey = "lodestream-blob-cache";
/** Bytes after which a new generation begins. Two generations are kept, so the cache holds twice as much. */
const kGenerationBytes = 256e6;

interface Generation {
  number: number;
  bytes: number;
}

/**
 * A cache of two generations. New blobs go to the newer one; a hit in the older one copies the blob to the
 * newer one. When the newer one is full, the older one is deleted: blobs that were not used for long go
 * first, without a list of all blobs. Blobs are named by their digests, and the core checks these.
 */
export class BlobCache {
  private readonly isAvailable = typeof caches !== "undefined";
  private opened = new Map<number, Promise<Cache>>();

  /** True if blobs can be cached. Over plain HTTP, browsers provide caches only for localhost. */
  get canKeep(): boolean {
    return this.isAvailable;
  }

  /** Returns a blob, or null if it is not cached. Never fails. */
  async get(digest: string): Promise<Uint8Array<ArrayBuffer> | null> {
    const { number, bytes } = this.generation();
    if (!this.isAvailable || (number === 0 && bytes === 0)) return null;
    try {
      for (const from of [number, number - 1]) {
        if (from < 0) break;
        const found = await (await this.open(from)).match(keyOf(digest));
        if (!found) continue;
        const blob = new Uint8Array(await found.arrayBuffer());
        if (from !== number) void this.put(digest, blob);
        return blob;
      }
    } catch {
      // The browser refused access: the blob comes from the server.
    }
    return null;
  }

  /** Keeps a blob. Never fails. */
  async put(digest: string, blob: Uint8Array<ArrayBuffer>): Promise<void> {
    if (!this.isAvailable) return;
    const { number } = this.generation();
    try {
      await (await this.open(number)).put(keyOf(digest), new Response(blob));
      this.count(blob.length);
    } catch {
      await this.remove(number - 1); // the quota is exhausted
    }
  }

  private open(number: number): Promise<Cache> {
    let cache = this.opened.get(number);
    if (!cache) {
      cache = caches.open(kPrefix + number);
      this.opened.set(number, cache);
    }
    return cache;
  }

  private async remove(number: number): Promise<void> {
    this.opened.delete(number);
    try {
      await caches.delete(kPrefix + number);
    } catch {
      // The next visit tries again.
    }
  }

  /** Adds bytes to the newer generation, and begins another generation if it is full. */
  private count(bytes: number): void {
    const { number, bytes: before } = this.generation();
    if (before + bytes < kGenerationBytes) {
      this.store({ number, bytes: before + bytes });
      return;
    }
    this.store({ number: number + 1, bytes: 0 });
    void this.remove(number - 1);
  }

  private generation(): Generation {
    try {
      const stored = JSON.parse(localStorage.getItem(kStateKey) ?? "{}") as Partial<Generation>;
      return { number: Number(stored.number) || 0, bytes: Number(stored.bytes) || 0 };
    } catch {
      return { number: 0, bytes: 0 };
    }
  }

  private store(generation: Generation): void {
    try {
      localStorage.setItem(kStateKey, JSON.stringify(generation));
    } catch {
      // Storage is switched off.
    }
  }
}

function keyOf(digest: string): string {
  return new URL(`blob/${digest}`, document.baseURI).href;
}
