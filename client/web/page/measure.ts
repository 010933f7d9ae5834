import type { Pick, Vec3 } from "./contract";
import type { CoreModel } from "./core_model";
import { copyText, element, find } from "./dom";
import { formatLength, formatUncertainty } from "./words";

const kSvg = "http://www.w3.org/2000/svg";
const kRadiusPx = 5; // radius of a point's mark

/** Points that the user has clicked, the distances between them, and lines over the picture. */
export class Measure {
  private points: Pick[] = [];
  private is_on = false;
  private readonly box = find("#measure");
  private readonly list = find("#points");
  private readonly overlay = find<SVGSVGElement>("#overlay");
  private readonly removers = new AbortController();

  /** @param changed  called when the picture needs another frame. */
  constructor(private readonly changed: () => void) {
    const options = { signal: this.removers.signal };
    find("#measure_back").addEventListener("click", () => this.removeLast(), options);
    find("#measure_clear").addEventListener("click", () => this.clear(), options);
    find("#measure_copy").addEventListener("click", () => void copyText(this.text()), options);
    this.clear();
  }

  dispose(): void {
    this.removers.abort();
    this.is_on = false;
    this.clear();
  }

  get isOn(): boolean {
    return this.is_on;
  }

  toggle(): void {
    this.is_on = !this.is_on;
    this.list_();
  }

  add(pick: Pick): void {
    this.points.push(pick);
    this.list_();
  }

  removeLast(): void {
    this.points.pop();
    this.list_();
  }

  clear(): void {
    this.points = [];
    this.list_();
  }

  /** Draws the lines for the camera of the last frame. */
  draw(model: CoreModel, px_per_css: number): void {
    this.overlay.replaceChildren();
    if (!this.is_on || this.points.length === 0) return;
    const places = model.project(this.points.map(({ point }) => point)).map(([x, y, visible]) => ({
      x: x / px_per_css,
      y: y / px_per_css,
      visible,
    }));
    places.forEach((to, index) => {
      const from = places[index - 1];
      if (!from?.visible || !to.visible) return;
      this.overlay.append(shape("line", { x1: from.x, y1: from.y, x2: to.x, y2: to.y }));
      const label = shape("text", { x: (from.x + to.x) / 2, y: (from.y + to.y) / 2 - 8 });
      label.textContent = this.distance(index).text;
      this.overlay.append(label);
    });
    places.forEach(({ x, y, visible }, index) => {
      if (!visible) return;
      this.overlay.append(shape("circle", { cx: x, cy: y, r: kRadiusPx }));
      const label = shape("text", { x: x + 9, y: y + 14, class: "number" });
      label.textContent = String(index + 1);
      this.overlay.append(label);
    });
  }

  /** Returns the distance from the previous point. Its uncertainty is the sum of the points'. */
  private distance(index: number): { text: string; value: number; uncertainty: number } {
    const from = this.points[index - 1];
    const to = this.points[index];
    if (!from || !to) return { text: "", value: 0, uncertainty: 0 };
    const value = Math.hypot(...to.point.map((c, axis) => c - (from.point[axis] ?? 0)));
    const uncertainty = from.off_model + to.off_model;
    return { value, uncertainty, text: formatLength(value, uncertainty) };
  }

  private list_(): void {
    this.changed();
    this.box.hidden = !this.is_on;
    find("#measure_hint").hidden = this.points.length > 1;
    find("#measure_hint").textContent =
      this.points.length === 0
        ? "Click a point of the model to see its coordinates."
        : "Click another point to see the distance.";
    for (const id of ["#measure_back", "#measure_clear", "#measure_copy"])
      find<HTMLButtonElement>(id).disabled = this.points.length === 0;
    const rows = this.points.flatMap((pick, index) => {
      const row = element("li", {}, [
        element("b", {}, [String(index + 1)]),
        element("span", { class: "value" }, [coordinates(pick, "  ")]),
        copyButton(coordinates(pick, ", "), `Copy the coordinates of point ${index + 1}`),
      ]);
      if (index === 0) return [row];
      const { text, uncertainty } = this.distance(index);
      const words = `${text} ± ${formatUncertainty(uncertainty)}`;
      const line = element("li", { class: "distance" }, [
        element("b", {}, ["↔"]),
        element("span", { class: "value" }, [words]),
        copyButton(text, `Copy the distance from point ${index} to point ${index + 1}`),
      ]);
      return [line, row];
    });
    if (this.points.length > 2) rows.push(element("li", { class: "sum" }, [element("span", {}, [this.total()])]));
    this.list.replaceChildren(...rows);
    this.list.scrollTop = this.list.scrollHeight;
  }

  private total(): string {
    let sum = 0;
    let uncertainty = 0;
    for (let index = 1; index < this.points.length; ++index) {
      const part = this.distance(index);
      sum += part.value;
      uncertainty += part.uncertainty;
    }
    return `Together ${formatLength(sum, uncertainty)} ± ${formatUncertainty(uncertainty)}`;
  }

  /** Returns all points and distances as lines of text with tabs, for spreadsheets. */
  private text(): string {
    const lines = ["x\ty\tz\tuncertainty\tdistance"];
    this.points.forEach((pick, index) => {
      const distance = index > 0 ? this.distance(index).text : "";
      lines.push([coordinates(pick, "\t"), formatUncertainty(pick.off_model), distance].join("\t"));
    });
    return lines.join("\n");
  }
}

function coordinates({ point, off_model }: Pick, separator: string): string {
  return (point satisfies Vec3).map((value) => formatLength(value, off_model)).join(separator);
}

function copyButton(text: string, label: string): HTMLButtonElement {
  const button = element("button", { type: "button", class: "copy", "aria-label": label, title: label }, ["Copy"]);
  button.addEventListener("click", () => {
    void copyText(text).then((copied) => {
      button.textContent = copied ? "Copied" : "Not allowed";
      window.setTimeout(() => (button.textContent = "Copy"), 1500);
    });
  });
  return button;
}

function shape(name: string, attributes: Record<string, string | number>): SVGElement {
  const made = document.createElementNS(kSvg, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
  return made;
}
