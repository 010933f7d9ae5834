/** Numbers and states in the words of users. */

import type { Status } from "./contract";

const kWhole = new Intl.NumberFormat("en-US", { maximumFractionDigits: 0 });

export function formatCount(value: number): string {
  return kWhole.format(value);
}

/** Returns "362,818 triangles" or "2.4 M triangles". */
export function formatTriangles(count: number): string {
  if (count < 1e6) return `${formatCount(count)} triangle${count === 1 ? "" : "s"}`;
  if (count < 1e9) return `${(count / 1e6).toFixed(count < 1e8 ? 1 : 0)} M triangles`;
  return `${(count / 1e9).toFixed(1)} billion triangles`;
}

export function formatBytes(bytes: number): string {
  if (bytes < 1000) return `${bytes} B`;
  if (bytes < 1e6) return `${(bytes / 1e3).toFixed(0)} KB`;
  if (bytes < 1e9) return `${(bytes / 1e6).toFixed(bytes < 1e8 ? 1 : 0)} MB`;
  return `${(bytes / 1e9).toFixed(1)} GB`;
}

/** Rounds an error up, so that the shown value is still a bound. */
export function formatErrorPx(error_px: number): string {
  if (!Number.isFinite(error_px)) return "–";
  if (error_px <= 0) return "0 px";
  const digits = error_px < 10 ? 2 : error_px < 100 ? 1 : 0;
  const scale = 10 ** digits;
  return `${(Math.ceil(error_px * scale - 1e-9) / scale).toFixed(digits)} px`;
}

/** Formats a length or coordinate so that its last digit is not finer than its uncertainty. */
export function formatLength(value: number, uncertainty: number): string {
  const digits = uncertainty > 0 ? Math.max(0, Math.min(9, Math.ceil(-Math.log10(uncertainty)) + 1)) : 4;
  return value.toFixed(digits);
}

/** Formats an uncertainty, rounded up to two digits. */
export function formatUncertainty(value: number): string {
  if (!(value > 0)) return "0";
  const scale = 10 ** (1 - Math.floor(Math.log10(value)));
  return String(Number((Math.ceil(value * scale - 1e-9) / scale).toPrecision(2)));
}

/** Returns the line in the corner: error, triangles and bytes. */
export function statusLine(status: Status): string {
  const parts = [
    formatErrorPx(status.error_px),
    formatTriangles(status.triangles),
    formatBytes(status.received_bytes),
  ];
  return parts.join(" · ");
}

/** Returns the meaning of the line in the corner. */
export function explain(status: Status): string {
  const error = formatErrorPx(status.error_px);
  const triangles = formatTriangles(status.triangles);
  return `Measured: the shown surface is at most ${error} away from the original. It has ${triangles}; ${formatBytes(status.received_bytes)} were received.`;
}

/** Returns what the viewer does now, or "" if the picture is as sharp as asked for. */
export function activity(status: Status): string {
  if (status.tiles_left_out > 0 || (status.limited && !status.converged)) return "The memory limit keeps the picture coarser. Allow more under Detail.";
  return status.converged ? "" : "Sharpening…";
}

/** Returns how much of the way to the threshold is done, from 0 to 1, on a logarithmic scale. */
export function progress(status: Status, first_error_px: number): number {
  if (status.converged || !(status.error_px > status.threshold_px)) return 1;
  const whole = Math.log(first_error_px / status.threshold_px);
  return whole > 0 ? Math.max(0.02, 1 - Math.log(status.error_px / status.threshold_px) / whole) : 0.02;
}
