import type { WebGLRenderer } from "three";
import type { CameraView, FrameAnswer, FrameInput, Status, Summary } from "./contract";
import { CoreModel } from "./core_model";
import { find } from "./dom";
import type { Host } from "./host";
import { makeRenderer, Picture } from "./picture";
import { token } from "./server";
import type { Settings } from "./settings";
import { Stream } from "./stream";

/** Largest number of picture pixels per CSS pixel, because more cost time and are hardly visible. */
const kMostPxPerCss = 2;

export interface SessionListener {
  contextLost(): void;
  contextRestored(): void;
}

/** One view of a model: stream, canvas and picture. After a lost WebGL context, a new session is needed. */
export class Session {
  readonly model: CoreModel;
  readonly stream: Stream;
  readonly canvas = document.createElement("canvas");
  private readonly renderer: WebGLRenderer;
  private readonly picture: Picture;
  private summary_: Summary | null = null;
  private is_started = false;
  private is_lost = false;
  private shown_error_px = Infinity;

  /** @throws Error if the browser has no WebGL 2 or the core refuses. */
  constructor(
    host: Host,
    name: string,
    settings: Settings,
    private readonly camera: CameraView | null,
    listener: SessionListener,
  ) {
    this.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      if (!this.model.isOpen) return;
      this.is_lost = true;
      this.release(); // objects of a lost context are invalid in the restored one
      listener.contextLost();
    });
    this.canvas.addEventListener("webglcontextrestored", () => {
      if (this.model.isOpen) listener.contextRestored();
    });
    this.model = new CoreModel(host.core, {
      model: name,
      token: token(),
      memory_bytes: settings.memory_bytes,
      seed: Math.floor(Math.random() * 2 ** 32),
      has_cache: host.cache.canKeep,
    });
    this.stream = new Stream(this.model, host.pool, host.cache);
    this.stream.pump(); // connects while the browser creates the context
    try {
      this.renderer = makeRenderer(this.canvas);
    } catch (error) {
      this.stream.close();
      this.model.close();
      throw error;
    }
    this.picture = new Picture(this.model, this.renderer);
    find("#stage").prepend(this.canvas);
  }

  get summary(): Summary | null {
    return this.summary_;
  }

  get partCount(): number {
    return this.picture.partCount;
  }

  /** True if the picture is not complete yet, so that frames follow each other without a pause. */
  get isBusy(): boolean {
    return !this.is_started || this.picture.isWaiting;
  }

  get isLost(): boolean {
    return this.is_lost;
  }

  /** Pixels of the picture per CSS pixel. */
  get pxPerCss(): number {
    return this.canvas.width / Math.max(1, this.canvas.clientWidth);
  }

  /** Adjusts the picture to the window. @returns true if its size has changed. */
  resize(): boolean {
    const stage = find("#stage");
    const scale = Math.min(devicePixelRatio || 1, kMostPxPerCss);
    const width = Math.max(1, Math.round(stage.clientWidth * scale));
    const height = Math.max(1, Math.round(stage.clientHeight * scale));
    if (width === this.canvas.width && height === this.canvas.height) return false;
    this.renderer.setSize(width, height, false);
    return true;
  }

  /** Sets the camera once the core can. @returns true if frames may be drawn. */
  start(): boolean {
    if (this.is_started) return true;
    this.summary_ ??= this.model.summary();
    if (!this.summary_) return false;
    this.is_started = this.model.startCamera({ ...this.size(), up: null, camera: this.camera });
    return this.is_started;
  }

  /** Advances the core by a frame, and draws what it describes. @returns null if nothing was drawn. */
  frame(settings: Settings, input: FrameInput, seconds: number, has_changed: boolean): FrameAnswer & { drawn: boolean } {
    const { threshold_px, show } = settings;
    const request = { ...this.size(), threshold_px, show, seconds, ...input };
    const answer = this.model.frame(performance.now(), request);
    this.stream.pump(); // sends requests before a long picture
    const drawn = this.picture.draw(answer, show, has_changed);
    return { ...answer, status: this.statusOfPicture(answer.status), drawn };
  }

  /** Returns the meshes in the picture, for tests; null for meshes that are no longer resident. */
  meshes(): ({ stride: number; vertices: Uint32Array; indices: Uint32Array } | null)[] {
    return this.picture.ids.map((id) => {
      const vertices = this.model.meshVertices(id);
      const indices = this.model.meshIndices(id);
      return vertices && indices ? { stride: this.model.meshStride(id), vertices, indices } : null;
    });
  }

  close(): void {
    this.stream.close();
    this.model.close();
    if (!this.is_lost) {
      this.release();
      this.renderer.forceContextLoss();
    }
    this.canvas.remove();
  }

  /** Returns the status with the error of the shown parts, which may be an earlier and coarser list. */
  private statusOfPicture(status: Status): Status {
    if (!this.picture.isWaiting) {
      this.shown_error_px = status.error_px;
      return status;
    }
    const error_px = Math.max(status.error_px, this.shown_error_px);
    return { ...status, error_px, converged: false, settled: false };
  }

  private release(): void {
    this.picture.dispose();
    this.renderer.dispose();
  }

  private size() {
    return { width_px: this.canvas.width, height_px: this.canvas.height };
  }
}
