/** The speeds that are offered; any other positive one plays as well. */
export const SPEEDS: readonly number[] = [0.1, 0.25, 0.5, 1, 2, 5, 10, 25, 100];

/** Where a recording is played, and how fast. It follows one that is still growing. */
export class Player {
  positionMs = 0;
  speed = 1;
  isPlaying = false;
  /** Stays at the end of what is being recorded. */
  isFollowing: boolean;

  constructor(isGrowing: boolean) {
    this.isFollowing = isGrowing;
  }

  /** Time went on by `passedMs`. */
  advance(passedMs: number, durationMs: number): void {
    if (this.isFollowing) {
      this.positionMs = durationMs;
    } else if (this.isPlaying) {
      this.positionMs = Math.min(durationMs, this.positionMs + passedMs * this.speed);
      if (this.positionMs >= durationMs) this.isPlaying = false;
    }
  }

  seek(positionMs: number, durationMs: number): void {
    this.isFollowing = false;
    this.positionMs = Math.min(durationMs, Math.max(0, positionMs));
  }

  /** At the end it begins anew. */
  toggle(durationMs: number): void {
    this.isFollowing = false;
    this.isPlaying = !this.isPlaying;
    if (this.isPlaying && this.positionMs >= durationMs) this.positionMs = 0;
  }

  /** The next speed in either direction. */
  changeSpeed(direction: 1 | -1): void {
    const faster = SPEEDS.filter((speed) => speed > this.speed);
    const slower = SPEEDS.filter((speed) => speed < this.speed);
    this.speed = (direction > 0 ? faster[0] : slower[slower.length - 1]) ?? this.speed;
  }

  follow(): void {
    this.isFollowing = true;
    this.isPlaying = false;
  }
}
