import { kSides, type FlyKeys, type Side } from "./contract";

/** A command of the keyboard that is not a movement. */
export type Command =
  | { name: "camera" | "reset" | "axis" | "parallel" | "panel" | "help" | "full_screen" | "escape" }
  | { name: "measure" | "remove_point" | "wireframe" | "clay" | "finer" | "coarser" }
  | { name: "show"; steps: number }
  | { name: "side"; side: Side };

/** The keys of `lodestream view`, except those that browsers use themselves. */
const kCommands: Record<string, Command> = {
  c: { name: "camera" },
  r: { name: "reset" },
  u: { name: "axis" },
  n: { name: "parallel" },
  p: { name: "parallel" },
  h: { name: "panel" },
  o: { name: "panel" },
  m: { name: "measure" },
  backspace: { name: "remove_point" },
  v: { name: "show", steps: 1 },
  f: { name: "wireframe" },
  g: { name: "clay" },
  "+": { name: "finer" },
  "=": { name: "finer" },
  "-": { name: "coarser" },
  "?": { name: "help" },
  f1: { name: "help" },
  escape: { name: "escape" },
};

/** Movement keys by their position, so that they form the same block on all keyboard layouts. */
const kMoves: Record<string, [axis: "right" | "up" | "forward", amount: number]> = {
  KeyW: ["forward", 1],
  KeyS: ["forward", -1],
  KeyA: ["right", -1],
  KeyD: ["right", 1],
  KeyQ: ["up", -1],
  KeyE: ["up", 1],
};
const kArrows: Record<string, [x: number, y: number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

/** Returns the command of a key, or null. Leaves combinations with Ctrl, Alt and Meta to the browser. */
export function commandOf(event: KeyboardEvent): Command | null {
  if (event.ctrlKey || event.altKey || event.metaKey) return null;
  const key = event.key.toLowerCase();
  if (key === "v" && event.shiftKey) return { name: "show", steps: -1 };
  const side = kSides[Number(key) - 1];
  if (side) return { name: "side", side };
  // The letter keys that move keep their place: on AZERTY, "a" is where "q" is.
  if (kMoves[event.code]) return null;
  return kCommands[key] ?? null;
}

/** Keys that move a slider. */
const kSliderKeys = /^(Arrow|Page|Home|End)/;

/** Returns true if a key goes to a text box, a list or a slider instead of the picture. */
export function isTyping(event: KeyboardEvent): boolean {
  const target = event.target;
  if (!(target instanceof HTMLElement)) return false;
  if (target.closest("dialog")) return true;
  if (target.matches("input[type=range]")) return kSliderKeys.test(event.key);
  const is_field = target.matches("input, select, textarea, [contenteditable]");
  return is_field && event.key !== "Escape";
}

/** The movement keys that are held down. */
export class HeldKeys {
  private held = new Set<string>();
  private is_fast = false;

  /** Returns true if the key moves the camera. */
  down(event: KeyboardEvent): boolean {
    this.is_fast = event.shiftKey;
    if (event.ctrlKey || event.altKey || event.metaKey) return false;
    if (!kMoves[event.code] && !kArrows[event.code]) return false;
    this.held.add(event.code);
    return true;
  }

  up(event: KeyboardEvent): void {
    this.is_fast = event.shiftKey;
    this.held.delete(event.code);
  }

  /** Releases all keys, because a window without focus receives no key releases. */
  clear(): void {
    this.held.clear();
  }

  get isMoving(): boolean {
    return this.held.size > 0;
  }

  /** Returns the movement. @param without_arrows  true if arrow keys turn the camera. */
  motion(without_arrows: boolean): FlyKeys {
    const keys: FlyKeys = { right: 0, up: 0, forward: 0, fast: this.is_fast };
    for (const code of this.held) {
      const move = kMoves[code];
      if (move) keys[move[0]] += move[1];
    }
    if (!without_arrows) {
      const [x, y] = this.arrows();
      keys.right += x;
      keys.forward -= y;
    }
    for (const axis of ["right", "up", "forward"] as const) keys[axis] = Math.max(-1, Math.min(1, keys[axis]));
    return keys;
  }

  /** Returns the direction of the arrow keys, y down. */
  arrows(): [x: number, y: number] {
    const sum: [number, number] = [0, 0];
    for (const code of this.held) {
      const arrow = kArrows[code];
      if (!arrow) continue;
      sum[0] += arrow[0];
      sum[1] += arrow[1];
    }
    return sum;
  }
}
