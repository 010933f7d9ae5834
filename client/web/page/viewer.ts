import { Commands } from "./commands";
import { kCameraKinds, type FrameAnswer } from "./contract";
import { copyText, find } from "./dom";
import { explainStart, report } from "./errors";
import { FramePacing } from "./frame_pacing";
import { startHost, type Host } from "./host";
import { Input, movesCamera } from "./input";
import { formatLink, modelLink, type PageLink } from "./link";
import { Measure } from "./measure";
import { Panel } from "./panel";
import { HttpError } from "./http_error";
import { fetchModels, nativeLink } from "./server";
import { Session } from "./session";
import { defaultSettings, keepMemoryBytes, type Settings } from "./settings";
import { StatusView, troubleWords } from "./status_view";

/** Time between frames while nothing changes, and between polls of the stream in a hidden tab. */
const kIdleMs = 250;
const kHiddenMs = 5000;
/** Longest step of time between two frames for the motion of the camera. */
const kMostSeconds = 0.1;
/** Time for the driver to restore a lost WebGL context before the page creates a new session. */
const kRestoreMs = 3000;

/** State that tests read. */
export interface ViewerState {
  converged: boolean;
  settled: boolean;
  triangles: number;
  error_px: number;
  received_bytes: number;
  first_picture_ms: number | null;
  parts: number;
  frames: number;
}

/** The page of one model: connects the session, the input and the controls. */
export class Viewer {
  private readonly settings: Settings = defaultSettings();
  private readonly status = new StatusView(() => this.restart());
  private readonly panel: Panel;
  private readonly input: Input;
  private readonly measure: Measure;
  private readonly commands: Commands;
  private readonly pacing = new FramePacing();
  private host: Host | null = null;
  private session: Session | null = null;
  private answer: (FrameAnswer & { drawn: boolean }) | null = null;
  private animation = 0;
  private hidden_timer = 0;
  private last_ms = 0;
  private has_drawn = false; // true if the last animation frame drew a picture
  private is_dirty = true;
  private is_closed = false;
  private frames = 0;
  private first_picture_ms: number | null = null;

  constructor(
    private readonly name: string,
    private link: PageLink,
    private readonly wantsToken: () => void,
  ) {
    this.settings.threshold_px = link.threshold_px ?? this.settings.threshold_px;
    this.settings.show = link.show ?? this.settings.show;
    document.title = `${name} – Lodestream`;
    find("#title").textContent = name;
    find("#viewer").hidden = false;
    this.input = new Input(find("#stage"), {
      click: (x, y) => this.click(x, y),
      command: (command) => this.commands.run(command),
    });
    this.measure = new Measure(() => (this.is_dirty = true));
    this.panel = new Panel(this.settings, {
      changed: () => (this.is_dirty = true),
      memory: (bytes) => this.setMemory(bytes),
      command: (command) => this.commands.run(command),
      kind: (kind) => this.chooseKind(kind),
      copyLink: () => void this.copyLink(),
    });
    this.commands = new Commands(this.settings, this.input, this.panel, this.measure);
    this.status.loading(name);
    this.hidden_timer = window.setInterval(() => document.hidden && this.session?.stream.pump(), kHiddenMs);
    void this.open();
    void this.findNativeLink();
  }

  close(): void {
    this.is_closed = true;
    cancelAnimationFrame(this.animation);
    clearInterval(this.hidden_timer);
    this.session?.close();
    this.input.dispose();
    this.measure.dispose();
    this.panel.dispose();
    this.status.dispose();
    find("#viewer").hidden = true;
  }

  /** Applies another link to the same model. */
  follow(link: PageLink): void {
    this.link = link;
    this.settings.threshold_px = link.threshold_px ?? this.settings.threshold_px;
    this.settings.show = link.show ?? this.settings.show;
    this.panel.showSettings();
    if (link.camera) this.restart(link.camera);
  }

  get modelName(): string {
    return this.name;
  }

  state(): ViewerState {
    const status = this.answer?.status;
    return {
      converged: (status?.converged ?? false) && this.pacing.factor === 1 && !this.session?.isBusy,
      settled: status?.settled ?? false,
      triangles: status?.triangles ?? 0,
      error_px: status?.error_px ?? Infinity,
      received_bytes: status?.received_bytes ?? 0,
      first_picture_ms: this.first_picture_ms,
      parts: this.session?.partCount ?? 0,
      frames: this.frames,
    };
  }

  /** Returns the meshes in the picture, for tests. */
  meshes() {
    return this.session?.meshes() ?? [];
  }

  /** Returns the camera of the last frame, or null before it. */
  get camera() {
    return this.answer?.camera ?? null;
  }

