import type { ShowMode } from "./contract";
import { find } from "./dom";
import { report } from "./errors";
import type { Input } from "./input";
import type { Command } from "./keys";
import type { Measure } from "./measure";
import type { Panel } from "./panel";
import { kThresholdsPx, thresholdIndex, type Settings } from "./settings";

/** Runs the commands of keys and buttons. */
export class Commands {
  constructor(
    private readonly settings: Settings,
    private readonly input: Input,
    private readonly panel: Panel,
    private readonly measure: Measure,
  ) {}

  run(command: Command): void {
    switch (command.name) {
      case "camera":
        return this.input.add({ next_camera: 1 });
      case "reset":
        return this.input.add({ reset: true });
      case "axis":
        return this.input.add({ next_axis: 1 });
      case "parallel":
        return this.input.add({ parallel: true });
      case "side":
        return this.input.add({ side: command.side });
      case "show":
        return this.stepShow(command.steps);
      case "wireframe":
        return this.setShow(this.settings.show === "wireframe" ? "surface" : "wireframe");
      case "clay":
        return this.stepClay();
      case "finer":
        return this.stepThreshold(-1);
      case "coarser":
        return this.stepThreshold(1);
      case "measure":
        return this.toggleMeasure();
      case "remove_point":
        return this.measure.removeLast();
      case "escape":
        return this.measure.isOn ? this.toggleMeasure() : this.panel.close();
      case "panel":
        return this.panel.toggle();
      case "help":
        return find<HTMLDialogElement>("#help").showModal();
      case "full_screen":
        return void toggleFullScreen();
    }
  }

  private stepShow(steps: number): void {
    const modes = this.panel.modes();
    const index = (modes.indexOf(this.settings.show) + steps + modes.length) % modes.length;
    this.setShow(modes[index] ?? "surface");
  }

  private stepClay(): void {
    const now = this.settings.show;
    this.setShow(now === "clay" ? "matcap" : now === "matcap" ? "surface" : "clay");
  }

  private setShow(show: ShowMode): void {
    this.settings.show = show;
    this.panel.showSettings();
  }

  private stepThreshold(steps: number): void {
    const px = kThresholdsPx[thresholdIndex(this.settings.threshold_px) + steps];
    this.settings.threshold_px = px ?? this.settings.threshold_px;
    this.panel.showSettings();
  }

  private toggleMeasure(): void {
    this.measure.toggle();
    this.panel.setMeasuring(this.measure.isOn);
  }
}

async function toggleFullScreen(): Promise<void> {
  try {
    if (document.fullscreenElement) await document.exitFullscreen();
    else await document.documentElement.requestFullscreen();
  } catch (error) {
    report(error);
  }
}
