import { CoreModel } from "./core_model";
import type { Host } from "./host";
import { Picture } from "./picture";
import type { Screen } from "./screen";
import type { ListedModel } from "./server";
import { Stream } from "./stream";
import { token } from "./server";

const kCacheName = "lodestream-pictures";
const kWidthPx = 320;
const kHeightPx = 200;
const kThresholdPx = 2;
const kMemoryBytes = 192e6; // smaller texture arrays cannot hold one level of each of 20 images
/** Time after which the current picture is kept, or the attempt fails if no mesh has arrived. */
const kDeadlineMs = 12_000;

/** Makes pictures of models for the gallery, one at a time, and keeps them by build. */
export class Thumbnails {
  private readonly queue: { model: ListedModel; done: (url: string | null) => void }[] = [];
  private is_working = false;
  private is_stopped = false;
  private readonly urls: string[] = [];

  constructor(private readonly host: () => Promise<Host>) {}

  /** Returns the address of a model's picture, or null if none can be made. */
  request(model: ListedModel): Promise<string | null> {
    return new Promise((done) => {
      this.queue.push({ model, done });
      void this.work();
    });
  }

  /** Ends the work and frees the pictures. */
  stop(): void {
    this.is_stopped = true;
    for (const { done } of this.queue.splice(0)) done(null);
    for (const url of this.urls) URL.revokeObjectURL(url);
  }

  private async work(): Promise<void> {
    if (this.is_working) return;
    this.is_working = true;
    for (let next = this.queue.shift(); next && !this.is_stopped; next = this.queue.shift()) {
      const blob = await this.make(next.model).catch(() => null);
      const url = blob && !this.is_stopped ? URL.createObjectURL(blob) : null;
      if (url) this.urls.push(url);
      next.done(url);
    }
    this.is_working = false;
  }

  private async make(model: ListedModel): Promise<Blob | null> {
    const kept = await keptPicture(model.build_id);
    if (kept) return kept;
    const made = await this.draw(model);
    if (made?.is_final) await keepPicture(model.build_id, made.blob);
    return made?.blob ?? null;
  }

  /** Streams a model until its picture is sharp, or the deadline. */
  private async draw(listed: ListedModel): Promise<{ blob: Blob; is_final: boolean } | null> {
    const host = await this.host();
    if (this.is_stopped) return null;
    const screen = host.screen;
    screen.resize(kWidthPx, kHeightPx);
    const model = new CoreModel(host.core, {
      model: listed.name,
      token: token(),
      memory_bytes: kMemoryBytes,
      seed: Math.floor(Math.random() * 2 ** 32),
      has_cache: host.cache.canKeep,
    });
    const stream = new Stream(model, host.pool, host.cache);
    const picture = new Picture(model, screen);
    try {
      return await this.untilSharp(model, stream, picture, screen);
    } finally {
      stream.close();
      picture.dispose();
      model.close();
    }
  }

  private async untilSharp(model: CoreModel, stream: Stream, picture: Picture, screen: Screen) {
    const from_ms = performance.now();
    const size = { width_px: kWidthPx, height_px: kHeightPx };
    let is_started = false;
    let has_parts = false;
    for (;;) {
      await nextFrame();
      if (this.is_stopped || screen.isLost) return null; // a stopped one may not draw: the screen has another user
      stream.pump();
      const now = performance.now();
      const is_late = now - from_ms > kDeadlineMs;
      if (stream.failure !== null || (is_late && !has_parts)) return null;
      if (!is_started) {
        if (model.summary()) is_started = model.startCamera({ ...size, threshold_px: kThresholdPx, up: null, camera: null });
        continue;
      }
      const request = { ...size, threshold_px: kThresholdPx, seconds: 0, show: "surface" as const };
      const answer = model.frame(now, request);
      const is_final = answer.status.converged && answer.status.settled && !picture.isWaiting;
      picture.draw(answer, request.show, is_final || is_late);
      has_parts = picture.partCount > 0;
      if (!has_parts || (!(is_final && !picture.isWaiting) && !is_late)) continue;
      const blob = await new Promise<Blob | null>((done) => screen.canvas.toBlob(done, "image/webp", 0.85));
      return blob ? { blob, is_final } : null;
    }
  }
}

/** Deletes kept pictures of builds that the server does not serve any more. */
export async function forgetPictures(current: ListedModel[]): Promise<void> {
  if (typeof caches === "undefined") return;
  const used = new Set(current.map((model) => keyOf(model.build_id)));
  try {
    const cache = await caches.open(kCacheName);
    for (const request of await cache.keys()) if (!used.has(request.url)) await cache.delete(request);
  } catch {
    // The cache only saves time.
  }
}

async function keptPicture(build_id: string): Promise<Blob | null> {
  if (typeof caches === "undefined") return null;
  try {
    const found = await (await caches.open(kCacheName)).match(keyOf(build_id));
    return found ? await found.blob() : null;
  } catch {
    return null;
  }
}

async function keepPicture(build_id: string, picture: Blob): Promise<void> {
  if (typeof caches === "undefined") return;
  try {
    await (await caches.open(kCacheName)).put(keyOf(build_id), new Response(picture));
  } catch {
    // Ignored: the storage quota is exhausted.
  }
}

function keyOf(build_id: string): string {
  return new URL(`picture/${build_id}`, document.baseURI).href;
}

/** Waits for the next frame, or a moment if the tab is hidden. */
function nextFrame(): Promise<void> {
  return new Promise((done) => {
    if (document.hidden) setTimeout(done, 250);
    else requestAnimationFrame(() => done());
  });
}
