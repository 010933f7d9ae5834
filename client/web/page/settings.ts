import type { ShowMode } from "./contract";

/** Choices of the user for one model's picture. */
export interface Settings {
  threshold_px: number;
  show: ShowMode;
  memory_bytes: number;
}

/** Errors that the slider offers, in pixels. */
export const kThresholdsPx: readonly number[] = [0.5, 0.7, 1, 1.4, 2, 2.8, 4, 5.6, 8, 11, 16];
export const kMemoryChoices: readonly number[] = [128e6, 256e6, 512e6, 1e9];
const kDefaultThresholdPx = 1;
const kMemoryKey = "lodestream-memory";

export function defaultSettings(): Settings {
  return { threshold_px: kDefaultThresholdPx, show: "surface", memory_bytes: memoryBytes() };
}

/** Returns the index of the slider's value that is nearest to a threshold. */
export function thresholdIndex(threshold_px: number): number {
  const distance = (px: number) => Math.abs(Math.log(px / threshold_px));
  let nearest = 0;
  kThresholdsPx.forEach((px, index) => {
    if (distance(px) < distance(kThresholdsPx[nearest] ?? px)) nearest = index;
  });
  return nearest;
}

export function keepMemoryBytes(bytes: number): void {
  try {
    localStorage.setItem(kMemoryKey, String(bytes));
  } catch {
    // Storage is switched off: the choice lasts until the page is left.
  }
}

/** Returns the chosen memory limit, or a smaller default on phones and tablets. */
function memoryBytes(): number {
  let kept = 0;
  try {
    kept = Number(localStorage.getItem(kMemoryKey));
  } catch {
    // Storage is switched off.
  }
  if (kMemoryChoices.includes(kept)) return kept;
  return matchMedia("(pointer: coarse)").matches ? 256e6 : 1e9;
}
