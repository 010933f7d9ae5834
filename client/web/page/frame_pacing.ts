/** Mean frame times above which a moving picture gets coarser, and below which it gets finer again. */
const kSlowMs = 1000 / 24;
const kQuickMs = 1000 / 45;
const kCoarser = 1.25;
const kFiner = 1 / 1.1;
/** Largest factor on the error threshold. */
const kMostFactor = 12;
/** Time without motion after which the factor returns to 1. */
const kRestMs = 500;
/** Weight of a frame in the mean of frame times. */
const kWeight = 0.25;

/** Raises the error threshold while the camera moves and frames take too long, as on slow graphics. */
export class FramePacing {
  private factor_ = 1;
  private mean_ms = 0;
  private last_moved_ms = -Infinity;

  /** The factor on the threshold; 1 while the camera rests. */
  get factor(): number {
    return this.factor_;
  }

  /** Notes whether the camera moves. Call before each frame. */
  update(now_ms: number, moves: boolean): void {
    if (moves) this.last_moved_ms = now_ms;
    if (now_ms - this.last_moved_ms <= kRestMs) return;
    this.factor_ = 1;
    this.mean_ms = 0;
  }

  /** Adds the time that the browser needed for a frame to the mean. */
  measure(now_ms: number, frame_ms: number): void {
    if (now_ms - this.last_moved_ms > kRestMs) return;
    this.mean_ms = this.mean_ms === 0 ? frame_ms : this.mean_ms + (frame_ms - this.mean_ms) * kWeight;
    if (this.mean_ms > kSlowMs) this.factor_ = Math.min(kMostFactor, this.factor_ * kCoarser);
    else if (this.mean_ms < kQuickMs) this.factor_ = Math.max(1, this.factor_ * kFiner);
  }
}
