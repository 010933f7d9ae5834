import type { FrameInput } from "./contract";
import { HeldKeys, commandOf, isTyping, type Command } from "./keys";

/** Movement below which a press is a click, in CSS pixels. */
const kClickPx = 4;
/** Distance that a finger must move before it turns the model, in CSS pixels. */
const kTouchSlopPx = 6;
const kDoubleClickMs = 350;
const kDoubleClickPx = 30;
/** Wheel delta of one step, in pixels and in lines. */
const kStepPx = 100;
const kStepLines = 3;
const kPinchFactor = 0.85; // the core's zoom per wheel step
/** Turn by an arrow key in orbit, in CSS pixels per second. */
const kArrowPxPerS = 240;

interface Finger {
  x: number;
  y: number;
  start_x: number;
  start_y: number;
  is_drag: boolean;
  shifts: boolean;
}

export interface InputListener {
  /** A press and a release at one place, in CSS pixels of the stage. */
  click(x: number, y: number): void;
  command(command: Command): void;
}

/** Collects pointer, touch, wheel and keyboard input on the picture between two frames. */
export class Input {
  private readonly fingers = new Map<number, Finger>();
  private readonly keys = new HeldKeys();
  private pending: FrameInput = {};
  private pointer: [number, number] = [0, 0];
  private last_click = { x: 0, y: 0, at_ms: -Infinity };
  private last_pointer_type = "mouse";
  private readonly removers = new AbortController();

  constructor(
    private readonly stage: HTMLElement,
    private readonly listener: InputListener,
  ) {
    const options = { signal: this.removers.signal };
    stage.addEventListener("pointerdown", (event) => this.press(event), options);
    stage.addEventListener("pointermove", (event) => this.move(event), options);
    stage.addEventListener("pointerup", (event) => this.release(event, true), options);
    stage.addEventListener("pointercancel", (event) => this.release(event, false), options);
    stage.addEventListener("wheel", (event) => this.wheel(event), { ...options, passive: false });
    stage.addEventListener("contextmenu", (event) => event.preventDefault(), options);
    stage.addEventListener(
      "dblclick",
      (event) => {
        if (this.last_pointer_type === "mouse") this.pending.double_click_px = this.at(event);
      },
      options,
    );
    addEventListener("keydown", (event) => this.keyDown(event), options);
    addEventListener("keyup", (event) => this.keys.up(event), options);
    addEventListener("blur", () => this.keys.clear(), options);
  }

  dispose(): void {
    this.removers.abort();
  }

  /** Adds input of a button on the page to the next frame. */
  add(input: FrameInput): void {
    Object.assign(this.pending, input);
  }

  /** True if the next frame has input. */
  get hasInput(): boolean {
    return Object.keys(this.pending).length > 0 || this.keys.isMoving;
  }

  /**
   * Takes the input since the last call, in pixels of the picture.
   * @param orbits  true if arrow keys turn the camera; else they move it.
   */
  take(px_per_css: number, seconds: number, orbits: boolean): FrameInput {
    const input = this.pending;
    this.pending = {};
    const fly = this.keys.motion(orbits);
    if (fly.right !== 0 || fly.up !== 0 || fly.forward !== 0) input.fly = fly;
    if (orbits) {
      const [x, y] = this.keys.arrows();
      if (x !== 0 || y !== 0) {
        const css_px = kArrowPxPerS * seconds;
        add(input, "turned_px", x * css_px, y * css_px);
      }
    }
    input.pointer_px = this.pointer;
    for (const name of ["turned_px", "shifted_px", "pointer_px", "pressed_px", "double_click_px"] as const) {
      const value = input[name];
      if (value) input[name] = [value[0] * px_per_css, value[1] * px_per_css];
    }
    return input;
  }

