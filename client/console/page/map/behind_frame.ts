/**
 * Work that is done behind the page's next frame, once however often it is asked for: what somebody
 * pressed is shown in that frame, and does not wait for thousands of vehicles to be drawn.
 */
export class BehindFrame {
  private frame = 0;
  private task: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly work: () => void) {}

  /** Also from within the work itself, for the frame after. */
  ask(): void {
    if (this.frame !== 0) return;
    this.frame = requestAnimationFrame(() => {
      this.task = setTimeout(() => {
        this.frame = 0;
        this.work();
      }, 0);
    });
  }

  cancel(): void {
    cancelAnimationFrame(this.frame);
    clearTimeout(this.task);
    this.frame = 0;
  }
}
