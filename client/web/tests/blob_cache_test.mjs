import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { BlobCache } from "../page/blob_cache.ts";

let stored;
beforeEach(() => {
  const items = new Map();
  globalThis.localStorage = { getItem: (key) => items.get(key) ?? null, setItem: (key, text) => items.set(key, text) };
  globalThis.document = { baseURI: "https://host/" };
  stored = new Map();
  globalThis.caches = {
    async open(name) {
      if (!stored.has(name)) stored.set(name, new Map());
      const blobs = stored.get(name);
      return {
        match: async (key) => blobs.get(key)?.clone(),
        put: async (key, response) => void blobs.set(key, response),
      };
    },
    delete: async (name) => stored.delete(name),
  };
});
const blob = new Uint8Array(100e6);

test("a blob is found again", async () => {
  const cache = new BlobCache();
  assert.equal(await cache.get("a"), null);
  await cache.put("a", new Uint8Array([1, 2]));
  assert.deepEqual(await new BlobCache().get("a"), new Uint8Array([1, 2]));
});

test("two generations are kept, and blobs in use move to the newer one", async () => {
  const cache = new BlobCache();
  await cache.put("used", new Uint8Array([7]));
  for (const digest of ["a", "b", "c"]) await cache.put(digest, blob);
  assert.ok(await cache.get("used"));
  await new Promise((done) => setImmediate(done));
  for (const digest of ["d", "e", "f"]) await cache.put(digest, blob);
  assert.equal(await cache.get("a"), null);
  assert.ok(await cache.get("used"));
  for (const digest of ["g", "h", "i", "j"]) await cache.put(digest, blob);
  await new Promise((done) => setImmediate(done));
  assert.equal(stored.size, 2);
});

test("a browser without caches, or with a full disk, keeps nothing and reports nothing", async () => {
  globalThis.caches.open = async () => {
    throw new Error("QuotaExceededError");
  };
  const cache = new BlobCache();
  await cache.put("a", new Uint8Array([1]));
  assert.equal(await cache.get("a"), null);
  delete globalThis.caches;
  assert.equal(new BlobCache().canKeep, false);
  assert.equal(await new BlobCache().get("a"), null);
});