  private at(event: MouseEvent): [number, number] {
    const box = this.stage.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  private press(event: PointerEvent): void {
    const [x, y] = (this.pointer = this.at(event));
    this.last_pointer_type = event.pointerType;
    const shifts = event.button !== 0 || event.shiftKey;
    this.fingers.set(event.pointerId, { x, y, start_x: x, start_y: y, is_drag: false, shifts });
    this.stage.setPointerCapture(event.pointerId);
    this.stage.focus({ preventScroll: true });
    if (this.fingers.size === 1) this.pending.pressed_px = [x, y];
    if (this.fingers.size === 2) {
      this.pending.pressed_px = this.pointer = this.middle();
      for (const finger of this.fingers.values()) finger.is_drag = true;
    }
    event.preventDefault();
  }

  private move(event: PointerEvent): void {
    const [x, y] = this.at(event);
    const finger = this.fingers.get(event.pointerId);
    if (!finger) {
      this.pointer = [x, y];
      return;
    }
    const moved_px = Math.hypot(x - finger.start_x, y - finger.start_y);
    if (!finger.is_drag && moved_px < (event.pointerType === "touch" ? kTouchSlopPx : 1)) return;
    finger.is_drag = true;
    if (this.fingers.size === 2) {
      this.pinch(finger, x, y);
      return;
    }
    this.pointer = [x, y];
    add(this.pending, finger.shifts ? "shifted_px" : "turned_px", x - finger.x, y - finger.y);
    finger.x = x;
    finger.y = y;
  }

  /** The midpoint of two fingers pans the picture, and the distance between them zooms. */
  private pinch(finger: Finger, x: number, y: number): void {
    const [from_x, from_y] = this.middle();
    const before_px = this.spread();
    finger.x = x;
    finger.y = y;
    const [to_x, to_y] = this.middle();
    const after_px = this.spread();
    add(this.pending, "shifted_px", to_x - from_x, to_y - from_y);
    if (before_px > 0 && after_px > 0)
      this.pending.wheel = (this.pending.wheel ?? 0) + Math.log(before_px / after_px) / Math.log(kPinchFactor);
    this.pointer = [to_x, to_y];
  }

  private release(event: PointerEvent, is_up: boolean): void {
    const finger = this.fingers.get(event.pointerId);
    if (!finger) return;
    this.fingers.delete(event.pointerId);
    for (const other of this.fingers.values()) {
      // The remaining finger starts a drag from its current place.
      this.pending.pressed_px = [other.x, other.y];
    }
    if (!is_up || finger.shifts) return;
    const [x, y] = this.at(event);
    const is_touch = event.pointerType === "touch";
    if (Math.hypot(x - finger.start_x, y - finger.start_y) > kClickPx || this.fingers.size > 0) return;
    if (!is_touch || !finger.is_drag) this.click(x, y, event.timeStamp, is_touch);
  }

  /** Detects double taps, because not all browsers report these; they report all double clicks of a mouse. */
  private click(x: number, y: number, at_ms: number, is_touch: boolean): void {
    const last = this.last_click;
    const is_near = Math.hypot(x - last.x, y - last.y) < kDoubleClickPx;
    const is_second = is_near && at_ms - last.at_ms < kDoubleClickMs;
    if (!is_second) this.listener.click(x, y);
    else if (is_touch) this.pending.double_click_px = [x, y];
    this.last_click = { x, y, at_ms: is_second ? -Infinity : at_ms };
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    this.pointer = this.at(event);
    const is_lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE;
    // Browsers report the pinch of a touchpad as a wheel with Ctrl and small deltas.
    const step = is_lines ? kStepLines : event.ctrlKey ? kStepPx / 8 : kStepPx;
    const steps = Math.max(-5, Math.min(5, -event.deltaY / step));
    this.pending.wheel = (this.pending.wheel ?? 0) + steps;
  }

  private keyDown(event: KeyboardEvent): void {
    if (isTyping(event)) return;
    const command = commandOf(event);
    if (command) {
      event.preventDefault();
      this.listener.command(command);
    } else if (this.keys.down(event)) {
      event.preventDefault();
    }
  }

  private middle(): [number, number] {
    let x = 0;
    let y = 0;
    for (const finger of this.fingers.values()) {
      x += finger.x / this.fingers.size;
      y += finger.y / this.fingers.size;
    }
    return [x, y];
  }

  private spread(): number {
    const [a, b] = [...this.fingers.values()];
    return a && b ? Math.hypot(a.x - b.x, a.y - b.y) : 0;
  }
}

/** Returns true if the input moves the camera continuously: a drag, the wheel or a movement key. */
export function movesCamera({ turned_px, shifted_px, wheel, fly }: FrameInput): boolean {
  return turned_px !== undefined || shifted_px !== undefined || wheel !== undefined || fly !== undefined;
}

function add(input: FrameInput, name: "turned_px" | "shifted_px", x: number, y: number): void {
  const [x_before, y_before] = input[name] ?? [0, 0];
  input[name] = [x_before + x, y_before + y];
}
