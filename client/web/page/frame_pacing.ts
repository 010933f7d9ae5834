/** Frames per second below which a moving picture is drawn coarser, and above which it gets finer again. */
const kSlowMs = 1000 / 24;
const kQuickMs = 1000 / 45;
const kCoarser = 1.25;
const kFiner = 1 / 1.1;
/** Largest factor on the error. */
const kMostFactor = 12;
/** Time without motion after which the picture gets as fine as asked for. */
const kRestMs = 300;
/** Weight of a frame in the mean of frame times. */
const kWeight = 0.25;

/** Raises the error threshold while the camera moves and frames take too long, as on slow graphics. */
export class FramePacing {
  private factor_ = 1;
  private mean_ms = 0;
  private last_moved_ms = -Infinity;
  private was_moving = false;

  /** The factor on the threshold; 1 while the camera rests. */
  get factor(): number {
    return this.factor_;
  }

  /** Takes a frame into account. @param moves  true if the camera moves in this frame. */
  update(now_ms: number, since_last_ms: number, moves: boolean): void {
    const goes_on = moves && this.was_moving;
    this.was_moving = moves;
    if (moves) this.last_moved_ms = now_ms;
    if (now_ms - this.last_moved_ms > kRestMs) {
      this.factor_ = 1;
      this.mean_ms = 0;
    }
    if (!goes_on) return; // the time since a frame of a resting camera tells nothing
    this.mean_ms = this.mean_ms === 0 ? since_last_ms : this.mean_ms + (since_last_ms - this.mean_ms) * kWeight;
    if (this.mean_ms > kSlowMs) this.factor_ = Math.min(kMostFactor, this.factor_ * kCoarser);
    else if (this.mean_ms < kQuickMs) this.factor_ = Math.max(1, this.factor_ * kFiner);
  }
}
