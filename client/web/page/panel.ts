import { kSides, kShowModes, type CameraKind, type FrameAnswer, type ShowMode, type Summary } from "./contract";
import { element, find } from "./dom";
import type { Command } from "./keys";
import { kMemoryChoices, kThresholdsPx, thresholdIndex, type Settings } from "./settings";
import { formatBytes, formatTriangles } from "./words";

const kShowWords: Record<ShowMode, string> = {
  surface: "Surface",
  unlit: "Colours without light",
  wireframe: "Edges of triangles",
  normals: "Directions of the surface",
  texels: "Sharpness of images",
  nodes: "Parts",
  depths: "Depth in the tree",
  lods: "Levels of detail",
  errors: "Errors",
  clay: "Clay",
  matcap: "Studio light",
};

export interface PanelListener {
  /** A setting has changed: draw another frame. */
  changed(): void;
  memory(bytes: number): void;
  kind(kind: CameraKind): void;
  command(command: Command): void;
  copyLink(): void;
}

/** The controls of the viewer: tool bar and settings. */
export class Panel {
  private readonly panel = find("#panel");
  private readonly show_ = find<HTMLSelectElement>("#show");
  private readonly threshold = find<HTMLInputElement>("#threshold");
  private readonly memory = find<HTMLSelectElement>("#memory");
  private readonly removers = new AbortController();
  private summary: Summary | null = null;
  private legend = "";
  private kind: CameraKind | null = null;

  constructor(
    private readonly settings: Settings,
    private readonly listener: PanelListener,
  ) {
    this.fill();
    this.listen();
    this.showSettings();
    this.setMeasuring(false);
    this.setNativeLink(null);
    this.close();
  }

  dispose(): void {
    this.removers.abort();
  }

  /** Returns the modes that make sense for the model. */
  modes(): ShowMode[] {
    const summary = this.summary;
    return kShowModes.filter((mode) => {
      if (!summary) return true;
      if (mode === "texels") return summary.has_textures;
      return mode !== "unlit" || summary.has_textures || summary.has_colours;
    });
  }

  showSettings(): void {
    this.show_.value = this.settings.show;
    this.memory.value = String(this.settings.memory_bytes);
    this.threshold.value = String(thresholdIndex(this.settings.threshold_px));
    const px = `${Number(this.settings.threshold_px.toPrecision(3))} px`;
    find("#threshold_value").textContent = px;
    this.threshold.setAttribute("aria-valuetext", px);
    this.listener.changed();
  }

  /** Updates the controls from a frame's answer. */
  show(answer: FrameAnswer, summary: Summary | null): void {
    if (summary && summary !== this.summary) {
      this.summary = summary;
      this.fillModes();
      find("#about").textContent = `${formatTriangles(summary.triangles)} · ${formatBytes(summary.bytes)}`;
    }
    if (answer.kind !== this.kind) {
      this.kind = answer.kind;
      for (const button of document.querySelectorAll<HTMLElement>("[data-kind]"))
        button.setAttribute("aria-pressed", String(button.dataset["kind"] === answer.kind));
    }
    find("#parallel").setAttribute("aria-pressed", String(answer.parallel));
    if (answer.legend) this.showLegend(answer.legend);
  }

  setMeasuring(is_on: boolean): void {
    find("#tool_measure").setAttribute("aria-pressed", String(is_on));
    find("#stage").classList.toggle("measuring", is_on);
  }

  setNativeLink(link: string | null): void {
    const anchor = find<HTMLAnchorElement>("#native");
    anchor.hidden = link === null;
    if (link) anchor.href = link;
    else anchor.removeAttribute("href");
  }

  toggle(): void {
    this.setOpen(this.panel.hidden);
  }

  close(): void {
    this.setOpen(false);
  }

  private setOpen(is_open: boolean): void {
    this.panel.hidden = !is_open;
    find("#tool_panel").setAttribute("aria-expanded", String(is_open));
  }

  private fill(): void {
    this.memory.replaceChildren(
      ...kMemoryChoices.map((bytes) => element("option", { value: String(bytes) }, [formatBytes(bytes).replace(".0", "")])),
    );
    this.threshold.max = String(kThresholdsPx.length - 1);
    this.fillModes();
    find("#sides").replaceChildren(
      ...kSides.map((side) => {
        const button = element("button", { type: "button" }, [side.charAt(0).toUpperCase() + side.slice(1)]);
        this.on(button, "click", () => this.listener.command({ name: "side", side }));
        return button;
      }),
    );
    find("#tool_full").hidden = !document.fullscreenEnabled;
  }

  private fillModes(): void {
    this.show_.replaceChildren(
      ...this.modes().map((mode) => element("option", { value: mode }, [kShowWords[mode]])),
    );
    this.show_.value = this.settings.show;
  }

  private listen(): void {
    // Release the focus after a choice, because a focused list would receive the keys that move the camera.
    for (const list of [this.show_, this.memory]) {
      let has_keys = false;
      list.addEventListener("keydown", () => (has_keys = true), { signal: this.removers.signal });
      list.addEventListener("pointerdown", () => (has_keys = false), { signal: this.removers.signal });
      this.on(list, "change", () => has_keys || find("#stage").focus({ preventScroll: true }));
    }
    this.on(this.show_, "change", () => {
      this.settings.show = kShowModes.find((mode) => mode === this.show_.value) ?? "surface";
      this.listener.changed();
    });
    this.on(this.threshold, "input", () => {
      this.settings.threshold_px = kThresholdsPx[Number(this.threshold.value)] ?? 1;
      this.showSettings();
    });
    this.on(this.memory, "change", () => this.listener.memory(Number(this.memory.value)));
    for (const button of document.querySelectorAll<HTMLElement>("[data-kind]"))
      this.on(button, "click", () => this.listener.kind(button.dataset["kind"] as CameraKind));
    for (const button of document.querySelectorAll<HTMLElement>("[data-command]")) {
      const name = button.dataset["command"] as Exclude<Command["name"], "show" | "side">;
      this.on(button, "click", () => this.listener.command({ name }));
    }
    this.on(find("#copy_link"), "click", () => this.listener.copyLink());
  }

  private showLegend(entries: [colour: string, meaning: string][]): void {
    const key = JSON.stringify(entries);
    if (key === this.legend) return;
    this.legend = key;
    find("#legend").replaceChildren(
      ...entries.map(([colour, meaning]) => {
        const swatch = element("span", { class: "swatch" });
        swatch.style.background = colour;
        return element("li", {}, [swatch, meaning]);
      }),
    );
  }

  private on(target: EventTarget, type: string, handler: () => void): void {
    target.addEventListener(type, handler, { signal: this.removers.signal });
  }
}
