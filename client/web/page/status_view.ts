import type { Status } from "./contract";
import { find } from "./dom";
import { activity, explain, progress, statusLine } from "./words";

/** Time for which a note is visible. */
const kNoteMs = 4000;
/** Largest width of the scale bar, in CSS pixels. */
const kScalePx = 140;

/** The corner with the certified error, the scale bar, and messages over the picture. */
export class StatusView {
  private first_error_px = 0;
  private note_timer = 0;
  private said = "";
  private failed = false;
  private explanation = "";
  private readonly removers = new AbortController();

  /** @param retry  called when the user asks to connect again. */
  constructor(retry: () => void) {
    const options = { signal: this.removers.signal };
    find("#banner_retry").addEventListener("click", () => retry(), options);
    find("#line").addEventListener("click", () => this.note(this.explanation), options);
  }

  dispose(): void {
    this.removers.abort();
    clearTimeout(this.note_timer);
    find("#note").hidden = true;
    find("#scale").hidden = true;
    find("#line").textContent = "";
    this.trouble("");
  }

  loading(name: string): void {
    find("#loading_text").textContent = `Loading ${name}…`;
    find("#loading").hidden = false;
    this.say("");
  }

  /** Starts the progress again: the first error of the new session counts as 0 %. */
  restarted(): void {
    this.failed = false;
    this.first_error_px = 0;
    this.trouble("");
  }

  show(status: Status, has_picture: boolean): void {
    if (has_picture) find("#loading").hidden = true;
    if (!this.failed) this.trouble(describe(status));
    if (!has_picture) return;
    this.first_error_px = Math.max(this.first_error_px, status.error_px);
    const line = statusLine(status);
    const corner = find("#line");
    if (corner.textContent !== line) corner.textContent = line;
    this.explanation = explain(status);
    this.say(this.failed ? "" : activity(status));
    const part = this.failed ? 1 : progress(status, this.first_error_px);
    const bar = find("#progress");
    bar.style.width = `${(100 * part).toFixed(1)}%`;
    bar.classList.toggle("done", part >= 1);
  }

  /** Shows a bar with a round length. @param units_per_px  model units per CSS pixel; 0 hides the bar. */
  showScale(units_per_px: number): void {
    const scale = find("#scale");
    scale.hidden = !(units_per_px > 0);
    if (scale.hidden) return;
    const most = units_per_px * kScalePx;
    const power = 10 ** Math.floor(Math.log10(most));
    const length = power * (most >= 5 * power ? 5 : most >= 2 * power ? 2 : 1);
    scale.style.width = `${(length / units_per_px).toFixed(1)}px`;
    const text = String(Number(length.toPrecision(2)));
    if (scale.textContent !== text) scale.textContent = text;
  }

  /** Shows a problem above the picture, or nothing if the text is empty. */
  trouble(text: string): void {
    find("#banner").hidden = text === "";
    find("#banner_retry").hidden = true;
    if (find("#banner_text").textContent !== text) find("#banner_text").textContent = text;
  }

  /** Says why the viewer has stopped. @param remedy  a sentence that says what to do. */
  fail(text: string, can_retry: boolean, remedy = ""): void {
    if (!this.failed) {
      find("#loading").hidden = true;
      this.trouble(`${sentence(text)} ${remedy}`.trim());
      find("#banner_retry").hidden = !can_retry;
      this.say("");
    }
    this.failed = true;
  }

  /** Shows a short message for a moment. */
  note(text: string): void {
    const note = find("#note");
    note.textContent = text;
    note.hidden = false;
    clearTimeout(this.note_timer);
    this.note_timer = window.setTimeout(() => (note.hidden = true), kNoteMs);
  }

  /** Shows the viewer's activity. Skips equal texts, because screen readers read every change. */
  private say(text: string): void {
    if (text === this.said) return;
    this.said = text;
    find("#activity").textContent = text;
  }
}

/** Returns a sentence about a stream's problem, or "". */
function describe(status: Status): string {
  if (status.failure) return sentence(status.failure);
  if (status.trouble) return troubleWords(status.trouble);
  if (status.lost_tiles > 0) return "Some images of the surface cannot be read. Reload the page to try again.";
  return "";
}

/** Returns a sentence about a missing connection, or "". */
export function troubleWords(why: string): string {
  return why ? `${sentence(why)} The viewer tries again by itself.` : "";
}

function sentence(text: string): string {
  const trimmed = text.trim();
  return trimmed.charAt(0).toUpperCase() + trimmed.slice(1) + (/[.!?]$/.test(trimmed) ? "" : ".");
}