  private async open(): Promise<void> {
    try {
      this.host = await startHost();
      if (this.is_closed) return;
      this.restart(this.link.camera);
      this.animation = requestAnimationFrame((now) => this.frame(now));
    } catch (error) {
      report(error);
      this.status.fail(explainStart(error), false);
    }
  }

  /** Starts a new session for the model, with the current camera unless another is given. */
  private restart(camera = this.answer?.camera ?? this.link.camera): void {
    if (!this.host || this.is_closed) return;
    this.session?.close();
    this.session = null;
    try {
      this.session = new Session(this.host, this.name, this.settings, camera, {
        contextLost: () => this.contextLost(),
        contextRestored: () => this.restart(),
      });
      this.status.restarted();
      this.is_dirty = true;
    } catch (error) {
      report(error);
      this.status.fail(explainStart(error), true);
    }
  }

  private contextLost(): void {
    this.status.trouble("The graphics driver has restarted. The picture comes back in a moment.");
    const lost = this.session;
    window.setTimeout(() => {
      if (lost === this.session) this.restart();
    }, kRestoreMs);
  }

  private frame(now: number): void {
    this.animation = requestAnimationFrame((next) => this.frame(next));
    if (this.has_drawn) this.pacing.measure(now, now - this.last_ms);
    this.has_drawn = false;
    const session = this.session;
    if (!session || session.isLost) return;
    session.stream.pump();
    const failure = session.stream.failure;
    if (failure !== null) this.status.fail(failure, true, "Try again, or choose another model.");
    const has_size = session.resize();
    try {
      if (session.start()) this.drawChanges(session, now, has_size);
      else if (failure === null) this.status.trouble(troubleWords(session.stream.trouble));
    } catch (error) {
      report(error);
      this.session = null;
      session.close();
      this.status.fail(error instanceof Error ? error.message : String(error), true);
    }
  }

  /** Draws a frame if anything has changed. */
  private drawChanges(session: Session, now: number, has_size: boolean): void {
    const has_news = session.stream.takeChanged() || this.input.hasInput || has_size || this.is_dirty;
    const goes_on = session.isBusy || (this.answer?.moving ?? true) || this.pacing.factor > 1;
    if (!has_news && !goes_on && now - this.last_ms < kIdleMs) return;
    this.advance(session, now, has_size || this.is_dirty);
  }

  private advance(session: Session, now: number, has_changed: boolean): void {
    const seconds = Math.min(kMostSeconds, Math.max(0, (now - this.last_ms) / 1000));
    this.last_ms = now;
    this.is_dirty = false;
    const orbits = (this.answer?.kind ?? "orbit") === "orbit";
    const input = this.input.take(session.pxPerCss, seconds, orbits);
    this.pacing.update(now, movesCamera(input) || (this.answer?.moving ?? false));
    const settings = { ...this.settings, threshold_px: this.settings.threshold_px * this.pacing.factor };
    const answer = (this.answer = session.frame(settings, input, seconds, has_changed));
    ++this.frames;
    if (session.partCount > 0) this.first_picture_ms ??= performance.now();
    this.status.show(answer.status, session.partCount > 0);
    this.status.showScale(answer.kind === "orbit" ? answer.units_per_px * session.pxPerCss : 0);
    this.panel.show(answer, session.summary);
    this.has_drawn = answer.drawn;
    if (answer.drawn) this.measure.draw(session.model, session.pxPerCss);
  }

  private click(x: number, y: number): void {
    const session = this.session;
    if (!session || !this.measure.isOn) return;
    const pick = session.model.pick(x * session.pxPerCss, y * session.pxPerCss);
    if (pick) this.measure.add(pick);
    else this.status.note("There is no surface at this place. Click the model.");
  }

  private chooseKind(kind: FrameAnswer["kind"]): void {
    const now = kCameraKinds.indexOf(this.answer?.kind ?? "orbit");
    const steps = (kCameraKinds.indexOf(kind) - now + kCameraKinds.length) % kCameraKinds.length;
    if (steps > 0) this.input.add({ next_camera: steps });
  }

  private setMemory(bytes: number): void {
    this.settings.memory_bytes = bytes;
    keepMemoryBytes(bytes);
    this.restart();
  }

  private async copyLink(): Promise<void> {
    const url = new URL(document.baseURI);
    url.search = "";
    url.hash = this.answer
      ? formatLink(this.name, this.answer.camera, this.settings.threshold_px, this.settings.show)
      : modelLink(this.name);
    const copied = await copyText(url.href);
    this.status.note(copied ? "The link to this view is copied." : `Copy this link: ${url.href}`);
  }

  private async findNativeLink(): Promise<void> {
    try {
      this.panel.setNativeLink(nativeLink(await fetchModels(), this.name));
    } catch (error) {
      // The stream says what else is wrong with the server.
      if (!this.is_closed && error instanceof HttpError && error.wantsToken) this.wantsToken();
    }
  }
}
