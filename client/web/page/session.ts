import type { CameraView, FrameAnswer, FrameInput, Status, Summary } from "./contract";
import { CoreModel } from "./core_model";
import { find } from "./dom";
import type { Host } from "./host";
import { Picture } from "./picture";
import { pictureSize, type Screen } from "./screen";
import { token } from "./server";
import type { Settings } from "./settings";
import { Stream } from "./stream";

export interface SessionListener {
  contextLost(): void;
  contextRestored(): void;
}

/** One view of a model: stream and picture. After a lost WebGL context, a new session is needed. */
export class Session {
  readonly model: CoreModel;
  readonly stream: Stream;
  private readonly screen: Screen;
  private readonly picture: Picture;
  private readonly ending = new AbortController(); // ends the listeners
  private summary_: Summary | null = null;
  private is_started = false;
  private is_lost = false;
  private shown_error_px = Infinity;

  /** @throws Error if the browser has no WebGL 2 or the core refuses. */
  constructor(
    host: Host,
    name: string,
    private readonly settings: Settings,
    private readonly camera: CameraView | null,
    listener: SessionListener,
  ) {
    this.model = new CoreModel(host.core, {
      model: name,
      token: token(),
      memory_bytes: settings.memory_bytes,
      seed: Math.floor(Math.random() * 2 ** 32),
      has_cache: host.cache.canKeep,
    });
    this.stream = new Stream(this.model, host.pool, host.cache, () => this.startEarly());
    this.stream.pump(); // connects first
    try {
      this.screen = host.screen;
    } catch (error) {
      this.stream.close();
      this.model.close();
      throw error;
    }
    this.picture = new Picture(this.model, this.screen);
    this.watchContext(listener);
    this.canvas.style.visibility = "hidden"; // it shows the last model until the first picture
    find("#stage").prepend(this.canvas);
  }

  get canvas(): HTMLCanvasElement {
    return this.screen.canvas;
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
    return this.screen.resize(...pictureSize(stage.clientWidth, stage.clientHeight));
  }

  /** Sets the camera once the core can. @returns true if frames may be drawn. */
  start(): boolean {
    if (this.is_started) return true;
    this.screen.check();
    if (!this.summary_) {
      this.summary_ = this.model.summary();
      if (!this.summary_) return false;
      this.screen.prepare(this.screen.programs.featuresOf(this.settings.show, this.summary_.has_textures, false));
    }
    const { threshold_px } = this.settings;
    this.is_started = this.model.startCamera({ ...this.size(), threshold_px, up: null, camera: this.camera });
    return this.is_started;
  }

  /** Starts as soon as the model is known, to request meshes before the next frame. */
  private startEarly(): void {
    if (this.is_started || !this.model.isOpen) return;
    try {
      if (this.start()) this.stream.pump();
    } catch {
      // The next frame reports the error.
    }
  }

  /** Advances the core by a frame, and draws what it describes. @returns null if nothing was drawn. */
  frame(settings: Settings, input: FrameInput, seconds: number, has_changed: boolean): FrameAnswer & { drawn: boolean } {
    const { threshold_px, show } = settings;
    const request = { ...this.size(), threshold_px, show, seconds, ...input };
    const answer = this.model.frame(performance.now(), request);
    this.stream.pump(); // sends requests before a long picture
    const drawn = this.picture.draw(answer, show, has_changed);
    if (drawn) this.canvas.style.visibility = "";
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
    this.ending.abort();
    this.stream.close();
    this.model.close();
    if (!this.is_lost) this.picture.dispose();
    this.canvas.remove();
  }

  private watchContext(listener: SessionListener): void {
    const { signal } = this.ending;
    const lost = (event: Event) => {
      event.preventDefault();
      this.is_lost = true;
      this.picture.dispose(); // objects of a lost context are invalid in the restored one
      this.screen.dispose();
      listener.contextLost();
    };
    this.canvas.addEventListener("webglcontextlost", lost, { signal });
    this.canvas.addEventListener("webglcontextrestored", () => listener.contextRestored(), { signal });
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

  private size() {
    return { width_px: this.canvas.width, height_px: this.canvas.height };
  }
}
